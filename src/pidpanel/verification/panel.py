"""Natural frequencies of panels compared with closed forms and published values."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Circle, Polygon
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.layup import Core, Material, Ply, SandwichSection
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import SolidSection, ThinSection
from pidpanel.panel.supports import EdgeSupport, Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.verification.rows import Comparison, Row

FACE = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
UNIT_PLATE = ThinSection(bending_stiffness=1.0, mass_per_area=1.0, poissons_ratio=0.3)


def rectangle(a: float, b: float) -> Polygon:
    """Return the outline of [0, a] × [0, b] m."""
    return Polygon(((0.0, 0.0), (a, 0.0), (a, b), (0.0, b)))


@dataclass(frozen=True)
class ReferencePanel:
    """A panel whose frequencies are known."""

    name: str
    source: str
    plate: Callable[[Path], AssembledPlate]  # assembles the plate; takes the ``.msh`` file to write
    element: str
    reference: tuple[float, ...]  # the lowest frequencies above 0, in the unit of `scale`
    # Relative, of the larger of the mesh's error and the rounding of the references
    tolerance: float
    scale: float = 1.0  # unit of the references over Hz, such as 1 / (2π) for angular frequencies
    rigid: int = 0  # modes at 0 Hz


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


REFERENCE_PANELS = {
    "sandwich": ReferencePanel(
        "sandwich 1.5 m x 1 m, orthotropic core, hard simple support",
        "Navier series of the sandwich plate with rotary inertia",
        _sandwich,
        "Reissner-Mindlin P3/P2 triangles",
        (131.395, 250.475, 389.143, 444.475, 501.871, 685.934),
        2e-4,
    ),
    "nafems_13": ReferencePanel(
        "thin square, NAFEMS forced vibration test 13",
        "NAFEMS R0016, Selected Benchmarks for Forced Vibration (2.377 ... Hz)",
        _thin_nafems,
        "Bogner-Fox-Schmit quadrilaterals",
        (2.377, 5.942, 5.942, 9.507, 11.884, 11.884, 15.449),
        5e-4,
    ),
    "nafems_21": ReferencePanel(
        "thick square, NAFEMS forced vibration test 21",
        "NAFEMS R0016, Selected Benchmarks for Forced Vibration (45.897 ... Hz)",
        _thick_nafems,
        "Reissner-Mindlin P4/P3 triangles",
        (45.897, 109.44, 109.44, 167.89, 204.51, 204.51, 256.50, 256.50),
        5e-4,
    ),
    "clamped_square": ReferencePanel(
        "thin clamped square",
        "Leissa, Vibration of Plates, NASA SP-160, table 4.28: 35.9855 ...",
        lambda path: _unit_plate(path, rectangle(1, 1), 0.25, "clamped"),
        "Argyris triangles",
        (35.9855, 73.394, 73.394, 108.22),
        2e-4,
        1 / (2 * np.pi),
    ),
    "free_square": ReferencePanel(
        "thin free square, nu = 0.3",
        "Leissa, J. Sound Vib. 31 (1973) 257, and later Ritz values: 13.468, 19.596, 24.270",
        lambda path: _unit_plate(path, rectangle(1, 1), 0.25, "free"),
        "Argyris triangles",
        (13.468, 19.596, 24.270, 34.801, 34.801),
        2e-4,
        1 / (2 * np.pi),
        3,
    ),
    "supported_disc": ReferencePanel(
        "thin simply supported disc, nu = 0.3",
        "Leissa, NASA SP-160, table 2.2: 4.935 ...",
        lambda path: _unit_plate(path, Circle((0.0, 0.0), 1.0), 0.4, "simply_supported"),
        "Argyris triangles",
        (4.9351, 13.8982, 13.8982, 25.6133),
        1e-3,  # the disc is drawn by 48 straight pieces
        1 / (2 * np.pi),
    ),
    "clamped_disc": ReferencePanel(
        "thin clamped disc",
        "Leissa, NASA SP-160, table 2.1: 10.2158 ...",
        lambda path: _unit_plate(path, Circle((0.0, 0.0), 1.0), 0.4, "clamped"),
        "Argyris triangles",
        (10.2158, 21.261, 21.261, 34.877),
        2.5e-3,  # the polygon of 48 pieces lies within the disc
        1 / (2 * np.pi),
    ),
}


def frequency_rows(case: ReferencePanel, folder: Path) -> list[Row]:
    """Return the lowest frequencies of a panel with the known ones."""
    plate = case.plate(folder / "verification.msh")
    reference = case.scale * np.array(case.reference)
    frequency, _ = normal_modes(plate, 1.02 * float(reference[-1]))
    rigid = np.sum(frequency == 0)
    method = f"{case.element}, {plate.stiffness.shape[0]} coordinates"
    elastic = Comparison(case.name, "Hz", case.tolerance, method, case.source)
    statics = Comparison(case.name, "1", 0.0, case.element, "statics")
    pairs = enumerate(zip(frequency[rigid:], reference, strict=False), 1)
    return [
        *(elastic.row(f"frequency of mode {mode}", *pair, mode) for mode, pair in pairs),
        statics.row("number of rigid-body modes", rigid, case.rigid),
    ]


TAPE = Material(280e9, 6.5e9, 4.5e9, 0.3, 1600.0)
CORNERS = np.array([(0.0, 0.0), (0.9, 0.1), (0.8, 0.7), (0.1, 0.6)])
TURNS = {"turned by 37°": np.radians(37.0), "turned by 90°": np.pi / 2}


def _orthotropic_frequencies(mesh: PanelMesh, turn: float) -> Array:
    """Frequencies of a layup without symmetry, clamped on one edge, all turned about the origin."""
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    face = tuple(Ply(TAPE, 0.15e-3, np.radians(angle) + turn) for angle in (20.0, 75.0))
    section = SandwichSection(face, face, Core(310e6, 138e6, 50.0, 20e-3, np.radians(25.0) + turn))
    (x0, y0), (x1, y1) = (CORNERS[1:3] @ matrix.T).tolist()
    supports = Supports("simply_supported", edges=[EdgeSupport((x0, y0), (x1, y1), "clamped")])
    turned = replace(mesh, vertices=mesh.vertices @ matrix.T)
    return normal_modes(assemble_shear_plate(turned, section, supports), 2000.0)[0]


def turned_rows(folder: Path) -> list[Row]:
    """Return an orthotropic panel turned with its layup and ribbon beside the unturned one."""
    outline = Polygon(tuple((float(x), float(y)) for x, y in CORNERS))
    mesh = mesh_triangles(folder / "panel.msh", outline, 0.08, {}, {})
    reference = _orthotropic_frequencies(mesh, 0.0)
    comparison = Comparison(
        "Orthotropic sandwich, layup and ribbon turned with the panel", "Hz", 1e-8,
        f"{len(mesh.cells)} triangles", "the same elements turned; tolerance: rounding",
    )  # fmt: skip
    return [
        comparison.row(f"{name}: frequency {mode}", computed, expected)
        for name, turn in TURNS.items()
        for mode, (computed, expected) in enumerate(
            zip(_orthotropic_frequencies(mesh, turn), reference, strict=True), 1
        )
    ]


# Each computes in a folder and returns its rows.
CASES = {
    **{key: partial(frequency_rows, case) for key, case in REFERENCE_PANELS.items()},
    "turned": turned_rows,
}
