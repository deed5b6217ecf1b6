"""Mesh a .geo with Gmsh and write the mesh in the formats that meshio writes.

    export_meshes.py FILE.geo FOLDER PARAMETER=VALUE ...

The files are FOLDER/mesh.inp, mesh.bdf, mesh.vtu, mesh.vtk, mesh.med, mesh22.msh and mesh41.msh, and, written by Gmsh
itself, gmsh.inp and gmsh.med. Physical groups become what each
format has: element and node sets, property numbers (those of Gmsh's groups, points 100 more, curves 200 more),
data of cells, families.
"""

import sys
from pathlib import Path

import gmsh
import meshio
import numpy as np

SHIFT = {0: 100, 1: 200, 2: 0}


def meshed(file, folder, parameters):
    arguments = ["gmsh"]
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        arguments += ["-setnumber", name, value]
    gmsh.initialize(arguments)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(file)
    gmsh.model.mesh.generate(2)
    tags, positions, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    at = {int(tag): k for k, tag in enumerate(tags[order])}
    kinds = {15: ("vertex", 1), 1: ("line", 2), 8: ("line3", 3), 3: ("quad", 4), 16: ("quad8", 8)}
    rows = {}
    for dimension, group in gmsh.model.getPhysicalGroups():
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
            for kind, _, nodes in zip(*gmsh.model.mesh.getElements(dimension, entity)):
                name, size = kinds[kind]
                nodes = np.array([at[int(node)] for node in nodes]).reshape(-1, size)
                rows.setdefault(name, []).extend((node, dimension, group) for node in nodes)
    names = {(d, g): gmsh.model.getPhysicalName(d, g) for d, g in gmsh.model.getPhysicalGroups()}
    for option in ("Mesh.SaveGroupsOfNodes", "Mesh.SaveGroupsOfElements"):
        gmsh.option.setNumber(option, 1)
    for name in ("gmsh.inp", "gmsh.med"):
        gmsh.write(str(folder / name))
    gmsh.finalize()
    return positions.reshape(-1, 3)[order], rows, names


def main(file, folder, *parameters):
    folder = Path(folder)
    points, rows, names = meshed(file, folder, parameters)
    cells = [(kind, np.array([row[0] for row in of])) for kind, of in rows.items()]
    groups = [[(row[1], row[2]) for row in of] for of in rows.values()]

    def members(group):
        return [np.array([k for k, other in enumerate(of) if other == group], dtype=int) for of in groups]

    sets = {name: members(group) for group, name in names.items()}

    # Abaqus: surfaces as element sets; curves and points as node sets.
    plane = [k for k, (kind, _) in enumerate(cells) if kind.startswith("quad")]
    node_sets = {
        name: np.unique(np.concatenate([cells[k][1][some].ravel() for k, some in enumerate(sets[name])]))
        for group, name in names.items() if group[0] < 2
    }
    element_sets = {name: [sets[name][k] for k in plane] for group, name in names.items() if group[0] == 2}
    meshio.Mesh(points, [cells[k] for k in plane], point_sets=node_sets, cell_sets=element_sets).write(folder / "mesh.inp")

    # Nastran has no quadratic lines: two nodes are enough to find the edge.
    numbers = [np.array([SHIFT[d] + g for d, g in of]) for of in groups]
    straight = [("line", data[:, :2]) if kind == "line3" else (kind, data) for kind, data in cells]
    meshio.Mesh(points, straight, cell_data={"nastran:ref": numbers}).write(folder / "mesh.bdf")

    # VTK: integers per cell, named as meshio names sets that it turns into data.
    order = list(names.values())
    index = {group: order.index(name) for group, name in names.items()}
    data = {"-".join(order): [np.array([index[group] for group in of]) for of in groups]}
    for name in ("mesh.vtu", "mesh.vtk"):
        meshio.Mesh(points, cells, cell_data={key: list(value) for key, value in data.items()}).write(folder / name)

    # MED: a family for each group.
    family = {group: -1 - k for k, group in enumerate(names)}
    tags = [np.array([family[group] for group in of]) for of in groups]
    mesh = meshio.Mesh(points, cells, cell_data={"cell_tags": tags})
    mesh.cell_tags = {family[group]: [name] for group, name in names.items()}
    mesh.write(folder / "mesh.med")

    # Gmsh: an entity for each group.
    physical = [np.array([group[1] for group in of]) for of in groups]
    field_data = {name: np.array([g, d]) for (d, g), name in names.items()}
    tagged = {"gmsh:physical": physical, "gmsh:geometrical": [some.copy() for some in physical]}
    mesh = meshio.Mesh(points, cells, cell_data=tagged, field_data=field_data)
    mesh.write(folder / "mesh22.msh", file_format="gmsh22", binary=False)
    # The 4.1 writer needs to know to which entity each node belongs.
    dimensions = {"vertex": 0, "line": 1, "line3": 1, "quad": 2, "quad8": 2}
    entities = np.zeros((len(points), 2), dtype=int)
    for (kind, nodes), of in sorted(zip(cells, groups), key=lambda pair: -dimensions[pair[0][0]]):
        for row, group in zip(nodes, of):
            entities[row] = group
    by_entity = {}
    for (kind, nodes), of in zip(cells, groups):
        for row, group in zip(nodes, of):
            by_entity.setdefault((kind, group), []).append(row)
    blocks = [(kind, np.array(some)) for (kind, _), some in by_entity.items()]
    one = [np.full(len(some), group[1]) for (_, group), some in by_entity.items()]
    tagged = {"gmsh:physical": one, "gmsh:geometrical": [some.copy() for some in one]}
    mesh = meshio.Mesh(points, blocks, cell_data=tagged, field_data=field_data, point_data={"gmsh:dim_tags": entities})
    mesh.write(folder / "mesh41.msh", file_format="gmsh", binary=False)


main(*sys.argv[1:])
