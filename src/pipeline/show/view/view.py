"""Shows the results beside this file: the deformed shape, the finite elements with their mesh, the material
points as squares, coloured by damage (or by displacement, where nothing breaks), broken bonds as lines.

    peristitch view PIPELINE                   ParaView, with this prepared
    paraview --script=view.py                  the same; in ParaView: Tools, Python Shell, Run Script
    pvpython view.py picture.png [STEP]        a picture, by ParaView
    python3 view.py picture.png [STEP]         a picture, by VTK's Python package (pip install vtk)
    python3 view.py --describe                 the parts at each step, as JSON

Everything is in SI units.
"""

import json
import os
import sys
import xml.etree.ElementTree

# HEAD
SIZE = [1600, 1400]
# So much larger than their area are the squares: no hairs between them where the body is stretched.
WIDER = 1.12
VIRIDIS = [
    [0.267004, 0.004874, 0.329415], [0.282327, 0.094955, 0.417331], [0.278826, 0.175490, 0.483397],
    [0.258965, 0.251537, 0.524736], [0.229739, 0.322361, 0.545706], [0.199430, 0.387607, 0.554642],
    [0.172719, 0.448791, 0.557885], [0.149039, 0.508051, 0.557250], [0.127568, 0.566949, 0.550556],
    [0.120638, 0.625828, 0.533488], [0.157851, 0.683765, 0.501686], [0.246070, 0.738910, 0.452024],
    [0.369214, 0.788888, 0.382914], [0.515992, 0.831158, 0.294279], [0.678489, 0.863742, 0.189503],
    [0.845561, 0.887322, 0.099702], [0.993248, 0.906157, 0.143936],
]
INK = [0.15, 0.16, 0.17]
EDGES = [0.44, 0.47, 0.51]
PLAIN = [0.93, 0.94, 0.95]
BROKEN = [0.78, 0.12, 0.18]


def folder():
    if "PERISTITCH_RESULTS" in os.environ:
        return os.environ["PERISTITCH_RESULTS"]
    # ParaView's Run Script knows no file: the working folder it is then.
    return os.path.dirname(os.path.abspath(globals().get("__file__", "view.py")))


def series():
    """Time -> part's name -> file, as the .pvd lists them."""
    tree = xml.etree.ElementTree.parse(os.path.join(folder(), NAME + ".pvd"))
    found = {}
    for entry in tree.iter("DataSet"):
        parts = found.setdefault(float(entry.get("timestep")), {})
        parts[entry.get("name")] = os.path.join(folder(), entry.get("file"))
    return dict(sorted(found.items()))


def chosen(step):
    """The time to show: that of the step, or the last."""
    times = list(series())
    if step is None:
        return times[-1]
    if step not in times:
        sys.exit("there is no step %g; there are: %s" % (step, ", ".join("%g" % t for t in times)))
    return step


def shown():
    """Array, component (None: magnitude), range (None: its own), and the colour bar's title."""
    if HAS_DAMAGE and HAS_POINTS:
        return ["damage", 0, [0.0, 1.0], "damage"]
    if HAS_DISPLACEMENT:
        return ["displacement", None, None, "displacement [m]"]
    return ["region_id", 0, None, "region"]


def behind(bounds):
    """How far behind the rest the broken bonds lie: they show where a crack gapes."""
    return 1e-3 * max(bounds[1] - bounds[0], bounds[3] - bounds[2])


def title(time):
    many = len(series()) > 1
    return NAME + (", step %g" % time if many else "")


# ---- ParaView


