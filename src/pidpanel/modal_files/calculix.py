"""Modes of CalculiX in ``.frd`` (text) and its mesh in ``.inp``: shells, surfaces of solids."""

import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.modal_files.shapes import ModeShapes, SurfaceElements, bytes_of, stacked
from pidpanel.text_files import included, lines_of

END = re.compile(rb"^ -3\s*$", re.MULTILINE)
RESULT = re.compile(rb"^  100C.{6}(.{12}).{32}([ \d]{2}).{15}([ \d]{2})", re.MULTILINE)
MASS = re.compile(rb"^    1PGM\s+(\S+)", re.MULTILINE)
FIELD = re.compile(rb"^ -4  (\S+)", re.MULTILINE)
MOST = 10_000_000  # elements of a set
STATIC, SHORT, LONG = 0, 0, 1  # kind of analysis; widths of node numbers of 5 and 10
SHELLS = re.compile(r"(?:S|M3D|STRI)([3468])R?5?")
SOLIDS = re.compile(r"C3D(4|6|8|10|15|20)[A-Z]*")
# Corners of faces S1 … of solids from outside, and edges whose middles follow the corners
HEXAHEDRON = "4321 6785 2651 3762 4873 1584", "12 23 34 41 56 67 78 85 15 26 37 48"
WEDGE = "132 456 1254 2365 3146", "12 23 31 45 56 64 14 25 36"
TETRAHEDRON = "321 241 342 143", "12 23 31 14 24 34"
# Shells of a result, and the nodes below and above of solids that shells were expanded to
RESULT_SHELLS = {7, 8, 9, 10}
RESULT_NODES = {7: 3, 8: 6, 9: 4, 10: 8, 1: 8, 2: 6, 4: 20, 5: 15}
EXPANDED = {
    1: ([0, 1, 2, 3], [4, 5, 6, 7]),
    2: ([0, 1, 2], [3, 4, 5]),
    4: ([0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 16, 17, 18, 19]),
    5: ([0, 1, 2, 6, 7, 8], [3, 4, 5, 12, 13, 14]),
}
COINCIDENT = 1e-5  # of the extent: distance of nodes that are one
FACES = {4: TETRAHEDRON, 10: TETRAHEDRON, 6: WEDGE, 15: WEDGE, 8: HEXAHEDRON, 20: HEXAHEDRON}


def read_shapes(path: Path) -> ModeShapes:
    """Read displacements of modes and static cases; ``1PGM`` are the modal masses."""
    modes: list[tuple[float, float, Array]] = []
    static: list[Array] = []
    node = np.empty(0, dtype=np.int64)
    points: tuple[Index, Array] | None = None
    for section in END.split(bytes_of(path)):
        head, mark, text = section.partition(b"\n -1")
        result, content = RESULT.search(head), FIELD.search(head)
        if result is None and re.search(rb"^    2C", head, re.MULTILINE):
            points = _table(path, mark[1:] + text, int(head.split()[-1]))
        if result is None or content is None:
            continue
        if content[1] == b"DISPI" and b"1PMODE" in head:  # others are a harmonic response
            raise ValueError(f"{path}: has complex modes; real normal modes are needed")
        if content[1] != b"DISP":
            continue
        numbers, vectors = _table(path, mark[1:] + text, int(result[3]))
        if (modes or static) and not np.array_equal(node, numbers):
            message = f"{1 + len(modes)} has other nodes than those before it"
            raise ValueError(f"{path}: mode or static case {message}")
        node = numbers
        if b"1PMODE" in head:
            mass = MASS.search(head)
            modes.append((float(result[1]), float(mass[1]) if mass else 0.0, vectors))
        elif int(result[2]) == STATIC:
            static.append(vectors)
    shapes = stacked(node, modes, static, points)
    return shapes._replace(advice="; *NODE FILE needs OUTPUT=2D for shells")


class ResultElement(NamedTuple):
    """An element of a result."""

    number: int
    kind: int
    material: str
    nodes: list[int]


