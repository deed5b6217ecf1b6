"""Reads the bulk data of a Nastran deck into a meshio.Mesh.

meshio's own reader takes every field of an element for a node, the material angle THETA of a CQUAD4 included, knows
no continuation line that begins with blanks, and passes over the cards that list nodes. What it would pass over in
silence is read here, or refused with its card and line.
"""

import re

# Card → number of nodes, and meshio's kind. The nodes stand behind the element's and its property's number.
PLANE = {
    "CTRIA3": (3, "triangle"), "CTRIAR": (3, "triangle"), "CQUAD4": (4, "quad"), "CQUADR": (4, "quad"),
    "CSHEAR": (4, "quad"), "CTRIA6": (6, "triangle6"), "CQUAD8": (8, "quad8"), "CQUAD9": (9, "quad9"),
}
for corners, (count, kind) in {"3": (3, "triangle"), "4": (4, "quad"), "6": (6, "triangle6"), "8": (8, "quad8")}.items():
    PLANE["CPLSTS" + corners] = PLANE["CPLSTN" + corners] = (count, kind)
LINES = {
    "CROD": (2, "line"), "CTUBE": (2, "line"), "CBAR": (2, "line"), "CBEAM": (2, "line"), "CBUSH": (2, "line"),
    "CBUSH1D": (2, "line"), "CGAP": (2, "line"), "CBEAM3": (3, "line3"),
}
# A quadratic element may leave all of its middle nodes out.
LINEAR = {"triangle6": (3, "triangle"), "quad8": (4, "quad")}
SOLIDS = ("CTETRA", "CPYRA", "CPYRAM", "CPENTA", "CHEXA")
AXISYMMETRIC = ("CAXIF2", "CTRIAX", "CTRIAX6", "CTRAX3", "CTRAX6", "CQUADX", "CQUADX4", "CQUADX8")
TIES = ("MPC", "RBAR", "RBE1", "RBE2", "RBE3", "RROD", "RSPLINE")
PHYSICS = ("SPC", "SPC1", "SPCD", "FORCE", "MOMENT", "PLOAD", "PLOAD2", "PLOAD4", "GRAV", "MAT1", "MAT8")


class Card:
    """A card and its continuation lines: the name, and the fields behind it."""

    def __init__(self, name, line, refuse):
        self.name, self.line, self.refuse, self.fields = name, line, refuse, []

    def fail(self, what):
        raise self.refuse(f"line {self.line}: {self.name}: {what}")

    def text(self, index):
        return self.fields[index] if index < len(self.fields) else ""

    def integer(self, index, what, default=None):
        text = self.text(index)
        if not text and default is not None:
            return default
        try:
            return int(text)
        except ValueError:
            self.fail(f"`{text}` in field {index + 2} is no number of {what}" if text else
                      f"field {index + 2} is empty, and should be the number of {what}")

    def real(self, index):
        """Nastran leaves the E of an exponent out: 1.5-3."""
        text = self.text(index) or "0"
        plain = re.sub(r"(?<=[0-9.])([+-])", r"e\1", re.sub("[dD]", "e", text))
        try:
            return float(plain.replace("ee", "e"))
        except ValueError:
            self.fail(f"`{text}` in field {index + 2} is no number")

    def identities(self, start):
        """Numbers from a field on; `3 THRU 7` is a range."""
        words = [word for word in self.fields[start:] if word]
        found, at = [], 0
        while at < len(words):
            try:
                if at + 2 < len(words) and words[at + 1].upper() == "THRU":
                    found.extend(range(int(words[at]), int(words[at + 2]) + 1))
                    at += 3
                else:
                    found.append(int(words[at]))
                    at += 1
            except ValueError:
                self.fail(f"`{words[at]}` is no number of a node")
        return found


def cards(path, refuse):
    """The cards of the bulk data, in order."""
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = file.read().splitlines()
    bulk = [number for number, line in enumerate(lines) if line.strip().upper().startswith("BEGIN BULK")]
    card = None
    for number in range(bulk[0] + 1 if bulk else 0, len(lines)):
        line = lines[number].split("$")[0].expandtabs(8).rstrip()
        if not line.strip():
            continue
        if line.strip().upper().startswith("ENDDATA"):
            break
        head, fields = split(line)
        is_continuation = head == "" or head[0] in "+*"
        if not is_continuation:
            if card is not None:
                yield card
            card = Card(head.rstrip("*").upper(), number + 1, refuse)
        if card is not None:
            card.fields.extend(fields)
    if card is not None:
        yield card


