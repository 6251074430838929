"""What a new study takes from a mesh file: its unit, supports, section, and places on it."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.constants import PLACING_CARDS
from pidpanel.panel.flat_mesh import FlatMesh, MeshFileError
from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.nastran import IGNORED, READ, SYSTEMS, read_cards, read_nastran, real_number

LONGEST = 20.0  # of a panel in metres: a file that extends further is in millimetres
CLOSE = 1e-6  # distance from a side over the extent, up to which a node lies on it
FACE_DENSITY = (500.0, 25000.0)  # of plies [kg/m³]; outside, a deck has other units

# Places of what is read among the fields of a card
MATERIALS = {
    "MAT1": {"E": 1, "G": 2, "nu": 3, "rho": 4},
    "MAT8": {"E": 1, "E2": 2, "nu": 3, "G": 4, "GL": 5, "GW": 6, "rho": 7},
}

LISTS = ("SPC", "SPC1", "PCOMP", "CONM2", *MATERIALS)  # all fields of which are read

Cards = Sequence[tuple[str, list[str]]]


class MeshDraft(NamedTuple):
    """A mesh file as a study describes it."""

    mesh: FlatMesh
    unit: float  # [m]
    ignored: Sequence[str]  # cards of supports, loads and masses
    supports: Mapping[str, Any]  # section ``panel.supports``
    section: Mapping[str, Any]  # section ``panel.section``; empty where the file has none
    masses: Mapping[str, Any]  # section ``panel.masses``; empty with other units

    @classmethod
    def of_file(cls, file: Path, unit: float | None, *, is_thin: bool) -> "MeshDraft":
        """Return the draft of a gmsh file or a Nastran deck."""
        cards: list[tuple[str, list[str]]] = []
        if file.suffix.lower() != ".msh":
            faults: list[str] = []
            for _, name, fields in read_cards(file, faults, LISTS):
                cards.append((name, fields + 16 * [""]))
            if faults:
                raise MeshFileError(faults)
        names = {name for name, _ in cards} - {*READ, *IGNORED, *SYSTEMS}
        ignored = sorted(name for name in names if not PLACING_CARDS.match(name))

        def read(length: float) -> FlatMesh:
            return read_nastran(file, ignored, length) if cards else read_gmsh(file, length)

        mesh = read(unit or 1.0)
        if unit is None and np.ptp(mesh.position, axis=0).max() > LONGEST:
            return cls.of_file(file, 1e-3, is_thin=is_thin)
        supports = _supports(cards, mesh, is_thin=is_thin)
        section = _section(cards, unit or 1.0)
        masses = _masses(cards, mesh, unit or 1.0) if section else {}
        return cls(mesh, unit or 1.0, ignored, supports, section, masses)

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [m]."""
        x, y = np.ptp(self.mesh.position, axis=0).tolist()
        return x, y

    @property
    def text(self) -> str:
        """What was understood, in words."""
        sides, points = (len(self.supports.get(key, ())) for key in ("edges", "points"))
        held = f"edges {self.supports['outline']}"
        held += f" but {sides} sides" * (sides > 0) + f", {points} nodes held" * (points > 0)
        held += ", point masses left out" * ("CONM2" in self.ignored and not self.masses)
        a, b = self.size
        return f"{a:.4g} x {b:.4g} m with a unit of {self.unit:g} m, {held}"

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


def _union(triangles: np.ndarray) -> BaseGeometry:
    """Return the largest part of the union of triangles (n, 3, 2)."""
    area = shapely.union_all(shapely.polygons(triangles))
    return max(shapely.get_parts(area), key=shapely.area)


def _corners(area: BaseGeometry) -> list[list[float]]:
    """Return the corners of an outline, without nodes on its sides."""
    ring = shapely.simplify(area, CLOSE * area.length).exterior.normalize()
    return [[float(f"{value:.9g}") for value in corner] for corner in ring.coords[:-1]]


def _held_nodes(cards: Cards) -> Iterator[tuple[int, str]]:
    """Yield node and components of each constraint of w."""
    for name, fields in cards:
        if name == "SPC1" and "3" in fields[1]:
            nodes = [text for text in fields[2:] if text]
            if "THRU" in map(str.upper, nodes):
                nodes = list(map(str, range(int(nodes[0]), int(nodes[2]) + 1)))
            yield from ((int(node), fields[1]) for node in nodes)
        elif name == "GRID" and "3" in fields[6]:
            yield int(fields[0]), fields[6]
        elif name == "SPC":
            yield from ((int(fields[k]), fields[k + 1]) for k in (1, 4) if "3" in fields[k + 1])


