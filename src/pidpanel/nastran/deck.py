"""The nodes, shells, sets and constraints of a deck, and what of it is not used.

Cards that are not read are counted. Who reads a deck decides whether they may be left out.
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.nastran.cards import (
    BLANKS,
    MOST_FIELDS,
    MOST_LISTED,
    Card,
    case_control,
    numbers_of,
    read_cards,
    real_number,
    whole_number,
)
from pidpanel.nastran.systems import BY_NODES, BY_POINTS, Systems, frames, positions

# Corners, nodes, and the place of THETA or MCID among the fields; ZOFFS follows it
SHELLS = {"CTRIA3": (3, 3, 5), "CTRIAR": (3, 3, 5), "CTRIA6": (3, 6, 8),
          "CQUAD4": (4, 4, 6), "CQUADR": (4, 4, 6), "CQUAD8": (4, 8, 14)}  # fmt: skip
THICKNESS = {"CTRIA3": (10, 13), "CTRIAR": (10, 13), "CTRIA6": (10, 13),
             "CQUAD4": (10, 14), "CQUADR": (10, 14), "CQUAD8": (10, 14)}  # fmt: skip
GEOMETRY = ("GRID", "GRDSET", *SHELLS, *BY_POINTS, *BY_NODES)
# Cards that are kept for proposals of a study
CONSTRAINTS = ("SPC", "SPC1", "SPCADD")
MASSES = {"CONM1": 3, "CONM2": 3, "CMASS2": 1, "CMASS4": 1}  # place of the mass
PROPERTIES = ("PSHELL", "PCOMP", "PCOMPG", "MAT1", "MAT2", "MAT8")
PROPOSED = (*CONSTRAINTS, *MASSES, *PROPERTIES, "PARAM", "EIGR", "EIGRL", "RBE2")
SET = re.compile(r"^\s*SET\s+(\d+)\s*=((?:.*,\s*\n)*.*)$", re.MULTILINE)
WEIGHTS = re.compile(r"^\s*PARAM\s*,\s*WTMASS\s*,\s*(\S+)", re.MULTILINE)
ACTIVE = re.compile(r"^\s*SPC\s*=\s*(\d+)\s*$", re.MULTILINE)
LIMITS = dict.fromkeys(GEOMETRY, MOST_FIELDS)
WHOLE_LIMITS = LIMITS | dict.fromkeys(PROPOSED, MOST_LISTED)
ACROSS = 0.996  # cosine of 5°, the least angle between the x axis of MCID and a normal
MOST_FAULTS = 1000  # a file with more is not read to its end


class Shells(NamedTuple):
    """The shell elements of a deck."""

    kind: Sequence[str]
    number: Index
    corners: Sequence[Sequence[int]]  # numbers of the nodes: corners, then those between them
    angle: Array  # THETA [°]; not finite where MCID is stated
    system: Index  # MCID; −1 where THETA is stated
    offset: Array  # ZOFFS
    has_thickness: Sequence[bool]  # whether it states thicknesses of its own


@dataclass(frozen=True)
class Deck:
    """What a deck says, in its units and in the basic frame."""

    path: Path
    control: str  # executive and case control in capitals
    node: Index  # (n,) numbers
    position: Array  # (n, 3)
    frame: Array  # (n, 3, 3) axes of displacements, in columns
    fixed: Mapping[int, str]  # components that GRID holds, by node
    shells: Shells
    groups: Mapping[str, Sequence[int]]  # places of shells by property and by SET
    cards: Mapping[str, Sequence[Card]]  # those of `PROPOSED`, by name
    counts: Mapping[str, int]  # how often each card appears
    first: Mapping[str, str]  # place of the first card of each name
    systems: Systems = field(repr=False)

    def constraints(self) -> tuple[dict[int, str], list[str]]:
        """Return the components that each node is held in, and remarks on what was chosen."""
        sets = sorted(
            {int(card.fields[0] or 0) for name in CONSTRAINTS for card in self.cards.get(name, ())}
        )
        active = list(dict.fromkeys(map(int, ACTIVE.findall(self.control))))
        remarks = []
        if len(active) > 1:
            names = ", ".join(map(str, active[1:]))
            remarks.append(f"constraints of the first subcase, SPC = {active[0]}, not {names}")
        elif not active and len(sets) > 1:
            remarks.append("the case control names no SPC: all constraints of the deck")
        elif not active and sets and self.control:
            remarks.append(f"the case control names no SPC: that of set {sets[0]}")
        chosen = set(active[:1]) or set(sets)
        for card in self.cards.get("SPCADD", ()):
            if int(card.fields[0]) in chosen:
                chosen |= set(numbers_of(card.fields[1:]))
        components = dict(self.fixed)
        for node, text in self._constrained(chosen):
            components[node] = "".join(sorted({*components.get(node, ""), *text}))
        return components, remarks

    def _constrained(self, chosen: set[int]) -> list[tuple[int, str]]:
        pairs: list[tuple[int, str]] = []
        for name in ("SPC", "SPC1"):
            for card in self.cards.get(name, ()):
                number, *fields = [*card.fields, *BLANKS]
                if int(number or 0) not in chosen:
                    continue
                try:
                    if name == "SPC1":
                        pairs += [(node, fields[0]) for node in numbers_of(fields[1:])]
                    else:
                        pairs += [(int(fields[k]), fields[k + 1]) for k in (0, 3) if fields[k]]
                except ValueError as error:
                    raise ValueError(f"{card.place}: {name}: {error}") from None
        return pairs

    def chosen(self, groups: Sequence[str] = ()) -> Index:
        """Return the places of the shells of groups, all without any."""
        if not self.shells.number.size:
            raise ValueError(f"{self.path}: no CTRIA3 or CQUAD4; a mesh needs one")
        for name in groups:
            if name not in self.groups:
                names = ", ".join(list(self.groups)[:20])
                raise ValueError(f"{self.path}: has no group {name}; it has {names}")
        if not groups:
            return np.arange(len(self.shells.number))
        return np.unique(np.concatenate([self.groups[name] for name in groups]))

    def corners(self, chosen: Index) -> Index:
        """Return the rows of the corners (n, 4) of shells; triangles repeat the third."""
        tables = [self.shells.corners[k][: SHELLS[self.shells.kind[k]][0]] for k in chosen.tolist()]
        numbers = np.array([(*nodes[:3], nodes[-1]) for nodes in tables], dtype=np.int64)
        if not self.node.size:
            raise ValueError(f"{self.path}: no GRID; a mesh needs some")
        order = np.argsort(self.node)
        rows = np.minimum(np.searchsorted(self.node, numbers, sorter=order), len(order) - 1)
        if (missing := self.node[order[rows]] != numbers).any():
            element, node = self.shells.number[chosen][missing.any(axis=1)][0], numbers[missing][0]
            raise ValueError(f"{self.path}: element {element}: node {node} is missing")
        return np.asarray(order[rows])

    def material_axes(self, chosen: Index) -> tuple[Array, Array]:
        """Return normals (n, 3) of shells, and the x axes (n, 3) of their materials.

        Without MCID an axis is the side from the first to the second corner, turned by THETA.
        """
        a, b, c, d = self.position[self.corners(chosen)].transpose(1, 0, 2)
        is_triangle = (d == c).all(axis=1)[:, None]
        normal = np.cross(c - a, np.where(is_triangle, a, d) - b)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        side = b - a
        for number in np.unique(self.shells.system[chosen]).tolist():
            if number < 0:
                continue
            members = self.shells.system[chosen] == number
            centre = np.where(is_triangle, (a + b + c) / 3, (a + b + c + d) / 4)[members]
            system = self.systems.system(number, str(self.path))
            side[members] = frames(system, centre)[:, :, 0]
            is_across = np.abs(np.sum(side * normal, axis=1)[members]) > ACROSS
            if is_across.any():  # as of a cylindrical system on its cylinder
                element = self.shells.number[chosen][members][is_across.argmax()]
                message = f"element {element}: the x axis of MCID {number} is along its normal"
                raise ValueError(f"{message}; it must be along the surface")
        side -= np.sum(side * normal, axis=1)[:, None] * normal
        side /= np.linalg.norm(side, axis=1)[:, None]
        turn = np.radians(np.nan_to_num(self.shells.angle[chosen]))[:, None]
        return normal, np.asarray(np.cos(turn) * side + np.sin(turn) * np.cross(normal, side))

    def mass_of(self, name: str) -> float:
        """Return the mass that the cards of a name state, in the unit of the deck."""
        place = MASSES[name]
        return sum(real_number([*c.fields, *BLANKS][place]) for c in self.cards.get(name, ()))

    @property
    def mass_factor(self) -> float:
        """WTMASS, by which all masses of the deck are multiplied."""
        stated = WEIGHTS.findall(self.control)
        for card in self.cards.get("PARAM", ()):
            if card.fields[0].upper() == "WTMASS":
                stated.append(card.fields[1])
        return real_number(stated[-1]) if stated else 1.0


@dataclass
class _Reader:
    """What has been read of a deck."""

    places: dict[int, list[float]] = field(default_factory=dict)  # in their system, by node
    options: dict[int, tuple[str, str, str]] = field(default_factory=dict)  # CP, CD, PS
    default: tuple[str, str, str] = ("", "", "")
    systems: dict[int, Card] = field(default_factory=dict)
    shells: list[tuple[str, int, list[int], float, int, float, bool]] = field(default_factory=list)
    groups: dict[str, list[int]] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Read a card of the geometry; raise `ValueError` for what cannot be read."""
        name, fields = card.name, [*card.fields, *BLANKS]
        if name in ("GRID", "GRDSET"):
            options = fields[1], fields[5], fields[6].replace(" ", "")
            for text, label in zip(options, ("CP", "CD", "PS"), strict=True):
                if not re.fullmatch("-?[0-9]*", text):
                    raise ValueError(f"{label} = {text} is not a number")
            if surplus := " ".join(filter("0".__ne__, fields[8:])).strip():
                raise ValueError(f"a field after SEID is not read: {surplus}")
            if name == "GRDSET":
                self.default = options
                return
            number, place = whole_number(fields[0]), [real_number(text) for text in fields[2:5]]
            if self.places.setdefault(number, place) != place:
                raise ValueError(f"node {number} appears twice")
            self.options[number] = options
        elif name in SHELLS:
            self._read_shell(name, fields)
        else:
            numbers = [fields[0], fields[4]] if name in BY_NODES else [fields[0]]
            self.systems |= {whole_number(text): card for text in numbers if text}

    def _read_shell(self, name: str, fields: list[str]) -> None:
        corners, count, place = SHELLS[name]
        nodes = [whole_number(text) for text in fields[2 : 2 + corners]]
        middles = [whole_number(text) if text else 0 for text in fields[2 + corners : 2 + count]]
        direction = fields[place]
        is_system = direction.isdecimal()
        self.groups.setdefault(fields[1] or fields[0], []).append(len(self.shells))
        self.shells.append((
            name, whole_number(fields[0]), nodes + middles if all(middles) else nodes,
            np.nan if is_system else real_number(direction),
            int(direction) if is_system else -1,
            real_number(fields[place + 1]),
            any(real_number(text) for text in fields[slice(*THICKNESS[name])]),
        ))  # fmt: skip