def split(line):
    """The first field of a line, and its fields of data: eight, or four wide ones."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        data = 4 if words[0].endswith("*") or words[0].startswith("*") else 8
        # A field too many is the name of the continuation line.
        if len(words) == data + 2:
            words = words[: data + 1]
        return words[0], words[1:] + [""] * (data + 1 - len(words))
    head = line[:8].strip()
    width, count = (16, 4) if head.endswith("*") or head.startswith("*") else (8, 8)
    return head, [line[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]


class Reader:
    def __init__(self):
        self.nodes, self.blocks, self.properties, self.node_sets = {}, {}, {}, {}
        self.left_out, self.seen = {}, set()

    def card(self, card):
        name = card.name
        self.seen.add(name)
        if name == "GRID":
            if card.integer(1, "a coordinate system", 0) != 0:
                card.fail("the grid point is given in a coordinate system of its own: give it in the basic one")
            self.nodes[card.integer(0, "a grid point")] = [card.real(2), card.real(3), card.real(4)]
        elif name in PLANE or name in LINES:
            self.element(card, *(PLANE.get(name) or LINES[name]))
        elif name == "CONROD":
            card.fields.insert(1, "")
            self.element(card, 2, "line")
        elif name == "PLOTEL":
            card.fields.insert(1, "")
            self.element(card, 2, "line")
        elif name in AXISYMMETRIC:
            card.fail("the elements are axisymmetric, and this is a plane computation")
        elif name.startswith(("CQUAD", "CTRI", "CPLST")):
            card.fail("this kind of plane elements is not read: supported are 3- and 6-node triangles and 4- and "
                      "8-node quadrilaterals")
        elif name in SOLIDS:
            self.left_out[name] = self.left_out.get(name, 0) + 1
        elif name.startswith("INCLUDE"):
            card.fail("other files are not read along: put all cards into one file")
        elif name == "GRDSET" and card.integer(1, "a coordinate system", 0) != 0:
            card.fail("the grid points are given in a coordinate system of their own: give them in the basic one")
        else:
            self.node_set(card)

    def element(self, card, count, kind):
        identity = card.integer(0, "an element")
        if len(card.fields) < 2 + count:
            card.fields.extend([""] * (2 + count - len(card.fields)))
        corners, linear = LINEAR.get(kind, (count, kind))
        if corners < count and not any(word not in ("", "0") for word in card.fields[2 + corners : 2 + count]):
            count, kind = corners, linear
        nodes = [card.integer(2 + k, "a grid point") for k in range(count)]
        if 0 in nodes:
            card.fail("it lacks some of its middle nodes: give all of them or none")
        self.blocks.setdefault(kind, []).append((identity, nodes, card))
        number = card.text(1)
        if number:
            self.properties.setdefault(number, {}).setdefault(kind, []).append(len(self.blocks[kind]) - 1)

    def node_set(self, card):
        """Cards that list nodes make groups, such as `SPC=1`."""
        name, nodes = card.name, []
        if name == "SPC":
            nodes = [card.integer(k, "a grid point") for k in (1, 4) if card.text(k)]
        elif name == "SPC1":
            name, nodes = "SPC", card.identities(2)
        elif name in ("FORCE", "MOMENT"):
            nodes = [card.integer(1, "a grid point")]
        elif name == "SET1":
            nodes = [node for node in card.identities(1)] if card.text(1).upper() != "SKIN" else []
        if nodes:
            self.node_sets.setdefault(f"{name}={card.text(0)}", []).extend(nodes)


def read(meshio, path, refuse):
    import numpy as np

    reader = Reader()
    for card in cards(path, refuse):
        reader.card(card)
    place = {identity: k for k, identity in enumerate(reader.nodes)}
    for rows in reader.blocks.values():
        for identity, nodes, card in rows:
            missing = [node for node in nodes if node not in place]
            if missing:
                card.fail(f"element {identity} uses grid point {missing[0]}, which is not defined")
    mesh = meshio.Mesh(
        np.array(list(reader.nodes.values()), dtype=float).reshape(-1, 3),
        [(kind, np.array([[place[node] for node in nodes] for _, nodes, _ in rows], dtype=np.int64))
         for kind, rows in reader.blocks.items()],
    )
    mesh.node_ids = list(reader.nodes)
    mesh.element_ids = [[identity for identity, _, _ in rows] for rows in reader.blocks.values()]
    mesh.left_out = reader.left_out
    for number, members in reader.properties.items():
        mesh.cell_sets[number] = [np.array(members.get(kind, []), dtype=np.int64) for kind in reader.blocks]
    for name, nodes in reader.node_sets.items():
        # Sets may list elements or aeroelastic points: of those nothing is known.
        known = [place[node] for node in nodes if node in place]
        if known:
            mesh.point_sets[name] = np.array(known, dtype=np.int64)
    mesh.notes = notes(reader)
    return mesh


def notes(reader):
    found = []
    ties = [card for card in TIES if card in reader.seen]
    if ties:
        found.append(f"{', '.join(ties)}: not read; parts that only these join are not joined")
    physics = [card for card in PHYSICS if card in reader.seen]
    if physics:
        found.append(f"{', '.join(physics)}: not read; materials, supports and loads stand in the pipeline")
    if reader.node_sets:
        found.append(f"the nodes that cards list are the groups {', '.join(reader.node_sets)}")
    return found
