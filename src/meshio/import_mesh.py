"""Reads a mesh with meshio and writes what peristitch needs of it.

The request is one line of JSON on the standard input: file, outcome (where to write), memory (a limit in bytes).
The process ends when that input does. The outcome is a line of JSON, the header, and then the arrays that it
lists, as little-endian 64-bit numbers one behind the other. A header with `error` has no arrays.
"""

import contextlib
import io
import json
import os
import pathlib
import sys
import threading

# One thread: what is read here has nothing to share out, and each would take memory.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What meshio calls those kinds of cells that lie in a plane and that peristitch computes with.
KINDS = ("vertex", "line", "line3", "triangle", "triangle6", "quad", "quad8")
# Integer data whose values are names of groups by themselves.
GROUP_IDS = ("gmsh:physical", "medit:ref", "nastran:ref")
# Integer data that are none.
NO_GROUPS = ("gmsh:geometrical", "gmsh:dim_tags", "cell_tags", "point_tags", "vtkOriginalCellIds",
             "vtkOriginalPointIds", "GlobalCellIds", "GlobalPointIds")
# Data with more values than this number something else.
MOST_VALUES = 1000


class Unsupported(Exception):
    """The file has something that cannot be read here; the text says what."""


def main():
    request = json.loads(first_line())
    threading.Thread(target=end_with_parent, daemon=True).start()
    limit_memory(request["memory"])
    try:
        header, arrays = read(pathlib.Path(request["file"]))
    except MemoryError:
        header, arrays = {"error": "memory", "text": ""}, []
    except ModuleNotFoundError as error:
        header, arrays = {"error": "module", "text": error.name or str(error)}, []
    except Unsupported as error:
        header, arrays = {"error": "unsupported", "text": str(error)}, []
    except Exception as error:  # whatever a reader stumbles upon in a damaged file
        text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        header, arrays = {"error": "unreadable", "text": text}, []
    write(request["outcome"], header, arrays)


def first_line():
    """Read without a buffer: a thread that waits for one would hold up the end of the process."""
    line = b""
    while not line.endswith(b"\n"):
        byte = os.read(0, 1)
        if not byte:
            break
        line += byte
    return line


def end_with_parent():
    while os.read(0, 64):
        pass
    os._exit(1)


def limit_memory(most):
    import resource

    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    most = min(most, installed)
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def write(outcome, header, arrays):
    import numpy as np

    header["arrays"] = [
        {"name": name, "kind": "f8" if array.dtype.kind == "f" else "i8", "length": int(array.size)}
        for name, array in arrays
    ]
    part = outcome + ".part"
    with open(part, "wb") as file:
        file.write(json.dumps(header).encode() + b"\n")
        for _, array in arrays:
            kind = "<f8" if array.dtype.kind == "f" else "<i8"
            file.write(np.ascontiguousarray(array, dtype=kind).tobytes())
    os.replace(part, outcome)


def read(path):
    import meshio

    mesh = read_mesh(meshio, path)
    return describe(meshio, mesh)


def read_mesh(meshio, path):
    suffix = path.suffix.lower()
    if suffix == ".inp":
        import abaqus

        return abaqus.read(meshio, path, Unsupported)
    if suffix in (".bdf", ".nas", ".fem"):
        path = nastran_whole(path)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        try:
            mesh = meshio.read(path)
        except SystemExit:  # meshio's way to say that no reader could
            text = said.getvalue().strip() or "meshio cannot read it, and does not say why"
            raise Unsupported(text) from None
    if suffix in (".bdf", ".nas", ".fem"):
        mesh.node_ids, mesh.element_ids = mesh.points_id, mesh.cells_id
    mesh.counts_from_zero = suffix in (".vtu", ".vtk")
    return mesh


def nastran_whole(path):
    """The file with the lines around its cards that meshio insists upon and Gmsh does not write."""
    check_nastran(path)
    text = path.read_text(encoding="utf-8", errors="replace")
    lines = [line.strip() for line in text.splitlines()]
    before = "" if any(line.startswith("BEGIN BULK") for line in lines) else "BEGIN BULK\n"
    behind = "" if any(line.startswith("ENDDATA") for line in lines) else "\nENDDATA\n"
    whole = pathlib.Path(__file__).with_name("whole.bdf")
    whole.write_text(before + text + behind, encoding="utf-8")
    return whole


def check_nastran(path):
    """meshio passes over cards that it does not know, and over coordinate systems."""
    from meshio.nastran import _nastran

    table = _nastran.nastran_to_meshio_type
    for plane in ("CPLSTS", "CPLSTN"):
        for corners, kind in (("3", "triangle"), ("4", "quad"), ("6", "triangle6"), ("8", "quad8")):
            table.setdefault(plane + corners, kind)
    no_cells = ("CORD", "CONM", "CMASS", "CDAMP", "CELAS", "CONV", "CLOAD", "CEND")
    unknown = {}
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            card = line[:8].split(",")[0].strip().rstrip("*").upper()
            if card == "INCLUDE":
                raise Unsupported("INCLUDE: meshio does not follow it; put all cards into one file")
            if card.startswith("CORD"):
                raise Unsupported(f"a coordinate system ({card}): give the grid points in the basic one")
            if card[:1] == "C" and card[1:2].isalpha() and card not in table and not card.startswith(no_cells):
                if card in ("CAXIF2", "CTRIAX", "CQUADX", "CQUADX4", "CQUADX8", "CTRAX3"):
                    raise Unsupported(f"{card} elements are axisymmetric, and this is a plane computation")
                unknown[card] = unknown.get(card, 0) + 1
    plane = {card: count for card, count in unknown.items() if card.startswith(("CQUAD", "CTRI", "CPLST"))}
    if plane:
        raise Unsupported("plane elements that meshio does not know: " + listed(plane))