def read_deck(path: Path, *, is_whole: bool = False) -> Deck:
    """Read a deck and the files that it includes; a whole one with its `PROPOSED` cards.

    Raises
    ------
    ValueError
        In one line, the first mistake: file, line, card, what is allowed.
    """
    deck, faults = deck_and_faults(path, is_whole=is_whole)
    if faults:
        raise ValueError(faults[0] + (f"; {len(faults)} such lines" if len(faults) > 1 else ""))
    return deck


def deck_and_faults(path: Path, *, is_whole: bool = False) -> tuple[Deck, list[str]]:
    """Return a deck with a line for each mistake; of a deck with mistakes nothing else is right.

    Of a whole deck `PROPOSED` cards must be right too.
    """
    faults: list[str] = []
    reader, counts = _Reader(), Counter[str]()
    cards: dict[str, list[Card]] = {}
    first: dict[str, str] = {}
    for card in read_cards(path, faults, WHOLE_LIMITS if is_whole else LIMITS):
        counts[card.name] += 1
        first.setdefault(card.name, card.place)
        try:
            if card.name in GEOMETRY:
                reader.read(card)
            elif card.name in PROPOSED:
                cards.setdefault(card.name, []).append(card)
        except ValueError as error:
            faults.append(f"{card.place}: {card.name}: {error}")
        if len(faults) > MOST_FAULTS:
            break
    control = case_control(path)
    return _placed(path, control, reader, cards, counts, first, faults), faults