def show_in_paraview(picture, step):
    from paraview import simple as pv

    pv._DisableFirstRenderCameraReset()
    view = pv.GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.InteractionMode = "2D"
    view.OrientationAxesVisibility = 0
    if picture:
        view.ViewSize = SIZE
    time = chosen(step)
    scene = pv.GetAnimationScene()
    reader = pv.PVDReader(registrationName=NAME, FileName=os.path.join(folder(), NAME + ".pvd"))
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.AnimationTime = time
    view.ViewTime = time
    reader.UpdatePipeline(time)

    array, component, limits, words = shown()
    colours = pv.GetColorTransferFunction(array)
    colours.ApplyPreset("Viridis (matplotlib)", True)

    def part(name):
        # ParaView drops blanks from the names of blocks.
        block = pv.ExtractBlock(registrationName=name, Input=reader, Selectors=["/Root/" + name.replace(" ", "")])
        if not HAS_DISPLACEMENT:
            return block
        warp = pv.WarpByVector(registrationName=name + ", deformed", Input=block)
        warp.Vectors = ["POINTS", "displacement"]
        warp.ScaleFactor = EXAGGERATION
        return warp

    def flat(source):
        display = pv.Show(source, view)
        # No light: a colour is the bar's colour.
        display.Ambient, display.Diffuse, display.Specular = 1.0, 0.0, 0.0
        return display

    def coloured(display):
        pv.ColorBy(display, ("POINTS", array, "Magnitude") if component is None else ("POINTS", array))

    if HAS_ELEMENTS:
        elements = part("finite elements")
        display = flat(elements)
        display.Representation = "Surface With Edges"
        display.NonlinearSubdivisionLevel = 0
        display.EdgeColor = EDGES
        if array == "displacement":
            coloured(display)
        else:
            display.ColorArrayName = ["POINTS", ""]
            display.AmbientColor = display.DiffuseColor = PLAIN
    if HAS_POINTS:
        points = part("material points")
        sized = pv.Calculator(registrationName="side", Input=points)
        sized.ResultArrayName = "side"
        sized.Function = "sqrt(area)"
        squares = pv.Glyph(registrationName="points as squares", Input=sized, GlyphType="2D Glyph")
        squares.GlyphType.GlyphType = "Square"
        squares.GlyphType.Filled = 1
        squares.OrientationArray = ["POINTS", "No orientation array"]
        squares.ScaleArray = ["POINTS", "side"]
        squares.ScaleFactor = WIDER
        squares.GlyphMode = "All Points"
        coloured(flat(squares))
    if HAS_BONDS and HAS_DAMAGE:
        broken = pv.Threshold(registrationName="broken bonds", Input=part("bonds"))
        broken.Scalars = ["CELLS", "intact"]
        broken.LowerThreshold, broken.UpperThreshold = -0.5, 0.5
        display = flat(broken)
        display.ColorArrayName = ["POINTS", ""]
        display.AmbientColor = display.DiffuseColor = BROKEN
        display.Opacity = 0.3
        display.Position = [0.0, 0.0, -behind(reader.GetDataInformation().GetBounds())]
    if limits:
        colours.RescaleTransferFunction(*limits)
    bar = pv.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = words, ""
    bar.TitleColor = bar.LabelColor = INK
    bar.TitleFontSize = bar.LabelFontSize = 26 if picture else 16
    bar.WindowLocation = "Any Location"
    bar.Position = [0.87, 0.2]
    bar.ScalarBarLength = 0.6
    bar.AutomaticLabelFormat = 0
    bar.LabelFormat = bar.RangeLabelFormat = "%-#.3g"
    bar.Visibility = 1
    if len(series()) > 1:
        # It follows the time bar.
        text = pv.AnnotateTimeFilter(registrationName="title", Input=reader)
        text.Format = NAME + (", step {time:g}" if pv.GetParaViewVersion() >= (5, 11) else ", step %g")
    else:
        text = pv.Text(registrationName="title")
        text.Text = NAME
    display = pv.Show(text, view)
    display.Color = INK
    display.FontSize = 26 if picture else 16
    display.WindowLocation = "Upper Left Corner"
    pv.Render(view)
    pv.ResetCamera(view)
    # The body in the left of the picture, the bar at its right.
    camera = view.GetActiveCamera()
    scale, shift = camera.GetParallelScale(), 0.12 * camera.GetParallelScale()
    view.CameraParallelScale = 0.85 * scale
    for place in ["CameraPosition", "CameraFocalPoint"]:
        x, y, z = getattr(view, place)
        setattr(view, place, [x + shift, y, z])
    if picture:
        pv.SaveScreenshot(picture, view, ImageResolution=SIZE)