def _supports(cards: Cards, mesh: FlatMesh, *, is_thin: bool) -> dict[str, Any]:
    """Return the section ``panel.supports``: whole sides, and other nodes as points."""
    held = {node: components for node, components in _held_nodes(cards) if node in mesh.node}
    nodes, sides = np.array(list(held), dtype=int), []
    ring = _corners(_union(mesh.position[mesh.triangles]))
    left = dict(held)
    for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
        side = shapely.LineString([a, b])
        distance = shapely.distance(shapely.points(mesh.position), side)
        on_side = mesh.node[distance <= CLOSE * np.ptp(mesh.position)]
        if np.isin(on_side, nodes).all():
            is_clamped = all({"4", "5"} <= set(held[node]) for node in on_side.tolist())
            sides.append((a, b, "clamped" if is_clamped else "simply_supported"))
            left = {node: text for node, text in left.items() if node not in on_side}
    kinds = {kind for *_, kind in sides}
    if len(sides) == len(ring) and len(kinds) == 1:
        supports: dict[str, Any] = {"outline": kinds.pop()}
    else:
        edges = [{"from_m": a, "to_m": b, "kind": kind} for a, b, kind in sides]
        supports = {"outline": "free"} | ({"edges": edges} if edges else {})
    points = {}
    for number, (node, text) in enumerate(sorted(left.items()), 1):
        is_rigid = {"4", "5"} <= set(text) and not is_thin
        points[f"H{number}"] = {"grid": node, "kind": "hold_down" if is_rigid else "hinge"}
    return supports | ({"points": points} if points else {})


def _masses(cards: Cards, mesh: FlatMesh, unit: float) -> dict[str, Any]:
    """Return the section ``panel.masses``: the CONM2 on the panel, in t or kg by the unit."""
    factor = 1.0 if unit == 1.0 else 1e3
    return {
        f"mass {fields[0]}": {
            "grid": int(fields[1]),
            "mass_kg": _rounded(factor * real_number(fields[3])),
        }
        for name, fields in cards
        if name == "CONM2" and int(fields[1]) in mesh.node
    }


def _section(cards: Cards, unit: float) -> dict[str, Any]:
    """Return the section ``panel.section`` of the only PCOMP of a deck; empty without a core."""
    laminates = [fields for name, fields in cards if name == "PCOMP"]
    if len(laminates) != 1 or unit not in (1.0, 1e-3):
        return {}
    density = 1.0 if unit == 1.0 else 1e12  # of t/mm³
    scale = {"rho": density, "nu": 1.0}  # others are moduli, in N/m² or N/mm²
    materials: dict[str, dict[str, float]] = {}
    for name, fields in cards:
        for key, place in MATERIALS.get(name, {}).items():
            value = real_number(fields[place] or "0") * scale.get(key, unit**-2)
            materials.setdefault(fields[0], {})[key] = value
    plies = _plies(laminates[0], unit)
    core = max(range(len(plies)), key=lambda k: plies[k]["thickness_mm"])
    bottom, top = plies[:core], plies[:core:-1]
    if not {ply["material"] for ply in plies} <= set(materials):
        return {}
    skins = {ply["material"]: materials[ply["material"]] for ply in bottom + top}
    low, high = FACE_DENSITY
    if not (bottom and top and all(low < skin["rho"] < high for skin in skins.values())):
        return {}
    honeycomb = materials[plies[core]["material"]]
    shear = (honeycomb.get(key, honeycomb["G"]) for key in ("GL", "GW"))
    names = ("shear_modulus_l_mpa", "shear_modulus_w_mpa")
    mass = real_number(laminates[0][2] or "0") * density * unit
    return {
        "kind": "sandwich",
        "materials": {name: _material(skin) for name, skin in skins.items()},
        **({"faces": top} if top == bottom else {"top": top, "bottom": bottom}),
        "core": {
            "thickness_mm": plies[core]["thickness_mm"],
            **{name: _rounded(1e-6 * modulus) for name, modulus in zip(names, shear, strict=True)},
            "density_kg_m3": _rounded(honeycomb["rho"]),
            "ribbon_deg": plies[core]["angle_deg"],
        },
        "extra_mass_per_area_kg_m2": _rounded(mass),
    }


def _material(values: Mapping[str, float]) -> dict[str, float]:
    """Return a material of ``panel.section.materials``."""
    keys = {"E": "e1_gpa", "E2": "e2_gpa", "G": "g12_gpa"}
    if "E2" not in values:
        keys = {"E": "youngs_modulus_gpa"}
    moduli = {name: _rounded(1e-9 * values[key]) for key, name in keys.items()}
    ratio = {"nu12" if "E2" in values else "poissons_ratio": values["nu"]}
    return {**moduli, **ratio, "density_kg_m3": _rounded(values["rho"])}


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def _plies(fields: Sequence[str], unit: float) -> list[dict[str, Any]]:
    """Return the plies of a PCOMP from −z to +z; neighbours of the same kind are one."""
    stated: list[dict[str, Any]] = []
    for k in range(8, len(fields) - 3, 4):
        if any(fields[k : k + 3]):
            material, thickness, angle = fields[k : k + 3]
            last = stated[-1] if stated else {"material": "", "thickness_mm": 0.0}
            length = 1e3 * unit * real_number(thickness) if thickness else last["thickness_mm"]
            stated.append({
                "material": material or last["material"], "thickness_mm": float(f"{length:.9g}"),
                "angle_deg": real_number(angle or "0"),
            })  # fmt: skip
    if fields[7].upper() == "SYM":
        stated += [dict(ply) for ply in reversed(stated)]
    plies: list[dict[str, Any]] = []
    for ply in stated:
        if plies and all(ply[key] == plies[-1][key] for key in ("material", "angle_deg")):
            plies[-1]["thickness_mm"] += ply["thickness_mm"]
        else:
            plies.append(ply)
    return plies