def read_result_mesh(path: Path) -> SurfaceElements:
    """Read the shells of a result; where it has solids, the middle of those made of shells.

    Without ``OUTPUT=2D`` CalculiX writes each shell as a solid of its thickness. Groups are
    materials.
    """
    node, position = np.empty(0, dtype=np.int64), np.empty((0, 3))
    elements: list[ResultElement] = []
    for section in END.split(bytes_of(path)):
        head, mark, text = section.partition(b"\n -1")
        if re.search(rb"^    2C", head, re.MULTILINE):
            node, position = _table(path, mark[1:] + text, int(head.split()[-1]))
        elif re.search(rb"^    3C", head, re.MULTILINE):
            elements += _result_elements(path, mark + text)
    shells = [element for element in elements if element.kind in RESULT_SHELLS]
    chosen = shells or [element for element in elements if element.kind in EXPANDED]
    groups: dict[str, list[int]] = {}
    for place, element in enumerate(chosen):
        groups.setdefault(element.material, []).append(place)
    numbers = [element.number for element in chosen]
    if shells or not chosen:
        return SurfaceElements(node, position, numbers, [shell.nodes for shell in shells], groups)
    corners, sides, middle = _middle(path, node, position, chosen)
    remarks = ("solids are taken as shells, in their middle",)
    new = 1 + np.arange(len(middle))
    return SurfaceElements(new, middle, numbers, corners, groups, None, remarks, sides)


def _result_elements(path: Path, text: bytes) -> Iterator[ResultElement]:
    """Yield the elements of a result; refuse those without all their nodes."""
    for line in re.split(rb"\n -1", text)[1:]:
        fields = line.replace(b"\n -2", b"").split()
        is_read = len(fields) > 4 and all(map(bytes.isdigit, fields))
        number, kind, _, material, *nodes = map(int, fields) if is_read else 5 * [0]
        if not is_read or len(nodes) != RESULT_NODES.get(kind, len(nodes)):
            place = line[:60].split(b"\n")[0].decode("latin-1").strip()
            raise ValueError(f"{path}: nodes of element '{place}' cannot be read")
        yield ResultElement(number, kind, f"{material}", nodes)


def _middle(
    path: Path, node: Index, position: Array, solids: list[ResultElement]
) -> tuple[list[list[int]], Index, Array]:
    """Return corners of the middle of solids, and each node's sides (n, 2) and place (n, 3)."""
    bottom, top = (
        [[solid.nodes[k] for k in EXPANDED[solid.kind][side]] for solid in solids]
        for side in (0, 1)
    )
    if not set(chain(*bottom)).isdisjoint(chain(*top)):
        message = "solids lie one on another, so that no surface is clear"
        raise ValueError(f"{path}: {message}; state the input, with a *SURFACE")
    pairs = np.array([list(chain(*bottom)), list(chain(*top))]).T
    if not (present := np.isin(pairs, node)).all():
        raise ValueError(f"{path}: node {pairs[~present][0]} of an element is not there")
    order = np.argsort(node)
    middle = position[order[np.searchsorted(node, pairs, sorter=order)]].mean(axis=1)
    grain = COINCIDENT * np.ptp(position, axis=0).max()  # at kinks pairs differ, middles do not
    _, first, vertex = np.unique(
        np.round(middle / grain), axis=0, return_index=True, return_inverse=True
    )
    counts = np.cumsum([len(nodes) for nodes in bottom])[:-1]
    corners = [part.tolist() for part in np.split(1 + vertex.ravel(), counts)]
    return corners, pairs[first], middle[first]


def _table(path: Path, text: bytes, form: int) -> tuple[Index, Array]:
    """Return numbers and vectors of lines of equal length."""
    if form not in (SHORT, LONG):
        raise ValueError(f"{path}: is binary; CalculiX writes text without BINARY in *NODE FILE")
    width, length = 3 + (5 if form == SHORT else 10), text.find(b"\n") + 1
    try:
        table = np.frombuffer(text, dtype="S1").reshape(-1, length)
        numbers = np.ascontiguousarray(table[:, 3:width]).view(f"S{width - 3}").astype(np.int64)
        values = np.ascontiguousarray(table[:, width : width + 36]).view("S12").astype(float)
        return numbers[:, 0], values.reshape(-1, 3)
    except ValueError:
        line = text[:60].split(b"\n")[0].decode("latin-1")
        raise ValueError(f"{path}: lines after '{line}' have not the columns of a text") from None


