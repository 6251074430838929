"""What a new study takes from a mesh file: its unit, supports, section, and places on it."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Array, Index
from pidpanel.cli.deck_sections import DeckSection, DeckSections, turned
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.modal_files.model import MASS_UNITS
from pidpanel.nastran import Deck
from pidpanel.nastran.cards import BLANKS, real_number
from pidpanel.panel.flat_mesh import FlatMesh
from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.nastran import checked_deck, flat_mesh, is_refused

CARD = re.compile("[A-Z][A-Z0-9]{1,7}")
LONGEST = 20.0  # of a panel in metres: a file that extends further is in millimetres
CLOSE = 1e-6  # distance from a side over the extent, up to which a node lies on it
ALIGNED = 1e-3  # sine of the angle within which a direction is held
SPREAD = 1.0  # largest angle between directions of materials that count as one [°]


class MeshDraft(NamedTuple):
    """A mesh file as a study describes it."""

    mesh: FlatMesh
    unit: float  # [m]
    ignored: Sequence[str] = ()  # cards of supports, loads and masses
    groups: Sequence[str] = ()  # those that the panel consists of
    supports: Mapping[str, Any] = {"outline": "simply_supported"}  # ``panel.supports``
    section: Mapping[str, Any] = {}  # ``panel.section``; empty where the file has none
    masses: Mapping[str, Any] = {}  # ``panel.masses``; empty with other units
    remarks: Sequence[str] = ()  # what of the file is not in the study

    @classmethod
    def of_file(
        cls, file: Path, unit: float | None, groups: Sequence[str] = (), kind: str | None = None
    ) -> "MeshDraft":
        """Return the draft of a gmsh file or a Nastran deck; elements of groups, or all.

        ``kind`` is that of the section; that of the deck where it is None.
        """
        if file.suffix.lower() == ".msh":
            mesh = read_gmsh(file, unit or 1.0)
            if unit is None and np.ptp(mesh.position, axis=0).max() > LONGEST:
                return cls.of_file(file, 1e-3)
            return cls(mesh, unit or 1.0, supports=_supports({}, mesh, is_thin=False))
        deck = checked_deck(file, groups=groups)
        unit, guess = (unit, []) if unit else unit_of_deck(deck)
        mesh = flat_mesh(deck, unit, groups)
        components, remarks = deck.constraints()
        fixed, oblique = _held_across(deck, mesh, components)
        section, refused = _section(deck, mesh, unit)
        masses, missing = _masses(deck, mesh, MASS_UNITS[unit] if section else 0.0)
        section, refused = ({}, []) if kind else (section, refused)
        is_thin = (kind or section.get("kind")) == "thin"
        refused_without = [name for name in deck.first if is_refused(name)]
        if not groups and (odd := [name for name in refused_without if not CARD.fullmatch(name)]):
            raise ValueError(f"{deck.first[odd[0]]}: {odd[0]} is no card of bulk data")
        return cls(
            mesh, unit, [] if groups else sorted(refused_without), groups,
            _supports(fixed, mesh, is_thin=is_thin), section, masses,
            [*guess, *remarks, *oblique, *refused, *missing],
        )  # fmt: skip

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [m]."""
        x, y = np.ptp(self.mesh.position, axis=0).tolist()
        return x, y

    @property
    def text(self) -> str:
        """What was understood, in words."""
        sides, points = (len(self.supports.get(key, ())) for key in ("edges", "points"))
        text = f"edges {self.supports['outline']}"
        text += f" but {sides} sides" * (sides > 0) + f", {points} nodes held" * (points > 0)
        a, b = self.size
        return f"{a:.4g} x {b:.4g} m with a unit of {self.unit:g} m, {text}"

    def patch(self, x: float, y: float, edge: float) -> list[list[float]]:
        """Return the corners [m] of whole elements near a square, by shares of the extent."""
        nodes = self.mesh.position
        centre = nodes.min(axis=0) + (x, y) * np.ptp(nodes, axis=0)
        low, high = (
            [nodes[np.abs(nodes[:, k] - value[k]).argmin(), k] for k in (0, 1)]
            for value in (centre - edge / 2, centre + edge / 2)
        )
        corners = nodes[self.mesh.triangles]
        middle = corners.mean(axis=1)
        inside = shapely.contains_xy(shapely.box(*low, *high), middle)
        if not inside.any():  # in a coarse mesh
            inside[np.linalg.norm(middle - centre, axis=1).argmin()] = True
        return _corners(_union(corners[inside]))

    def node(self, x: float, y: float) -> int:
        """Return the node nearest to a place, by shares of the extent."""
        nodes = self.mesh.position
        place = nodes.min(axis=0) + (x, y) * np.ptp(nodes, axis=0)
        return int(self.mesh.node[np.linalg.norm(nodes - place, axis=1).argmin()])


