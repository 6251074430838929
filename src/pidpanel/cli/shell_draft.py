"""What a new study takes from a deck that is not flat: a shell with sections by property."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from pidpanel.arrays import Array, Index
from pidpanel.cli.deck_sections import DeckSection, DeckSections, turned
from pidpanel.cli.mesh_draft import rounded, unit_of_deck
from pidpanel.cli.structure_draft import StructureDraft, patch_near
from pidpanel.modal_files.model import MASS_UNITS
from pidpanel.nastran import Deck, read_deck
from pidpanel.nastran.cards import BLANKS, numbers_of, real_number
from pidpanel.panel.flat_mesh import FLAT
from pidpanel.shell.mesh import ShellMesh
from pidpanel.shell.surface_files import read_deck_surface
from pidpanel.structure.surface import Surface

PAD = 1e-5  # of boxes about nodes over the size of the structure
DIRECTED = 1.0  # largest angle between the axis of a section and those of its elements [°]
ANY_SECTION = {
    "kind": "sandwich", "faces": [{"material": "aluminium", "thickness_mm": 0.3}],
    "materials": {"aluminium": {"youngs_modulus_gpa": 70, "poissons_ratio": 0.3,
                                "density_kg_m3": 2700}},
    "core": {"grade": "3/16-5056-0.0007", "thickness_mm": 20},
}  # fmt: skip


def is_flat(file: Path, groups: Sequence[str]) -> bool:
    """Return whether the shells of a deck are in a plane, or it has none."""
    deck = read_deck(file)
    if not deck.shells.number.size:
        return True
    corners = deck.corners(deck.chosen(groups))
    position = deck.position[np.unique(corners)]
    position = position - position.mean(axis=0)
    normal = np.linalg.svd(position, full_matrices=False)[2][2]
    return bool(np.abs(position @ normal).max() <= FLAT * np.ptp(position, axis=0).max())


def shell_draft(
    file: Path, unit: float | None, groups: Sequence[str], written: Callable[[Path], str]
) -> StructureDraft:
    """Return the draft of the shells of a deck; see `modes_draft`."""
    deck = read_deck(file, is_whole=True)
    unit, guess = (unit, []) if unit else unit_of_deck(deck)
    mesh = read_deck_surface(file, unit, groups)
    surface = Surface(mesh.vertices, mesh.cells)
    sections, remarks = _sections(deck, unit, deck.chosen(groups), mesh)
    share = {name: float(surface.area[mesh.part_cells[name]].sum()) for name in sections}
    largest = max(share, key=lambda name: share[name])
    is_known = any(part["section"] is not ANY_SECTION for part in sections.values())
    attached, missing = _attached(deck, unit, mesh, MASS_UNITS[unit] if is_known else 0.0)
    edges = mesh.vertices[mesh.cells] - mesh.vertices[np.roll(mesh.cells, 1, axis=1)]
    middle, _ = surface.nearest(np.average(surface.middle, axis=0, weights=surface.area))
    far = _far(mesh, middle, attached)
    form = {"kind": "deck", "file": written(file), "unit_m": unit}
    values = {
        "shell": {
            "form": form | ({"groups": list(groups)} if groups else {}),
            **sections[largest],
            "size_m": float(f"{1.01 * np.linalg.norm(edges, axis=2).max():.3g}"),
            "parts": {k: part for k, part in sections.items() if part != sections[largest]},
            **attached,
        },
        "damping_ratio": 0.01,
        "patches": {"centre": patch_near(surface, middle), "edge": patch_near(surface, far)},
        "points": {
            name: {"at_m": _place(mesh.vertices[vertex])}
            for name, vertex in (("P1", middle), ("P2", far))
        },
    }
    counts = ", ".join(f"{len(part)} {name}" for name, part in attached.items()) or "free"
    text = f"a shell of {len(mesh.cells)} facets, {mesh.extent:.4g} m large with a unit of {unit:g}"
    text += f" m, {surface.area.sum():.4g} m², {len(sections)} properties, {counts}"
    return StructureDraft(
        values, np.inf, surface.has_free_edges, text, [*guess, *remarks, *missing], second="edge"
    )


def _sections(
    deck: Deck, unit: float, chosen: Index, mesh: ShellMesh
) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Return section and axis of each property, and what could not be read."""
    remarks, sections = [], {}
    corners = deck.corners(chosen)
    count = 1 + (corners[:, 3] != corners[:, 2])
    first = np.cumsum(count) - count  # cell of each element
    normals = Surface(mesh.vertices, mesh.cells).cell_normal[first]
    for name in mesh.part_cells:
        members = np.flatnonzero(np.isin(chosen, deck.groups[name]))
        try:
            section = DeckSections(deck, unit).section(name)
            normal, axes = deck.material_axes(chosen[members])
            below = np.sum(normal * normals[members], axis=1) < 0
            sections[name] = _directed(section, normal, axes, below)
            offset = np.where(below, -unit, unit) * deck.shells.offset[chosen[members]]
            if np.ptp(offset) > 1e-9 * mesh.extent:
                raise ValueError("ZOFFS differs between its elements")
            if offset[0]:
                sections[name]["offset_m"] = float(offset[0])
        except ValueError as error:
            remarks.append(f"property {name} has a section that is not its own: {error}")
            sections[name] = {"section": ANY_SECTION}
    return sections, remarks