def listed(counts):
    return ", ".join(f"{count} {name}" for name, count in counts.items())


def describe(meshio, mesh):
    import numpy as np

    points = np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise Unsupported(f"points with the shape {points.shape}")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    first = 0 if getattr(mesh, "counts_from_zero", False) else 1
    node_ids = getattr(mesh, "node_ids", None)
    arrays = [("points", points.ravel()), ("node_ids", np.arange(first, first + len(points)) if node_ids is None
                                           else np.asarray(node_ids, dtype=np.int64))]
    blocks, ignored, starts, offset, count = [], {}, [], 0, first
    for index, block in enumerate(mesh.cells):
        starts.append(offset if block.type in KINDS else None)
        if block.type not in KINDS:
            ignored[block.type] = ignored.get(block.type, 0) + len(block)
            count += len(block)
            continue
        ids = getattr(mesh, "element_ids", None)
        ids = np.arange(count, count + len(block)) if ids is None else np.asarray(ids[index], dtype=np.int64)
        count += len(block)
        arrays.append((f"nodes/{len(blocks)}", np.asarray(block.data, dtype=np.int64).ravel()))
        arrays.append((f"ids/{len(blocks)}", ids))
        blocks.append(block.type)
        offset += len(block)
    for label, number in getattr(mesh, "left_out", {}).items():
        ignored[label] = ignored.get(label, 0) + number
    cell_sets, notes = sets_of_cells(mesh, starts)
    node_sets, more = sets_of_nodes(mesh)
    side_sets = {name: np.asarray(pairs, dtype=np.int64) for name, pairs in getattr(mesh, "side_sets", {}).items()}
    for word, sets in (("cell_set", cell_sets), ("node_set", node_sets), ("side_set", side_sets)):
        arrays += [(f"{word}/{k}", members.ravel()) for k, members in enumerate(sets.values())]
    header = {
        "meshio": meshio.__version__,
        "blocks": blocks,
        "cell_sets": list(cell_sets),
        "node_sets": list(node_sets),
        "side_sets": list(side_sets),
        "ignored": list(ignored.items()),
        "notes": getattr(mesh, "notes", []) + notes + more,
    }
    return header, arrays


def sets_of_cells(mesh, starts):
    """Name → indices of cells, counted over the blocks that are kept."""
    import numpy as np

    parts, notes = {}, []

    def add(name, block, members):
        if starts[block] is not None and len(members):
            parts.setdefault(str(name), []).append(np.asarray(members, dtype=np.int64) + starts[block])

    for name, members in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            for block, some in enumerate(members):
                add(name, block, [] if some is None else some)
    families = getattr(mesh, "cell_tags", {})
    for block, tags in enumerate(mesh.cell_data.get("cell_tags", [])):
        for family, names in families.items():
            for name in names:
                add(name, block, np.flatnonzero(tags == family))
    for key, data in mesh.cell_data.items():
        names, note = names_of_values(key, data)
        notes += note
        for value, name in names.items():
            for block, values in enumerate(data):
                add(name, block, np.flatnonzero(values == value))
    return {name: np.unique(np.concatenate(some)) for name, some in parts.items()}, notes


def sets_of_nodes(mesh):
    import numpy as np

    sets, notes = {str(name): np.asarray(nodes, dtype=np.int64) for name, nodes in mesh.point_sets.items()}, []
    families = getattr(mesh, "point_tags", {})
    for family, names in families.items():
        members = np.flatnonzero(mesh.point_data.get("point_tags", np.zeros(0)) == family)
        for name in names:
            sets[name] = np.union1d(sets.get(name, members), members)
    for key, data in mesh.point_data.items():
        if key == "nastran:ref":
            if np.any(np.asarray(data)):
                raise Unsupported("grid points in a coordinate system of their own: give them in the basic one")
            continue
        names, note = names_of_values(key, [data])
        notes += note
        sets.update({name: np.flatnonzero(data == value) for value, name in names.items()})
    return {name: np.unique(nodes) for name, nodes in sets.items() if len(nodes)}, notes


def names_of_values(key, data):
    """Value → name of the group, for integer data. `a-b-c` is how meshio writes sets as data; -1 is none of them."""
    import numpy as np

    data = [np.asarray(some) for some in data]
    if key in NO_GROUPS or not data or not all(some.ndim == 1 and some.dtype.kind in "iu" for some in data):
        return {}, []
    values = [int(value) for value in np.unique(np.concatenate(data)) if value >= 0]
    if len(values) > MOST_VALUES:
        return {}, [f"the integers `{key}` have {len(values)} values and make no groups"]
    if key in GROUP_IDS:
        return {value: str(value) for value in values}, []
    names = list(dict.fromkeys(key.split("-")))
    if len(names) > 1 and max(values, default=0) < len(names):
        return {value: names[value] for value in values}, []
    return {value: f"{key}={value}" for value in values}, []


if __name__ == "__main__":
    main()
