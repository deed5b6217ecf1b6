"""The crack paths that tests/gallery.rs compares with, by linear elastic fracture mechanics.

    .venv/bin/python3 tests/python/crack_path.py peristitch hole     # geo/crack_past_hole.geo
    .venv/bin/python3 tests/python/crack_path.py peristitch l-panel  # geo/l_panel.geo

Finite elements alone, no lattice: the crack is a slit of 0.01 mm in a mesh of its own that is refined at the
tip. The opening D_n and the sliding D_t of its faces one step behind the tip give K_I : K_II = D_n : D_t, and
the crack goes on by one step where the tangential stress is largest (Erdogan & Sih 1963),

    theta = 2 atan((K_I - sqrt(K_I^2 + 8 K_II^2)) / (4 K_II))

Prints x, y [mm] of the tip and K_II/K_I, step after step.
"""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import meshio
import numpy

HALF_WIDTH = 0.005  # of the slit [mm]

HOLE = """\
materials: { solid: { young: 3 GPa, poisson: 1/3 } }
boundary:
  - { group: top, displacement: { y: 0.1 mm } }
  - { group: bottom, displacement: { y: 0 } }
  - { group: corner, displacement: { x: 0 } }
"""

L_PANEL = """\
thickness: 100 mm
materials: { solid: { young: 25.85 GPa, poisson: 0.18 } }
boundary:
  - { group: foot, displacement: { x: 0, y: 0 } }
  - { group: load, displacement: { y: 1 mm } }
"""

COMMON = """\
name: slit
geometry: { file: slit.geo, unit: mm }
regions: [ { group: body, model: fem, material: solid } ]
output: { fields: [displacement], pictures: false }
"""


class Drawing:
    """The text of a .geo."""

    def __init__(self):
        self.text = ""
        self.points = 0

    def point(self, at, size):
        self.points += 1
        self.text += f"Point({self.points}) = {{{at[0]:.9f}, {at[1]:.9f}, 0, {size}}};\n"
        return self.points

    def loop(self, corners):
        for i, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1]), 1):
            self.text += f"Line({i}) = {{{a}, {b}}};\n"
        self.text += f"Curve Loop(1) = {{1:{len(corners)}}};\n"


def normal(path, i):
    """To the left of the path at its point i."""
    along = path[min(i + 1, len(path) - 1)] - path[max(i - 1, 0)]
    return numpy.array([-along[1], along[0]]) / math.hypot(*along)


def faces(drawing, path, mouth, fine, coarse):
    """Points of the slit, from the mouth on its right along the tip to the mouth on its left."""

    def size(i):
        tip = math.dist(path[i], path[-1])
        return fine if i >= len(path) - 3 else min(coarse, fine + 0.25 * tip)

    before_tip = range(len(path) - 1)
    off = [HALF_WIDTH * (mouth[0] if i == 0 else -normal(path, i)) for i in before_tip]
    right = [drawing.point(path[i] + off[i], size(i)) for i in before_tip]
    off = [HALF_WIDTH * (mouth[1] if i == 0 else normal(path, i)) for i in before_tip]
    left = [drawing.point(path[i] + off[i], size(i)) for i in before_tip]
    tip = drawing.point(path[-1], fine / 2)
    return right + [tip] + left[::-1]


def hole(path):
    drawing = Drawing()
    corners = [drawing.point(at, 6) for at in [(0, 60), (0, -60), (120, -60), (120, 60)]]
    slit = faces(drawing, path, numpy.array([[0, -1], [0, 1]]), 0.2, 2)
    # From the upper left corner down to the crack and along it, then around.
    loop = [corners[0]] + slit[::-1] + corners[1:]
    drawing.loop(loop)
    centre = drawing.point((60, 22), 1)
    rim = [(70, 22), (60, 32), (50, 22), (60, 12)]
    rim = [drawing.point(at, 0.8) for at in rim]
    first = len(loop) + 1
    for i in range(4):
        drawing.text += f"Circle({first + i}) = {{{rim[i]}, {centre}, {rim[(i + 1) % 4]}}};\n"
    drawing.text += f"Curve Loop(2) = {{{first}:{first + 3}}};\nPlane Surface(1) = {{1, 2}};\n"
    n = len(loop)
    drawing.text += f'Physical Curve("bottom") = {{{n - 2}}};\nPhysical Curve("top") = {{{n}}};\n'
    drawing.text += f'Physical Point("corner") = {{{corners[2]}}};\n'
    return drawing.text