def _placed(
    path: Path,
    control: str,
    reader: _Reader,
    cards: Mapping[str, Sequence[Card]],
    counts: Mapping[str, int],
    first: Mapping[str, str],
    faults: list[str],
) -> Deck:
    """Return the deck with its nodes in the basic frame."""
    node = np.array(list(reader.places), dtype=np.int64)
    position = np.array(list(reader.places.values()), dtype=float).reshape(-1, 3)
    options = [
        [text or usual for text, usual in zip(stated, reader.default, strict=True)]
        for stated in reader.options.values()
    ]
    fixed = {
        number: components
        for number, (_, _, components) in zip(reader.options, options, strict=True)
        if components not in ("", "0")
    }
    inner, outer = np.array([[int(n or 0) for n in row[:2]] for row in options]).reshape(-1, 2).T
    grids = zip(
        reader.places, zip(inner.tolist(), reader.places.values(), strict=True), strict=True
    )
    tree = Systems(reader.systems, dict(grids))
    frame = np.broadcast_to(np.eye(3), (len(node), 3, 3)).copy()
    for number in np.unique(inner[inner > 0]).tolist() if not faults else ():
        members = inner == number
        position[members] = positions(tree.system(number, str(path)), position[members])
    for number in np.unique(outer[outer > 0]).tolist() if not faults else ():
        members = outer == number
        frame[members] = frames(tree.system(number, str(path)), position[members])
    kinds, numbers, corners, angles, systems, offsets, thick = (
        zip(*reader.shells, strict=True) if reader.shells else ((),) * 7
    )
    element = np.array(numbers, dtype=np.int64)
    shells = Shells(
        kinds, element, corners, np.array(angles, dtype=float), np.array(systems, dtype=np.int64),
        np.array(offsets, dtype=float), thick,
    )  # fmt: skip
    groups = reader.groups | _sets(control, element)
    return Deck(
        path,
        control,
        node,
        position,
        frame,
        fixed,
        shells,
        groups,
        cards,
        counts,
        first,
        tree,
    )


def _sets(control: str, number: Index) -> dict[str, list[int]]:
    """Return the shells of each SET of the case control."""
    groups = {}
    for match in SET.finditer(control):
        try:
            members = numbers_of(re.split(r"[\s,]+", match[2].strip()))
        except ValueError:  # ALL, or real numbers
            continue
        if places := np.flatnonzero(np.isin(number, members)).tolist():
            groups[f"SET {match[1]}"] = places
    return groups
