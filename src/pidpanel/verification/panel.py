"""Natural frequencies of panels compared with closed forms and published values."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import yaml
from skfem import CellBasis

from pidpanel.arrays import Array, Index
from pidpanel.geometry.polygon import Circle, Polygon
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection, ThinSection
from pidpanel.panel.stretching import in_plane_basis, membrane_tensor
from pidpanel.panel.supports import Block, EdgeSupport, Supports, free_coordinates
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.paths import DATA
from pidpanel.verification.rows import Row, cases_of, comparison

FACE = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
DISC = Circle((0.0, 0.0), 1.0)
UNIT_PLATE = ThinSection(bending_stiffness=1.0, mass_per_area=1.0, poissons_ratio=0.3)


def rectangle(a: float, b: float) -> Polygon:
    """Return the outline of [0, a] × [0, b] m."""
    return Polygon(((0.0, 0.0), (a, 0.0), (a, b), (0.0, b)))


def _sandwich(path: Path) -> AssembledPlate:
    section = SandwichSection((FACE,), (FACE,), Core(186e6, 90e6, 32.0, 24.4e-3))
    return assemble_shear_plate(mesh_triangles(path, rectangle(1.5, 1.0), 0.1, {}, {}), section)


def _thin_nafems(path: Path) -> AssembledPlate:
    section = ThinSection(200e9 * 0.05**3 / 12 / (1 - 0.3**2), 8000 * 0.05, 0.3, 0.05)
    return assemble_thin_plate(mesh_quadrilaterals(path, (10.0, 10.0), (12, 12), {}, {}), section)


def _thick_nafems(path: Path) -> AssembledPlate:
    section = SolidSection(200e9, 0.3, 8000.0, 1.0, np.pi**2 / 12)
    return assemble_shear_plate(mesh_triangles(path, rectangle(10, 10), 1.0, {}, {}), section)


def _unit_plate(path: Path, outline: Polygon | Circle, size: float, support: str) -> AssembledPlate:
    mesh = mesh_triangles(path, outline, size, {}, {})
    return assemble_thin_plate(mesh, UNIT_PLATE, Supports(support))


# Each assembles a panel of ``panels.yaml``, with the ``.msh`` file to write.
PLATES = {
    "sandwich": _sandwich,
    "nafems_13": _thin_nafems,
    "nafems_21": _thick_nafems,
    "clamped_square": lambda path: _unit_plate(path, rectangle(1, 1), 0.25, "clamped"),
    "free_square": lambda path: _unit_plate(path, rectangle(1, 1), 0.25, "free"),
    "supported_disc": lambda path: _unit_plate(path, DISC, 0.4, "simply_supported"),
    "clamped_disc": lambda path: _unit_plate(path, DISC, 0.4, "clamped"),
}
PUBLISHED = yaml.safe_load((DATA / "reference" / "panels.yaml").read_text(encoding="utf-8"))


def _frequency_rows(name: str, folder: Path) -> Iterator[Row]:
    """Return the lowest frequencies of a panel with the published ones."""
    plate, published = PLATES[name](folder / "verification.msh"), PUBLISHED[name]
    reference = np.array(published["reference"])
    if published.get("is_angular", False):
        reference = 1 / (2 * np.pi) * reference
    frequency, _ = normal_modes(plate, 1.02 * float(reference[-1]))
    rigid = np.sum(frequency == 0)
    element, source = published["element"], published["source"]
    elastic = Row(
        case=published["name"], unit="Hz", tolerance=published["tolerance"], source=source,
        method=f"{element}, {plate.stiffness.shape[0]} coordinates",
    )  # fmt: skip
    statics = replace(elastic, unit="1", tolerance=0.0, method=element, source="statics")
    for mode, pair in enumerate(zip(frequency[rigid:], reference, strict=False), 1):
        yield elastic.row(f"frequency of mode {mode}", *pair, mode)
    yield statics.row("number of rigid-body modes", rigid, published.get("rigid", 0))


TAPE = Material(280e9, 6.5e9, 4.5e9, 0.3, 1600.0)
CORNERS = np.array([(0.0, 0.0), (0.9, 0.1), (0.8, 0.7), (0.1, 0.6)])
TURNS = {"turned by 37°": np.radians(37.0), "turned by 90°": np.pi / 2}


def _orthotropic_frequencies(mesh: PanelMesh, turn: float) -> Array:
    """Return frequencies of an unsymmetric layup, clamped on one edge, rotated about the origin."""
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    face = tuple(Ply(TAPE, 0.15e-3, np.radians(angle) + turn) for angle in (20.0, 75.0))
    section = SandwichSection(face, face, Core(310e6, 138e6, 50.0, 20e-3, np.radians(25.0) + turn))
    (x0, y0), (x1, y1) = (CORNERS[1:3] @ matrix.T).tolist()
    supports = Supports("simply_supported", edges=[EdgeSupport((x0, y0), (x1, y1), "clamped")])
    turned = replace(mesh, vertices=mesh.vertices @ matrix.T)
    return normal_modes(assemble_shear_plate(turned, section, supports), 2000.0)[0]


def turned_rows(folder: Path) -> Iterator[Row]:
    """Compare an orthotropic panel rotated with its layup and ribbon with the original one."""
    outline = Polygon(tuple((float(x), float(y)) for x, y in CORNERS))
    mesh = mesh_triangles(folder / "panel.msh", outline, 0.08, {}, {})
    reference = _orthotropic_frequencies(mesh, 0.0)
    turned = comparison("turned", count=len(mesh.cells))
    for name, turn in TURNS.items():
        frequency = _orthotropic_frequencies(mesh, turn)
        for mode, pair in enumerate(zip(frequency, reference, strict=True), 1):
            yield turned.row(f"{name}: frequency {mode}", *pair)


def stretched_rows(folder: Path) -> Iterator[Row]:
    """Compute the cubic stiffness of the first mode of rectangles, w = q sin(πx/a) sin(πy/b).

    Their edges cannot move along their normal in the plane (Chu and Herrmann), or stay straight
    without a force on the average (Levy). Tangential motion is free.
    """
    stretched = comparison("stretched")
    nu, size = UNIT_PLATE.poissons_ratio, 0.05
    A = replace(UNIT_PLATE, extensional_stiffness=1.0).extensional
    for a, b in ((1.0, 1.0), (1.5, 1.0), (2.0, 1.0)):
        mesh = mesh_triangles(folder / f"stretched_{a:g}.msh", rectangle(a, b), size, {}, {})
        basis = in_plane_basis(mesh)
        x, y = np.pi * basis.global_coordinates().reshape(2, -1) / np.array([[a], [b]])
        slopes = np.pi * np.stack([np.cos(x) * np.sin(y) / a, np.sin(x) * np.cos(y) / b])
        movable = (1 - nu**2) * np.pi**4 * a * b / 64 * (a**-4 + b**-4)
        stretch = np.pi**4 * a * b / 32 * (a**-4 + b**-4 + 2 * nu / (a * b) ** 2)
        for edges, expected in (("straight", movable), ("immovable", movable + stretch)):
            free = _edges_along_normal(basis, (a, b), is_straight=edges == "straight")
            tensor = membrane_tensor(basis, A, slopes[:, :, None], free)
            quantity = f"{a:g} × {b:g} m, {edges} edges: cubic stiffness"
            yield stretched.row(quantity, 2 * tensor[0, 0, 0, 0], expected, a / b)


def _edges_along_normal(
    basis: CellBasis, size: tuple[float, float], *, is_straight: bool
) -> sp.csr_array:
    """Return the free in-plane coordinates of a rectangle from the origin.

    Edges do not move along their normal; or the two far ones, if straight, by one amount each.
    """
    blocks, columns = [], np.ones((1, 0))
    for axis, length in enumerate(size):
        on_edges = basis.get_dofs().flatten()
        place = basis.doflocs[axis]
        own = on_edges[_component(basis)[on_edges] == axis]
        far = own[np.isclose(place[own], length)]
        near = own[np.isclose(place[own], 0.0)]
        blocks += [Block(f"edge {axis}", np.array([dof]), columns) for dof in near]
        blocks.append(Block(f"far edge {axis}", far, np.ones((len(far), int(is_straight)))))
    return free_coordinates(basis.N, blocks)


def _component(basis: CellBasis) -> Index:
    """Return 0 or 1 of each coordinate (n,): along x or y."""
    component = np.zeros(basis.N, dtype=np.int64)
    for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs):
        component[dofs[1::2].ravel()] = 1
    return component


CASES = {name: partial(_frequency_rows, name) for name in PLATES} | cases_of(globals())
