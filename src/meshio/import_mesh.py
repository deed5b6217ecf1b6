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
import re
import sys
import threading

# One thread: what is read here has nothing to share out, and each would take memory.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What meshio calls those kinds of cells that lie in a plane and that peristitch computes with.
KINDS = ("vertex", "line", "line3", "triangle", "triangle6", "quad", "quad8")
# Integer data whose values are names of groups by themselves.
GROUP_IDS = ("gmsh:physical", "medit:ref", "avsucd:material")
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
    if suffix == ".inp" and not is_avs(path):
        import abaqus

        return abaqus.read(meshio, path, Unsupported)
    if suffix in (".bdf", ".nas", ".fem"):
        import nastran

        return nastran.read(meshio, path, Unsupported)
    if suffix == ".med":
        prepare_med(path)
    if suffix == ".vtu":
        path = vtu_of_version_1(path)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        try:
            mesh = meshio.read(path, file_format="avsucd" if suffix == ".inp" else None)
        except SystemExit:  # meshio's way to say that no reader could
            lines = [line for line in said.getvalue().splitlines() if "Couldn't read file" not in line]
            raise Unsupported(advice(suffix, " ".join(lines).strip())) from None
        except (MemoryError, ModuleNotFoundError, Unsupported):
            raise
        except Exception as error:
            raise Unsupported(advice(suffix, f"{type(error).__name__}: {error}")) from error
    mesh.counts_from_zero = suffix in (".vtu", ".vtk")
    return mesh


def advice(suffix, reason):
    """What to do with a file that meshio cannot read."""
    reason = f"meshio cannot read it ({reason})" if reason else "meshio cannot read it, and does not say why"
    ways = {
        ".vtu": "; open it in ParaView and save it as .vtu with the data mode Appended or Ascii, or in Python: "
                "pyvista.read(file).save(\"mesh.vtu\")",
        ".vtk": "; open it in ParaView and save it as .vtu, or in Python: pyvista.read(file).save(\"mesh.vtu\")",
        ".med": "; export the mesh from Salome or Gmsh as .med once more, triangles and quadrilaterals alone, or as .msh "
                "or .inp",
    }
    return reason + ways.get(suffix, "")


def is_avs(path):
    """Whether an .inp is one of AVS-UCD: it begins with five counts, and Abaqus with a keyword."""
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = (line.split() for line in file if line.strip() and not line.startswith("#"))
        first = next(lines, [])
    return len(first) == 5 and all(word.isdigit() for word in first)


def vtu_of_version_1(path):
    """meshio knows the versions 0.1 and 1.0; those after them differ in cells that have no place here."""
    data = path.read_bytes()
    head = re.sub(rb'(<VTKFile[^>]*version=")2\.[0-9]+"', rb'\g<1>1.0"', data[:1000], count=1)
    if head == data[:1000]:
        return path
    older = pathlib.Path(__file__).with_name("older.vtu")
    older.write_bytes(head + data[1000:])
    return older


def prepare_med(path):
    """Mends what meshio stumbles upon: names that are not ASCII, families without groups, fields."""
    import h5py
    from meshio.med import _med

    def families(data):
        named = {}
        for family in data.values():
            rows = family["GRO"]["NOM"][()] if "GRO" in family else []
            texts = [bytes(int(character) & 0xFF for character in row).split(b"\0")[0] for row in rows]
            named[family.attrs["NUM"]] = [text.decode("utf-8", errors="replace").strip() for text in texts]
        return named

    _med._read_families = families
    _med._read_data = lambda *_: None
    _med.med_to_meshio_type.update({"QU9": "quad9", "TR7": "triangle7", "SE4": "line4"})
    kinds = {}

    def collect(name, entry):
        if name.rsplit("/", 2)[-2:-1] == ["MAI"] and isinstance(entry, h5py.Group):
            kinds[entry.name.rsplit("/", 1)[1]] = entry

    with h5py.File(path, "r") as file:
        file["ENS_MAA"].visititems(collect)
        unknown = [kind for kind in kinds if kind not in _med.med_to_meshio_type]
    if any(kind.startswith("PO") for kind in unknown):
        raise Unsupported("the mesh has polygons, which are no elements of this program: mesh the surface with triangles "
                          "and quadrilaterals (Salome: Netgen 1D-2D, or Convert to triangles)")
    if unknown:
        raise Unsupported(f"the mesh has elements of the kind {', '.join(unknown)}, which meshio does not know: mesh the "
                          "surface with 3- or 6-node triangles or 4- or 8-node quadrilaterals")


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
                add(name, block, np.flatnonzero(np.ravel(values) == value))
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
        names, note = names_of_values(key, [data])
        notes += note
        sets.update({name: np.flatnonzero(np.ravel(data) == value) for value, name in names.items()})
    return {name: np.unique(nodes) for name, nodes in sets.items() if len(nodes)}, notes


def names_of_values(key, data):
    """Value → name of the group, for integer data. `a-b-c` is how meshio writes sets as data; -1 is none of them."""
    import numpy as np

    # VTK's own files and meshio's reader of them give a column.
    data = [np.asarray(some) for some in data]
    data = [some.ravel() if some.ndim == 2 and some.shape[1] == 1 else some for some in data]
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