# ---- VTK


def read(file):
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(file)
    reader.Update()
    return reader.GetOutput()


def warped(grid):
    from vtkmodules.vtkFiltersGeneral import vtkWarpVector

    if not HAS_DISPLACEMENT:
        return grid
    grid.GetPointData().SetActiveVectors("displacement")
    warp = vtkWarpVector()
    warp.SetInputData(grid)
    warp.SetScaleFactor(EXAGGERATION)
    warp.Update()
    return warp.GetOutput()


def squares(grid):
    """Each point as a square of its area."""
    from vtkmodules.vtkCommonCore import vtkDoubleArray
    from vtkmodules.vtkFiltersCore import vtkGlyph3D
    from vtkmodules.vtkFiltersSources import vtkGlyphSource2D

    area = grid.GetPointData().GetArray("area")
    side = vtkDoubleArray()
    side.SetName("side")
    side.SetNumberOfValues(area.GetNumberOfTuples())
    for index in range(area.GetNumberOfTuples()):
        side.SetValue(index, WIDER * area.GetValue(index) ** 0.5)
    grid.GetPointData().AddArray(side)
    source = vtkGlyphSource2D()
    source.SetGlyphTypeToSquare()
    source.FilledOn()
    glyph = vtkGlyph3D()
    glyph.SetInputData(grid)
    glyph.SetSourceConnection(source.GetOutputPort())
    glyph.SetInputArrayToProcess(0, 0, 0, 0, "side")
    glyph.SetScaleModeToScaleByScalar()
    glyph.OrientOff()
    glyph.FillCellDataOn()
    glyph.Update()
    return glyph.GetOutput()


def largest(grids, array, component):
    """Least and largest value of an array, over all grids."""
    ranges = [g.GetPointData().GetArray(array).GetRange(-1 if component is None else component) for g in grids]
    return [min(low for low, _ in ranges), max(high for _, high in ranges)]