def unit_of_materials(deck: Deck) -> float | None:
    """Return the unit of length with which the materials of a deck are possible [m], or None.

    Where densities are wrong in all units, such as weights, the moduli alone tell it.
    """
    cards = [card for name in ("PCOMP", "PSHELL") for card in deck.cards.get(name, ())]
    for has_density in (True, False):
        possible = [
            unit
            for unit in MASS_UNITS
            for card in cards
            if DeckSections(deck, unit).is_possible(card.fields[0], has_density=has_density)
        ]
        if possible and (has_density or len(set(possible)) == 1):
            return max(possible, key=possible.count)
    return None


def unit_of_deck(deck: Deck) -> tuple[float, list[str]]:
    """Return the unit of the materials of a deck, or by its extent [m]; and a remark then."""
    if unit := unit_of_materials(deck):
        return unit, []
    extent = np.ptp(deck.position, axis=0).max() if len(deck.position) else 0.0
    unit = 1e-3 if extent > LONGEST else 1.0
    return unit, [f"the unit of {unit:g} m is by the extent alone: --unit-m states it"]


def _union(triangles: np.ndarray) -> BaseGeometry:
    """Return the largest part of the union of triangles (n, 3, 2)."""
    area = shapely.union_all(shapely.polygons(triangles))
    return max(shapely.get_parts(area), key=shapely.area)


def _corners(area: BaseGeometry) -> list[list[float]]:
    """Return the corners of an outline, without nodes on its sides."""
    ring = shapely.simplify(area, CLOSE * area.length).exterior.normalize()
    return [[float(f"{value:.9g}") for value in corner] for corner in ring.coords[:-1]]


def _held_across(
    deck: Deck, mesh: FlatMesh, components: Mapping[int, str]
) -> tuple[dict[int, bool], list[str]]:
    """Return the nodes of a panel that are held across it, and whether they cannot turn.

    Components are along the axes of displacements (CD).
    """
    frame = dict(zip(deck.node.tolist(), deck.frame, strict=True))
    normal = np.cross(*mesh.axes.T)
    fixed, oblique = {}, []
    for node, text in components.items():
        if node not in mesh.node:
            continue

        def shares(direction: Array, first: int, node: int = node, text: str = text) -> Array:
            columns = [k for k in range(3) if str(first + k) in text]
            return np.linalg.norm(frame[node][:, columns].T @ direction, axis=0)

        (along,) = shares(normal[:, None], 1)
        if along > 1 - ALIGNED:
            fixed[node] = bool((shares(mesh.axes, 4) > 1 - ALIGNED).all())
        elif along > ALIGNED:
            oblique.append(node)
    if not oblique:
        return fixed, []
    return fixed, [f"{len(oblique)} nodes held obliquely to the panel are left free ({oblique[0]})"]


def _supports(fixed: Mapping[int, bool], mesh: FlatMesh, *, is_thin: bool) -> dict[str, Any]:
    """Return the section ``panel.supports``: whole sides, and other nodes as points."""
    nodes, sides = np.array(list(fixed), dtype=int), []
    ring = _corners(_union(mesh.position[mesh.triangles]))
    left = dict(fixed)
    for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
        side = shapely.LineString([a, b])
        distance = shapely.distance(shapely.points(mesh.position), side)
        on_side = mesh.node[distance <= CLOSE * np.ptp(mesh.position)]
        if np.isin(on_side, nodes).all():
            is_clamped = all(fixed[node] for node in on_side.tolist())
            sides.append((a, b, "clamped" if is_clamped else "simply_supported"))
            left = {node: turns for node, turns in left.items() if node not in on_side}
    kinds = {kind for *_, kind in sides}
    if len(sides) == len(ring) and len(kinds) == 1:
        supports: dict[str, Any] = {"outline": kinds.pop()}
    else:
        edges = [{"from_m": a, "to_m": b, "kind": kind} for a, b, kind in sides]
        supports = {"outline": "free"} | ({"edges": edges} if edges else {})
    points = {}
    for number, (node, is_rigid) in enumerate(sorted(left.items()), 1):
        kind = "hold_down" if is_rigid and not is_thin else "hinge"
        points[f"H{number}"] = {"grid": node, "kind": kind}
    return supports | ({"points": points} if points else {})


