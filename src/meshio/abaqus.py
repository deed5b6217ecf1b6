"""Reads an Abaqus .inp into a meshio.Mesh.

meshio's own reader knows few plane elements (not CPS8, CPE8 or CPS6), loses the sets of *ELEMENT, ELSET= behind
a block without one, forgets all blocks of nodes but the last, and passes over instances, surfaces and node sets
that list sets. What it would pass over in silence is read here, or refused by its name.
"""

import re

# Kind of cell by name; the last letters only say how Abaqus integrates: R, H, I, M, T.
PLANE = re.compile(r"(?P<family>CPS|CPE|CPEG|S|STRI|M3D|CAX)(?P<nodes>3|4|6|8|65|9)(?P<rest>[RHIMTSW5]*)")
PLANE_KINDS = {"3": "triangle", "4": "quad", "6": "triangle6", "65": "triangle6", "8": "quad8", "9": "quad9"}
LINES = {"T2D2": 2, "T3D2": 2, "B21": 2, "B31": 2, "B23": 2, "B33": 2, "R2D2": 2, "T2D3": 3, "T3D3": 3, "B22": 3, "B32": 3}
NODES = {"triangle": 3, "quad": 4, "triangle6": 6, "quad8": 8, "quad9": 9, "line": 2, "line3": 3, "vertex": 1}
GENERATORS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM")
PHYSICS = ("BOUNDARY", "CLOAD", "DLOAD", "DSLOAD", "MATERIAL", "SOLID SECTION", "STEP")
TIES = ("TIE", "MPC", "EQUATION", "EMBEDDED ELEMENT", "COUPLING", "KINEMATIC", "RIGID BODY", "CONTACT PAIR")


class Scope:
    """The nodes, elements and sets of a part, or of a file without parts; sets are lists of ids."""

    def __init__(self):
        self.nodes, self.elements = {}, {}
        self.node_sets, self.element_sets, self.surfaces = Named(), Named(), Named()


class Named(dict):
    """Names are the same in capitals and small letters; the first spelling is kept."""

    def __init__(self):
        super().__init__()
        self.spelling = {}

    def add(self, name, members):
        self.spelling.setdefault(name.upper(), name)
        self.setdefault(name.upper(), []).extend(members)

    def spelled(self):
        return [(self.spelling[key], members) for key, members in self.items()]