def draw_with_vtk(picture, step):
    import vtkmodules.vtkRenderingFreeType  # noqa: F401
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkCommonCore import vtkLookupTable
    from vtkmodules.vtkFiltersCore import vtkThreshold
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
    from vtkmodules.vtkRenderingCore import (
        vtkActor, vtkDataSetMapper, vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter,
    )

    time = chosen(step)
    parts = {name: warped(read(file)) for name, file in series()[time].items()}
    array, component, limits, words = shown()
    renderer = vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    table = vtkLookupTable()
    table.SetNumberOfTableValues(256)
    for index in range(256):
        place = index / 255 * (len(VIRIDIS) - 1)
        k = min(int(place), len(VIRIDIS) - 2)
        mixed = [a + (place - k) * (b - a) for a, b in zip(VIRIDIS[k], VIRIDIS[k + 1])]
        table.SetTableValue(index, *mixed, 1.0)

    def add(data, plain, edges=None, opacity=1.0, on_cells=False, depth=0.0):
        surface = vtkDataSetSurfaceFilter()
        surface.SetInputData(data)
        # The sides of elements, not of the triangles that a bent one is drawn as.
        surface.SetNonlinearSubdivisionLevel(0)
        mapper = vtkDataSetMapper()
        mapper.SetInputConnection(surface.GetOutputPort())
        if plain is None:
            if on_cells:
                mapper.SetScalarModeToUseCellFieldData()
            else:
                mapper.SetScalarModeToUsePointFieldData()
            mapper.SelectColorArray(array)
            mapper.SetLookupTable(table)
            mapper.UseLookupTableScalarRangeOn()
        else:
            mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.SetPosition(0.0, 0.0, -depth)
        drawn = actor.GetProperty()
        drawn.LightingOff()
        drawn.SetOpacity(opacity)
        if plain is not None:
            drawn.SetColor(*plain)
        if edges:
            drawn.EdgeVisibilityOn()
            drawn.SetEdgeColor(*edges)
        renderer.AddActor(actor)

    everywhere = array == "displacement"
    used = [g for name, g in parts.items() if name == "material points" or everywhere and name != "bonds"]
    table.SetRange(*(limits or (largest(used, array, component) if used else [0.0, 1.0])))
    if component is None:
        table.SetVectorModeToMagnitude()
    if HAS_ELEMENTS:
        add(parts["finite elements"], None if everywhere else PLAIN, EDGES)
    if HAS_POINTS:
        add(squares(parts["material points"]), None, on_cells=True)
    if HAS_BONDS and HAS_DAMAGE:
        broken = vtkThreshold()
        broken.SetInputData(parts["bonds"])
        broken.SetInputArrayToProcess(0, 0, 0, 1, "intact")
        broken.SetThresholdFunction(vtkThreshold.THRESHOLD_LOWER)
        broken.SetLowerThreshold(0.5)
        broken.Update()
        add(broken.GetOutput(), BROKEN, opacity=0.3, depth=behind(parts["bonds"].GetBounds()))
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle(words)
    bar.SetNumberOfLabels(6)
    bar.SetUnconstrainedFontSize(True)
    bar.SetPosition(0.87, 0.12)
    bar.SetWidth(0.1)
    bar.SetHeight(0.76)
    text = vtkTextActor()
    text.SetInput(title(time))
    text.SetPosition(40, SIZE[1] - 70)
    for style in [bar.GetTitleTextProperty(), bar.GetLabelTextProperty(), text.GetTextProperty()]:
        style.SetColor(*INK)
        style.SetFontSize(32)
        style.ItalicOff()
        style.BoldOff()
        style.ShadowOff()
    renderer.AddViewProp(bar)
    renderer.AddViewProp(text)
    # The body in the left 85 % of the picture.
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    renderer.ResetCamera()
    left, right, bottom, top = renderer.ComputeVisiblePropBounds()[:4]
    across = 0.80 * SIZE[0] / SIZE[1]
    camera.SetParallelScale(0.55 * max(top - bottom, (right - left) / across))
    shift = 0.07 * 2.0 * camera.GetParallelScale() * SIZE[0] / SIZE[1]
    middle = [(left + right) / 2.0 + shift, (bottom + top) / 2.0]
    camera.SetFocalPoint(*middle, 0.0)
    camera.SetPosition(*middle, 1.0)
    renderer.ResetCameraClippingRange()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(*SIZE)
    window.AddRenderer(renderer)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetFileName(picture)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


def describe():
    """Of each part at each time: points, cells, arrays with their range (of a vector's or tensor's: by component)."""

    def arrays(data):
        found = {}
        for index in range(data.GetNumberOfArrays()):
            array = data.GetArray(index)
            count = array.GetNumberOfComponents()
            found[array.GetName()] = [list(array.GetRange(k)) for k in range(count)]
        return found

    def part(file):
        grid = read(file)
        return {
            "points": grid.GetNumberOfPoints(),
            "cells": grid.GetNumberOfCells(),
            "point_data": arrays(grid.GetPointData()),
            "cell_data": arrays(grid.GetCellData()),
        }

    listed = [
        {"time": time, "parts": {name: part(file) for name, file in parts.items()}}
        for time, parts in series().items()
    ]
    print(json.dumps(listed))


def main():
    # ParaView itself may pass its own.
    arguments = [text for text in getattr(sys, "argv", [""])[1:] if not text.startswith("--script")]
    if arguments == ["--describe"]:
        return describe()
    picture = os.path.abspath(arguments[0]) if arguments else os.environ.get("PERISTITCH_PNG")
    step = float(arguments[1]) if len(arguments) > 1 else None
    try:
        import paraview.simple  # noqa: F401
    except ImportError:
        if not picture:
            sys.exit(__doc__)
        return draw_with_vtk(picture, step)
    show_in_paraview(picture, step)


main()