def _directed(section: DeckSection, normal: Array, axes: Array, below: Index) -> dict[str, Any]:
    """Return a section and the axis whose projection on the elements is that of its materials."""
    if not section.is_directional and (section.is_symmetric or not below.any()):
        return {"section": dict(section.values)}
    if 0 < below.sum() < len(below):
        raise ValueError("the normals of its elements are on both sides")
    across = np.cross(normal, axes)
    values, vectors = np.linalg.eigh(across.T @ across / len(axes))
    plane = vectors[:, values < np.radians(DIRECTED) ** 2]
    axis = plane @ (plane.T @ axes.mean(axis=0))
    seen = axis - (normal @ axis)[:, None] * normal
    seen /= np.maximum(np.linalg.norm(seen, axis=1), 1e-12)[:, None]
    turn = np.degrees(np.arccos(np.clip(np.sum(seen * axes, axis=1), -1, 1))).max()
    if section.is_directional and turn > DIRECTED:
        raise ValueError(f"its x axes of materials are {turn:.3g}° off one direction in space")
    stated = turned(section, 0.0, is_below=bool(below.any()))
    if not section.is_directional:
        return {"section": stated}
    return {"section": stated, "axis": _place(axis / np.abs(axis).max())}


def _attached(
    deck: Deck, unit: float, mesh: ShellMesh, mass_unit: float
) -> tuple[dict[str, Any], list[str]]:
    """Return supports, feet and masses, and what of them is left out.

    ``mass_unit`` is the unit of masses [kg], 0 where no section tells it.
    """
    components, remarks = deck.constraints()
    place = dict(zip(deck.node.tolist(), unit * deck.position, strict=True))
    vertex = {tuple(x): k for k, x in enumerate(mesh.vertices.tolist())}
    numbers = {node: vertex.get(tuple(x.tolist())) for node, x in place.items()}
    row = {node: number for node, number in numbers.items() if number is not None}
    if not mass_unit and "CONM2" in deck.cards:
        remarks.append("point masses are left out: no section tells the unit of masses")
    factor = mass_unit * deck.mass_factor
    mass: dict[int, float] = {}
    for card in deck.cards.get("CONM2", ()):
        fields = [*card.fields, *BLANKS]
        node = int(fields[1])
        mass[node] = mass.get(node, 0.0) + factor * real_number(fields[3])
    attached: dict[str, Any] = {"supports": {}, "feet": {}, "masses": {}}
    for card in deck.cards.get("RBE2", ()):
        centre, nodes = int(card.fields[1]), numbers_of(card.fields[3:])
        if not (inside := [row[n] for n in nodes if n in row]):
            continue
        box = _box(inside, mesh)
        kind = _kind(components.get(centre, "")) or "free"
        if box is None or len(nodes) < 2 or card.fields[2] != "123456":
            remarks.append(f"RBE2 {card.fields[0]} is left out: no box holds its nodes alone")
            continue
        foot: dict[str, Any] = {"where": box, "centre_m": _place(place[centre]), "kind": kind}
        if kind == "free" and mass.get(centre):
            foot["mass_kg"] = rounded(mass.pop(centre))
        attached["feet"][f"RBE2 {card.fields[0]}"] = foot
    for kind in ("clamped", "pinned"):
        fixed = {row[n] for n, text in components.items() if n in row and _kind(text) == kind}
        for cluster in _clusters(fixed, mesh):
            if (box := _box(cluster, mesh)) is None:
                remarks.append(f"{len(cluster)} nodes that are {kind} are left free: no box")
            else:
                name = f"support {len(attached['supports']) + 1}"
                attached["supports"][name] = {"where": box, "kind": kind}
    if partly := [n for n, text in components.items() if n in row and not _kind(text)]:
        remarks.append(f"{len(partly)} nodes held in some directions are left free ({partly[0]})")
    for node, value in mass.items():
        if node in row and value > 0:
            attached["masses"][f"mass {node}"] = {
                "mass_kg": rounded(value), "at_m": _place(place[node]),
            }  # fmt: skip
        elif value > 0:
            remarks.append(f"a mass of {value:.3g} kg at node {node} is left out")
    return {name: part for name, part in attached.items() if part}, remarks