class Reader:
    def __init__(self, refuse):
        self.refuse = refuse
        self.root = self.scope = Scope()
        self.parts, self.instances, self.left_out, self.seen = Named(), [], {}, {}
        self.assembly = {"node": Named(), "element": Named(), "surface": Named()}
        self.in_assembly = False
        self.instance = None

    def file(self, path, depth=0):
        if depth > 20:
            raise self.refuse(f"*INCLUDE: {path} is included by itself")
        for keyword, options, lines in blocks(path):
            self.seen[keyword] = self.seen.get(keyword, 0) + 1
            if keyword == "INCLUDE":
                included = path.parent / options.get("INPUT", "")
                if not included.is_file():
                    raise self.refuse(f"*INCLUDE: there is no file {included}")
                self.file(included, depth + 1)
            else:
                self.block(keyword, options, lines)

    def block(self, keyword, options, lines):
        if keyword in GENERATORS:
            raise self.refuse(f"*{keyword}: generated nodes and elements are not read; write them out")
        if keyword == "NODE":
            self.read_nodes(options, lines)
        elif keyword == "ELEMENT":
            self.read_elements(options, lines)
        elif keyword in ("NSET", "ELSET"):
            self.read_set(keyword, options, lines)
        elif keyword == "SURFACE":
            self.read_surface(options, lines)
        elif keyword == "PART":
            self.scope = Scope()
            self.parts.add(options.get("NAME", ""), [self.scope])
        elif keyword == "END PART":
            self.scope = self.root
        elif keyword in ("ASSEMBLY", "END ASSEMBLY"):
            self.in_assembly = keyword == "ASSEMBLY"
        elif keyword == "INSTANCE":
            self.read_instance(options, lines)
        elif keyword == "END INSTANCE":
            self.scope, self.instance = self.root, None

    def read_instance(self, options, lines):
        part = self.parts.get(options.get("PART", "").upper())
        if part is None:
            raise self.refuse(f"*INSTANCE: there is no part `{options.get('PART', '')}` above it")
        rows = [numbers(line) for line in lines if line.strip(", ")]
        if len(rows) > 1:
            raise self.refuse(f"*INSTANCE: `{options.get('NAME', '')}` is rotated; export a flat input file "
                              "(model attributes: do not use parts and assemblies)")
        shift = (rows[0] + [0.0] * 3)[:3] if rows else [0.0] * 3
        self.instance = options.get("NAME", "")
        self.instances.append((self.instance, part[0], shift))
        self.scope = part[0]

    def read_nodes(self, options, lines):
        if options.get("SYSTEM", "R").upper() != "R":
            raise self.refuse("*NODE, SYSTEM: give the nodes in rectangular coordinates")
        if options.get("INPUT"):
            raise self.refuse("*NODE, INPUT: put the nodes into the file itself, or use *INCLUDE")
        ids = []
        for line in lines:
            row = numbers(line)
            if row:
                ids.append(int(row[0]))
                self.scope.nodes[ids[-1]] = (row[1:4] + [0.0] * 3)[:3]
        if options.get("NSET"):
            self.scope.node_sets.add(options["NSET"], ids)

    def read_elements(self, options, lines):
        label = options.get("TYPE", "").upper()
        kind = self.kind(label)
        if options.get("INPUT"):
            raise self.refuse("*ELEMENT, INPUT: put the elements into the file itself, or use *INCLUDE")
        if kind is None:
            whole = sum(1 for line in lines if not line.rstrip().endswith(","))
            self.left_out[label] = self.left_out.get(label, 0) + whole
            return
        words = [int(word) for line in lines for word in line.split(",") if word.strip()]
        size = NODES[kind] + 1
        if len(words) % size:
            raise self.refuse(f"*ELEMENT, TYPE={label}: {len(words)} numbers, not a multiple of {size} (id and nodes)")
        ids = words[::size]
        for k, identity in enumerate(ids):
            self.scope.elements[identity] = (kind, label, words[k * size + 1 : (k + 1) * size])
        if options.get("ELSET"):
            self.scope.element_sets.add(options["ELSET"], ids)

    def kind(self, label):
        """meshio's word; None for what has no place in a plane computation and is left out."""
        plane = PLANE.fullmatch(label)
        if plane and plane["family"] in ("CAX", "CPEG"):
            what = "axisymmetric" if plane["family"] == "CAX" else "in generalised plane strain"
            raise self.refuse(f"{label} elements are {what}, and this is a plane computation")
        if plane:
            return PLANE_KINDS[plane["nodes"]]
        if label.startswith(("CPS", "CPE", "CAX")):
            raise self.refuse(f"{label} elements: this kind is not supported")
        if label.rstrip("H") in LINES:
            return "line" if LINES[label.rstrip("H")] == 2 else "line3"
        return "vertex" if label == "MASS" else None

    def read_set(self, keyword, options, lines):
        what, key = ("node", "NSET") if keyword == "NSET" else ("element", "ELSET")
        name, instance = options.get(key), options.get("INSTANCE")
        if not name:
            raise self.refuse(f"*{keyword} without a name")
        scope = self.scope
        if instance is not None:
            found = [part for other, part, _ in self.instances if other.upper() == instance.upper()]
            if not found:
                raise self.refuse(f"*{keyword}, {key}={name}: there is no instance `{instance}` above it")
            scope = found[0]
        known = scope.node_sets if what == "node" else scope.element_sets
        members = []
        if what == "node" and "ELSET" in options:
            elements = self.named(scope.element_sets, options["ELSET"], keyword, name)
            members = [node for element in elements for node in scope.elements[element][2]]
        for line in lines:
            words = [word.strip().strip('"') for word in line.split(",") if word.strip()]
            if "GENERATE" in options and words:
                first, last = int(words[0]), int(words[1])
                members.extend(range(first, last + 1, int(words[2]) if len(words) > 2 else 1))
                continue
            for word in words:
                members.extend([int(word)] if word.isdigit() else self.reference(known, what, word, keyword, name))
        if self.in_assembly and self.instance is None:
            owner = instance if instance is not None else ""
            pairs = [pair if isinstance(pair, tuple) else (owner, pair) for pair in members]
            self.assembly[what].add(name, pairs)
        else:
            known.add(name, members)

    def reference(self, known, what, word, keyword, name):
        """The members of another set; in an assembly also `instance.set` and `instance.id`."""
        if word.upper() in self.assembly[what] and self.in_assembly:
            return list(self.assembly[what][word.upper()])
        instance, _, rest = word.rpartition(".")
        for other, part, _ in self.instances if instance else []:
            if other.upper() == instance.upper():
                sets = part.node_sets if what == "node" else part.element_sets
                ids = [int(rest)] if rest.isdigit() else self.named(sets, rest, keyword, name)
                return [(other, identity) for identity in ids]
        return self.named(known, word, keyword, name)

    def named(self, sets, word, keyword, name):
        if word.upper() not in sets:
            raise self.refuse(f"*{keyword}: `{name}` lists the set `{word}`, which is not defined above it")
        return list(sets[word.upper()])

    def read_surface(self, options, lines):
        name = options.get("NAME", "")
        what = options.get("TYPE", "ELEMENT").upper()
        if what not in ("ELEMENT", "NODE"):
            self.left_out[f"*SURFACE, TYPE={what}"] = 1
            return
        outside = self.in_assembly and self.instance is None
        surfaces = self.assembly["surface"] if outside else self.scope.surfaces
        known = "node" if what == "NODE" else "element"
        sets = self.scope.node_sets if what == "NODE" else self.scope.element_sets
        for line in lines:
            words = [word.strip().strip('"') for word in line.split(",")]
            if not words[0]:
                continue
            members = [int(words[0])] if words[0].isdigit() else self.reference(sets, known, words[0], "SURFACE", name)
            side = words[1].upper() if len(words) > 1 else ""
            if what == "ELEMENT" and not re.fullmatch("S[1-4]", side):
                raise self.refuse(f"*SURFACE: `{name}` names no side S1 to S4 of `{words[0]}`")
            pairs = [pair if isinstance(pair, tuple) else ("", pair) for pair in members]
            number = int(side[1]) - 1 if what == "ELEMENT" else None
            surfaces.add(name, [(instance, identity, number) for instance, identity in pairs])