def read_mesh(path: Path) -> SurfaceElements:
    """Read nodes, shells, faces of solids in ``*SURFACE``, and element sets as groups.

    Faces belong to the sets of their elements. Names are in capitals, as CalculiX has them.
    """
    nodes: list[list[float]] = []
    kinds: dict[int, tuple[str, list[int]]] = {}
    sets: dict[str, list[int]] = {}
    faces: dict[int, dict[int, list[str]]] = {}  # names of surfaces by element and side
    for place, keyword, options, rows in _blocks(path, path.parent):
        try:
            if keyword == "*NODE":
                nodes += [[float(value or 0) for value in (*row, "0", "0")[:4]] for row in rows]
            elif keyword == "*ELEMENT":
                kind = options.get("TYPE", "")
                numbers = [int(value) for row in rows for value in row if value]
                match = SHELLS.fullmatch(kind) or SOLIDS.fullmatch(kind)
                if match is not None:
                    width = 1 + int(match[1])
                    for row in np.array(numbers).reshape(-1, width).tolist():
                        if row[0] in kinds:
                            raise ValueError(f"element {row[0]} appears twice")
                        kinds[row[0]] = kind, row[1:]
                        if "ELSET" in options:
                            sets.setdefault(options["ELSET"], []).append(row[0])
            elif keyword == "*ELSET":
                members = sets.setdefault(options["ELSET"], [])
                for row in rows:
                    if "GENERATE" in options:
                        first, last, step = map(int, [*filter(None, row), "1"][:3])
                        members += range(first, min(last, first + MOST * step) + 1, step)
                        continue
                    for name in filter(None, row):
                        members += [int(name)] if name.isdigit() else sets[name]
            elif keyword == "*SURFACE" and options.get("TYPE", "ELEMENT") == "ELEMENT":
                for name, face, *_ in rows:
                    side = int(face[1:]) if face[1:].isdigit() else 0
                    for number in [int(name)] if name.isdigit() else sets[name]:
                        faces.setdefault(number, {}).setdefault(side, []).append(options["NAME"])
        except (ValueError, IndexError, KeyError) as error:
            raise ValueError(f"{place}: {keyword} cannot be read ({error})") from None
    try:
        return _surfaces(nodes, kinds, sets, faces)
    except ValueError as error:
        raise ValueError(f"{path}: *SURFACE: {error}") from None


def _surfaces(
    nodes: list[list[float]],
    kinds: dict[int, tuple[str, list[int]]],
    sets: dict[str, list[int]],
    faces: dict[int, dict[int, list[str]]],
) -> SurfaceElements:
    element: list[int] = []
    corners: list[list[int]] = []
    groups: dict[str, list[int]] = {}
    places: dict[int, list[int]] = {}
    for number, (kind, members) in kinds.items():
        named = faces.get(number, {})
        solid = SOLIDS.fullmatch(kind)
        count = int(solid[1]) if solid else 0
        sides = {k: _face(count, members, k) for k in named} if solid else {0: members}
        for side, around in sides.items():
            for name in named[side] if solid else set(chain(*named.values())):
                groups.setdefault(name, []).append(len(element))
            places.setdefault(number, []).append(len(element))
            element.append(number)
            corners.append(around)
    for name, numbers in sets.items():
        members = [k for number in numbers for k in places.get(number, ())]
        groups.setdefault(name, []).extend(members)
    table = np.array(nodes).reshape(-1, 4)
    return SurfaceElements(table[:, 0].astype(np.int64), table[:, 1:], element, corners, groups)


def _face(count: int, nodes: list[int], side: int) -> list[int]:
    """Return the nodes of a face of a solid: corners, then those between them."""
    faces, edges = (text.split() for text in FACES[count])
    if not 1 <= side <= len(faces):
        raise ValueError(f"an element of {count} nodes has faces S1 to S{len(faces)}")
    corners = [int(digit) for digit in faces[side - 1]]
    middles = {frozenset(map(int, edge)): k for k, edge in enumerate(edges)}
    around = [
        middles[frozenset(pair)] for pair in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    first = count - len(edges)  # of the middles
    return [nodes[k - 1] for k in corners] + [nodes[first + k] for k in around if first > 3]


def _blocks(path: Path, folder: Path) -> Iterator[tuple[str, str, dict[str, str], list[list[str]]]]:
    """Yield place, keyword, options and lines of values of each keyword, with included files."""
    head: tuple[str, str, dict[str, str]] | None = None
    rows: list[list[str]] = []
    for number, line in enumerate(lines_of(bytes_of(path).decode("latin-1")), 1):
        if not line.strip() or line.startswith("**"):
            continue
        values = [value.strip() for value in line.split(",")]
        if not line.startswith("*"):
            rows.append([value.upper() for value in values])
            continue
        if head is not None:
            yield (*head, rows)
        parts = [value.partition("=") for value in values[1:]]
        options = {name.strip().upper(): value.strip() for name, _, value in parts}
        head, rows = (
            (
                f"{path}:{number}",
                values[0].upper(),
                {name: value.upper() for name, value in options.items()},
            ),
            [],
        )
        if head[1] == "*INCLUDE":
            yield from _blocks(included(path, number, options.get("INPUT", ""), folder), folder)
    if head is not None:
        yield (*head, rows)