def _far(mesh: ShellMesh, middle: int, attached: Mapping[str, Any]) -> int:
    """Return the vertex farthest from all supports, from the middle without any."""
    boxes = [
        part["where"]
        for name in ("supports", "feet")
        for part in attached.get(name, {}).values()
        if part["kind"] != "free"
    ]
    x = mesh.vertices
    inside = [((x >= box["from_m"]) & (x <= box["to_m"])).all(axis=1) for box in boxes] or [
        np.arange(len(x)) == middle
    ]
    return int(cKDTree(x[np.any(inside, axis=0)]).query(x)[0].argmax())


def _kind(components: str) -> str:
    """Return the support of held components; empty where some motions are free."""
    if set("123456") <= set(components):
        return "clamped"
    return "pinned" if set("123") == set(components) else ""


def _clusters(rows: set[int], mesh: ShellMesh) -> Iterator[list[int]]:
    """Yield vertices that elements join."""
    nodes = np.array(sorted(rows), dtype=np.int64)
    if not nodes.size:
        return
    pairs = np.concatenate([mesh.cells[:, [0, 1]], mesh.cells[:, [1, 2]], mesh.cells[:, [2, 0]]])
    pairs = np.searchsorted(nodes, pairs[np.isin(pairs, nodes).all(axis=1)])
    graph = sp.coo_array((np.ones(len(pairs)), tuple(pairs.T)), (len(nodes),) * 2)
    _, label = connected_components(graph, directed=False)
    for number in range(label.max() + 1):
        yield nodes[label == number].tolist()


def _box(rows: Sequence[int], mesh: ShellMesh) -> dict[str, Any] | None:
    """Return a box that has these vertices alone; None if there is none."""
    if not rows:
        return None
    pad, x = PAD * mesh.extent, mesh.vertices
    low, high = x[rows].min(axis=0) - pad, x[rows].max(axis=0) + pad
    if int(((x >= low) & (x <= high)).all(axis=1).sum()) != len(set(rows)):
        return None
    return {"from_m": _place(low), "to_m": _place(high)}


def _place(x: Array) -> list[float]:
    return [float(f"{value:.7g}") for value in (np.round(x, 9) + 0.0).tolist()]