def numbers(line):
    return [float(re.sub("[dD]", "e", word)) for word in line.split(",") if word.strip()]


def blocks(path):
    """Keyword, options, lines of data. A keyword line that ends with a comma goes on in the next."""
    keyword, options, lines, open_line = None, {}, [], ""
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            if line.startswith("**") or not line.strip():
                continue
            if line.startswith("*") or open_line:
                head = open_line + line.strip()
                if not open_line and keyword is not None:
                    yield keyword, options, lines
                open_line = head if head.endswith(",") else ""
                words = [word.strip() for word in head.lstrip("*").split(",")]
                keyword = " ".join(words[0].upper().split())
                pairs = [word.partition("=") for word in words[1:] if word]
                options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
                lines = []
            elif keyword is not None:
                lines.append(line)
    if keyword is not None:
        yield keyword, options, lines


def read(meshio, path, refuse):
    import numpy as np

    reader = Reader(refuse)
    reader.file(path)
    # A file without instances is one, and so is each part that none places.
    placed = reader.instances or [(name, part[0], [0.0] * 3) for name, part in reader.parts.spelled()]
    if reader.root.nodes:
        placed = placed + [("", reader.root, [0.0] * 3)]
    points, node_ids, node_at, cells, cell_at = [], [], {}, {}, {}
    labels = set()
    for name, scope, shift in placed:
        for identity, position in scope.nodes.items():
            node_at[name.upper(), identity] = len(points)
            points.append([a + b for a, b in zip(position, shift)])
            node_ids.append(identity)
        for identity, (kind, label, nodes) in scope.elements.items():
            missing = [node for node in nodes if (name.upper(), node) not in node_at]
            if missing:
                raise refuse(f"element {identity} ({label}) uses node {missing[0]}, which is not defined")
            rows = cells.setdefault(kind, [])
            cell_at[name.upper(), identity] = (kind, len(rows))
            rows.append(([node_at[name.upper(), node] for node in nodes], identity))
            labels.add(label)
    kinds = list(cells)
    mesh = meshio.Mesh(
        np.array(points, dtype=float).reshape(-1, 3),
        [(kind, np.array([row for row, _ in rows], dtype=np.int64)) for kind, rows in cells.items()],
    )
    mesh.node_ids = node_ids
    mesh.element_ids = [[identity for _, identity in rows] for rows in cells.values()]
    mesh.left_out = reader.left_out
    # Positions over the blocks that peristitch keeps, which are all but nine-node ones.
    starts, offset = {}, 0
    for kind in kinds:
        starts[kind] = offset
        offset += 0 if kind == "quad9" else len(cells[kind])
    flat = {key: starts[kind] + row for key, (kind, row) in cell_at.items() if kind != "quad9"}
    mesh.notes = notes(reader, labels)
    mesh.cell_sets, mesh.point_sets, mesh.side_sets = {}, {}, {}
    for name, pairs in all_sets(reader, placed, "element"):
        rows = [cell_at[pair] for pair in pairs if pair in cell_at]
        mesh.cell_sets[name] = [np.array([row for of, row in rows if of == kind], dtype=np.int64) for kind in kinds]
    for name, pairs in all_sets(reader, placed, "node"):
        mesh.point_sets[name] = np.array([node_at[pair] for pair in pairs if pair in node_at], dtype=np.int64)
    for name, triples in all_sets(reader, placed, "surface"):
        sides = [(flat[of, cell], side) for of, cell, side in triples if side is not None and (of, cell) in flat]
        nodes = [node_at[of, node] for of, node, side in triples if side is None and (of, node) in node_at]
        if sides:
            mesh.side_sets[name] = sides
        if nodes:
            mesh.point_sets[name] = np.array(nodes, dtype=np.int64)
    return mesh