def l_panel(path):
    drawing = Drawing()
    lower = [drawing.point(at, 20) for at in [(0, 0), (250, 0)]]
    # The crack runs to the left: its left face is the lower one, that of the foot.
    slit = faces(drawing, path, numpy.array([[1, 0], [0, -1]]), 0.8, 10)
    load = drawing.point((470, 250), 5)
    upper = [drawing.point(at, 20) for at in [(500, 250), (500, 500), (0, 500)]]
    drawing.loop(lower + slit[::-1] + [load] + upper)
    drawing.text += 'Plane Surface(1) = {1};\nPhysical Curve("foot") = {1};\n'
    drawing.text += f'Physical Point("load") = {{{load}}};\n'
    return drawing.text


def factors(program, folder, geometry, pipeline, path):
    """K_I : K_II."""
    end = 'Physical Surface("body") = {1};\nMesh.ElementOrder = 2;\nMesh.SecondOrderIncomplete = 1;\n'
    (folder / "slit.geo").write_text(geometry + end)
    (folder / "slit.yaml").write_text(COMMON + pipeline)
    command = [program, "run", folder / "slit.yaml", "--results", folder / "results", "--brief"]
    subprocess.run(command, check=True, capture_output=True)
    mesh = meshio.read(folder / "results/slit/slit_elements.vtu")
    across = normal(path, len(path) - 2)
    at = [1e-3 * (path[-2] + side * HALF_WIDTH * across) for side in (1, -1)]
    nodes = [numpy.argmin(numpy.linalg.norm(mesh.points[:, :2] - place, axis=1)) for place in at]
    gap = mesh.point_data["displacement"][nodes[0], :2] - mesh.point_data["displacement"][nodes[1], :2]
    along = (path[-1] - path[-2]) / math.dist(path[-1], path[-2])
    return gap @ numpy.array([-along[1], along[0]]), gap @ along


def grow(program, draw, pipeline, path, step, ended):
    print(f"{path[0][0]:.2f} {path[0][1]:.2f}")
    with tempfile.TemporaryDirectory() as folder:
        while not ended(path[-1]):
            one, two = factors(program, Path(folder), draw(path), pipeline, path)
            print(f"{path[-1][0]:.2f} {path[-1][1]:.2f} K_II/K_I = {two / one:.4f}", flush=True)
            turn = 2 * math.atan((one - math.hypot(one, math.sqrt(8) * two)) / (4 * two)) if two else 0
            along = path[-1] - path[-2]
            angle = math.atan2(along[1], along[0]) + turn
            path.append(path[-1] + step * numpy.array([math.cos(angle), math.sin(angle)]))


def main():
    program, case = sys.argv[1:]
    if case == "hole":
        path = [numpy.array([x, 0.0]) for x in [*range(0, 28, 4), 28, 29, 30]]
        grow(program, hole, HOLE, path, 1.0, lambda tip: tip[0] > 95)
    else:
        # The corner's crack begins at 25 degrees to the horizontal and finds its way within a step or two.
        first = numpy.array([-math.cos(math.radians(25)), math.sin(math.radians(25))])
        path = [numpy.array([250.0, 250.0]) + 5 * i * first for i in range(3)]
        grow(program, l_panel, L_PANEL, path, 5.0, lambda tip: tip[0] < 20)


main()