def _masses(deck: Deck, mesh: FlatMesh, unit: float) -> tuple[dict[str, Any], list[str]]:
    """Return the section ``panel.masses``: the CONM2 on the panel; and those that are left out.

    ``unit`` is the unit of masses [kg], 0 where it is not known.
    """
    masses, elsewhere, is_offset = {}, 0.0, False
    factor = unit * deck.mass_factor
    for card in deck.cards.get("CONM2", ()):
        fields = [*card.fields, *BLANKS]
        mass = factor * real_number(fields[3])
        if mass > 0 and fields[1].isdigit() and int(fields[1]) in mesh.node:
            masses[f"mass {fields[0]}"] = {"grid": int(fields[1]), "mass_kg": rounded(mass)}
            is_offset |= any(real_number(text) for text in fields[4:7])
        else:
            elsewhere += mass
    remarks = []
    if not factor and "CONM2" in deck.cards:
        remarks.append("point masses are left out: no section tells the unit of masses")
    elif elsewhere:
        remarks.append(f"point masses of {elsewhere:.3g} kg that are not on the panel are left out")
    if names := [name for name in deck.counts if name in ("CONM1", "CMASS2", "CMASS4", "CMASS1")]:
        remarks.append(f"masses of {', '.join(names)} are left out")
    if is_offset:
        remarks.append("offsets of point masses are left out")
    return masses, remarks


def _section(deck: Deck, mesh: FlatMesh, unit: float) -> tuple[dict[str, Any], list[str]]:
    """Return the section ``panel.section`` of the property with most area; or why there is none."""
    area = cell_areas(mesh.position, mesh.triangles)
    members = {name: cells for name, cells in mesh.groups.items() if not name.startswith("SET")}
    largest = max(members, key=lambda name: area[members[name]].sum())
    remarks = []
    try:
        section = DeckSections(deck, unit).section(largest)
        places = np.array([k for k in deck.groups[largest] if _is_in(deck, mesh, k)])
        values = _turned_to_panel(deck, mesh, places, section)
    except ValueError as error:
        return {}, [f"section of the options: {error}"]
    if len(members) > 1:
        share = area[members[largest]].sum() / area.sum()
        names = ", ".join(sorted(set(members) - {largest})[:6])
        remarks.append(f"section of property {largest}, {share:.0%} of the area; others: {names}")
    return values, remarks


def _is_in(deck: Deck, mesh: FlatMesh, place: int) -> bool:
    return bool(np.isin(deck.shells.corners[place][:3], mesh.node).all())


def _turned_to_panel(
    deck: Deck, mesh: FlatMesh, places: Index, section: DeckSection
) -> dict[str, Any]:
    """Return a section with angles from the panel's x, seen from its z."""
    normal, axis = deck.material_axes(places)
    is_below = normal @ np.cross(*mesh.axes.T) < 0
    x, y = (axis @ mesh.axes).T
    turn = np.exp(2j * np.arctan2(y, x))  # a direction has no sense
    mean = turn.mean() or 1.0
    spread = np.degrees(np.ptp(np.angle(turn * np.conj(mean)))) / 2
    if section.is_directional and spread > SPREAD:
        message = (
            f"the x axes of its materials differ by {spread:.3g}° (THETA, MCID or first sides)"
        )
        raise ValueError(f"{message}; a panel has one")
    needs_side = section.is_directional or not section.is_symmetric
    if needs_side and 0 < is_below.sum() < len(is_below):
        raise ValueError("the normals of its elements are on both sides; a panel has one")
    if not needs_side:
        return dict(section.values)
    degrees = float(np.degrees(np.angle(mean)) / 2)
    return turned(section, degrees, is_below=bool(is_below.any()))


def rounded(value: float) -> float:
    """Return a value with six digits."""
    return float(f"{value:.6g}")