def all_sets(reader, placed, what):
    """Names and members, each with its instance in capitals. Sets of a part that is placed more than once, or beside
    another with such a set, go by `instance.set`."""
    owners = {}
    for name, scope, _ in placed:
        sets = {"node": scope.node_sets, "element": scope.element_sets, "surface": scope.surfaces}[what]
        for spelled, members in sets.spelled():
            owners.setdefault(spelled.upper(), []).append((name, spelled, members))
    sets = {}
    for entries in owners.values():
        for name, spelled, members in entries:
            label = spelled if len(entries) == 1 else f"{name}.{spelled}"
            tuples = [(name.upper(),) + (member[1:] if isinstance(member, tuple) else (member,)) for member in members]
            sets[label] = tuples
    only = placed[0][0].upper() if len(placed) == 1 else ""
    for spelled, members in reader.assembly[what].spelled():
        owned = [((member[0].upper() or only),) + tuple(member[1:]) for member in members]
        sets[spelled] = owned
    return sets.items()


def notes(reader, labels):
    found = []
    strain = sorted(label for label in labels if label.startswith("CPE"))
    if strain:
        found.append(f"{', '.join(strain)} elements are plane strain there; here `plane` in the pipeline decides")
    shells = sorted(label for label in labels if label.startswith(("S", "M3D")))
    if shells:
        found.append(f"{', '.join(shells)} elements are read as plane ones")
    lines = sorted(label for label in labels if label.rstrip("H") in LINES)
    if lines:
        found.append(f"{', '.join(lines)} elements name curves here, and have no stiffness")
    ties = [f"*{word}" for word in TIES if word in reader.seen]
    if ties:
        found.append(f"{', '.join(ties)}: not read; parts that only these join are not joined")
    physics = [f"*{word}" for word in PHYSICS if word in reader.seen]
    if physics:
        found.append(f"{', '.join(physics)}: not read; materials, supports and loads stand in the pipeline")
    return found
