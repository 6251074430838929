"""Mesh of a Nastran deck: nodes in any frame, shells; groups are properties and sets."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.modal_files.shapes import SurfaceElements, bytes_of, included
from pidpanel.panel.nastran import read_cards, real_number
from pidpanel.text_files import lines_of

CORNERS = {"CTRIA3": (3, 3), "CTRIAR": (3, 3), "CTRIA6": (3, 6),
           "CQUAD4": (4, 4), "CQUADR": (4, 4), "CQUAD8": (4, 8)}  # fmt: skip
SYSTEMS = ("CORD2R", "CORD2C", "CORD2S")
SET = re.compile(r"^\s*SET\s+(\d+)\s*=((?:.*,\s*\n)*.*)$", re.MULTILINE | re.IGNORECASE)
RANGE = re.compile(r"(\d+)(?:\s+THRU\s+(\d+))?", re.IGNORECASE)
BLANK = -9  # CP or CD of a node that GRDSET states
Card = tuple[str, str, list[str]]  # place, name, fields


class Systems:
    """Coordinate systems of a deck: origin and axes in the basic frame."""

    def __init__(self, cards: dict[int, Card]) -> None:
        self.cards = cards
        self.systems: dict[int, tuple[str, Array, Array]] = {0: ("R", np.zeros(3), np.eye(3))}

    def system(self, number: int, place: str, depth: int = 0) -> tuple[str, Array, Array]:
        """Return kind, origin (3,) and axes (3, 3) in columns of a system."""
        if number not in self.systems:
            if number not in self.cards or depth > len(self.cards):
                allowed = "CORD2R, CORD2C or CORD2S, and not in itself"
                raise ValueError(f"{place}: coordinate system {number} must be a {allowed}")
            where, name, fields = self.cards[number]
            reference = self.system(int(fields[1] or 0), where, depth + 1)
            points = np.array([real_number(text or "0") for text in fields[2:11]]).reshape(3, 3)
            origin, top, side = positions(reference, points)
            z = (top - origin) / np.linalg.norm(top - origin)
            y = np.cross(z, side - origin)
            y /= np.linalg.norm(y)
            self.systems[number] = name[-1], origin, np.stack([np.cross(y, z), y, z], axis=1)
        return self.systems[number]


def positions(system: tuple[str, Array, Array], x: Array) -> Array:
    """Return the positions (n, 3) of points that are given in a system, angles in degrees."""
    kind, origin, axes = system
    if kind == "C":
        angle = np.radians(x[:, 1])
        x = np.stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]], axis=1)
    elif kind == "S":
        polar, angle = np.radians(x[:, 1:]).T
        x = x[:, :1] * np.stack(
            [np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], axis=1
        )
    return origin + x @ axes.T


def frames(system: tuple[str, Array, Array], position: Array) -> Array:
    """Return the axes of displacements (n, 3, 3), in columns, at positions (n, 3)."""
    kind, origin, axes = system
    x, y, z = ((position - origin) @ axes).T
    angle, polar = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
    if kind == "R":
        return np.broadcast_to(axes, (len(position), 3, 3))
    zero, (c, s) = np.zeros_like(angle), (np.cos(angle), np.sin(angle))
    round_, height = np.array([-s, c, zero]), np.array([zero, zero, 1 + zero])
    radial = np.array([c, s, zero])
    local = np.array([radial, round_, height])
    if kind == "S":
        across = np.cos(polar) * radial - np.sin(polar) * height
        local = np.array([np.sin(polar) * radial + np.cos(polar) * height, across, round_])
    return axes @ local.transpose(2, 1, 0)


def read_mesh(path: Path) -> SurfaceElements:
    """Read nodes, shells, properties and sets of a deck and the files it includes."""
    grids: list[tuple[int, ...]] = []  # number, CP, CD
    points: list[list[float]] = []
    systems: dict[int, Card] = {}
    default = [0, 0]
    element: list[int] = []
    corners: list[list[int]] = []
    groups: dict[str, list[int]] = {}
    for place, name, fields in _cards(path, path.parent):
        try:
            if name == "GRDSET":
                default = [int(fields[1] or 0), int(fields[5] or 0)]
            elif name == "GRID":
                points.append([real_number(text or "0") for text in fields[2:5]])
                grids.append((int(fields[0]), *(int(fields[k] or BLANK) for k in (1, 5))))
            elif name in SYSTEMS:
                systems[int(fields[0])] = place, name, fields
            elif name in CORNERS:
                least, most = CORNERS[name]
                nodes = [int(text or 0) for text in fields[2 : 2 + most]]
                groups.setdefault(fields[1] or fields[0], []).append(len(element))
                element.append(int(fields[0]))
                corners.append(nodes if all(nodes) else nodes[:least])
        except ValueError as error:
            raise ValueError(f"{place}: {name}: {error}") from None
    numbers = np.array(element, dtype=np.int64)
    control = re.split(r"(?im)^\s*BEGIN\s+BULK", bytes_of(path).decode("latin-1"))
    for match in SET.finditer(control[0] if len(control) > 1 else ""):
        spans = [(float(a), float(b or a)) for a, b in RANGE.findall(match[2])]
        members = [np.flatnonzero((a <= numbers) & (numbers <= b)) for a, b in spans]
        groups[f"SET {match[1]}"] = np.concatenate([numbers[:0], *members]).tolist()
    tree = Systems(systems)
    table, position = np.array(grids).reshape(-1, 3), np.array(points).reshape(-1, 3)
    node, *places = table.T
    inner, outer = (np.where(n == BLANK, n0, n) for n, n0 in zip(places, default, strict=True))
    for number in np.unique(inner[inner > 0]).tolist():
        members = inner == number
        position[members] = positions(tree.system(number, str(path)), position[members])
    axes = np.broadcast_to(np.eye(3), (len(node), 3, 3)).copy()
    for number in np.unique(outer[outer > 0]).tolist():
        members = outer == number
        axes[members] = frames(tree.system(number, str(path)), position[members])
    return SurfaceElements(node, position, element, corners, groups, axes)


def _cards(path: Path, folder: Path) -> Iterator[Card]:
    """Yield place, name and fields of the cards of a deck and of the files it includes."""
    faults: list[str] = []
    for line, name, fields in read_cards(path, faults, (*CORNERS, *SYSTEMS)):
        if name == "INCLUDE":
            text = "".join(lines_of(bytes_of(path).decode("latin-1"))[line - 1 : line + 9])
            quoted = re.match(r"\s*INCLUDE\s*(?:'([^']*)'|\"([^\"]*)\"|(\S+))", text, re.IGNORECASE)
            file = "".join(quoted.groups("")) if quoted else ""
            yield from _cards(included(path, line, file, folder), folder)
        else:
            yield f"{path}:{line}", name, fields + 12 * [""]
    if faults:
        raise ValueError(f"{faults[0]}; {len(faults)} such lines")
