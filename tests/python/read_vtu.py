"""Read VTU files, or the files of a PVD list, with VTK's own reader and with meshio; print JSON.

    read_vtu.py FILE.vtu ...    for each file what VTK and what meshio found in it
    read_vtu.py FILE.pvd        the entries, each with the number of points and cells VTK found

Every float is printed as the string of its repr, from which its bits can be recovered.
"""

import json
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import meshio
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkCommand
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def numbers(array):
    """Nested lists of an array; floats as strings."""
    if array.dtype.kind == "f":
        return [[repr(float(x)) for x in row] for row in array.reshape(len(array), -1)]
    return [[int(x) for x in row] for row in array.reshape(len(array), -1)]


def vtk_grid(path):
    errors = []
    reader = vtkXMLUnstructuredGridReader()
    for event in (vtkCommand.ErrorEvent, vtkCommand.WarningEvent):
        reader.AddObserver(event, lambda *_: errors.append(f"VTK reports an error in {path}"))
    reader.SetFileName(str(path))
    reader.Update()
    if errors:
        raise RuntimeError(errors[0])
    return reader.GetOutput()


def vtk_cell(grid, index):
    """Type and nodes. VTK hands out one object for all cells of a type: read it at once."""
    cell = grid.GetCell(index)
    return cell.GetCellType(), [cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())]


def vtk_fields(data):
    arrays = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    return {array.GetName(): numbers(vtk_to_numpy(array)) for array in arrays}


def by_vtk(path):
    grid = vtk_grid(path)
    cells = [vtk_cell(grid, i) for i in range(grid.GetNumberOfCells())]
    return {
        "points": numbers(vtk_to_numpy(grid.GetPoints().GetData())),
        "types": [cell_type for cell_type, _ in cells],
        "cells": [nodes for _, nodes in cells],
        "point_data": vtk_fields(grid.GetPointData()),
        "cell_data": vtk_fields(grid.GetCellData()),
    }


def by_meshio(path):
    mesh = meshio.read(path)
    return {
        "points": numbers(mesh.points),
        "types": [block.type for block in mesh.cells for _ in block.data],
        "cells": [row for block in mesh.cells for row in numbers(block.data)],
        "point_data": {name: numbers(array) for name, array in mesh.point_data.items()},
        "cell_data": {
            name: [row for array in blocks for row in numbers(array)]
            for name, blocks in mesh.cell_data.items()
        },
    }


def pvd_entries(path):
    entries = []
    for dataset in ElementTree.parse(path).getroot().iter("DataSet"):
        grid = vtk_grid(path.parent / dataset.attrib["file"])
        entries.append(
            {
                **dataset.attrib,
                "points": grid.GetNumberOfPoints(),
                "cells": grid.GetNumberOfCells(),
            }
        )
    return entries


def main():
    paths = [Path(argument) for argument in sys.argv[1:]]
    missing = [str(path) for path in paths if not path.is_file()]
    if missing:
        raise SystemExit(f"no such file: {', '.join(missing)}")
    if paths[0].suffix == ".pvd":
        answer = pvd_entries(paths[0])
    else:
        answer = [{"vtk": by_vtk(path), "meshio": by_meshio(path)} for path in paths]
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
