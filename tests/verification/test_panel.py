"""Natural frequencies and membrane stiffness of panels against closed forms and published values."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from pidpanel.geometry.polygon import Circle, Polygon
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection, ThinSection
from pidpanel.panel.stretching import in_plane_basis, membrane_tensor
from pidpanel.panel.supports import Block, EdgeSupport, Supports, free_coordinates
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles

pytestmark = [pytest.mark.verification, pytest.mark.slow]

UNIT_PLATE = ThinSection(bending_stiffness=1.0, mass_per_area=1.0, poissons_ratio=0.3)


def rectangle(a, b):
    return Polygon(((0.0, 0.0), (a, 0.0), (a, b), (0.0, b)))


SQUARE, DISC = rectangle(1, 1), Circle((0.0, 0.0), 1.0)


def sandwich(path):
    face = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
    section = SandwichSection((face,), (face,), Core(186e6, 90e6, 32.0, 24.4e-3))
    return assemble_shear_plate(mesh_triangles(path, rectangle(1.5, 1.0), 0.1, {}, {}), section)


def thin_nafems(path):
    section = ThinSection(200e9 * 0.05**3 / 12 / (1 - 0.3**2), 8000 * 0.05, 0.3, 0.05)
    return assemble_thin_plate(mesh_quadrilaterals(path, (10.0, 10.0), (12, 12), {}, {}), section)


def thick_nafems(path):
    section = SolidSection(200e9, 0.3, 8000.0, 1.0, np.pi**2 / 12)
    return assemble_shear_plate(mesh_triangles(path, rectangle(10, 10), 1.0, {}, {}), section)


def unit_plate(path, outline, size, support):
    mesh = mesh_triangles(path, outline, size, {}, {})
    return assemble_thin_plate(mesh, UNIT_PLATE, Supports(support))


def angular(*values):
    """In Hz, from rad/s."""
    return 1 / (2 * np.pi) * np.array(values)


# Assembly; title; source; element; tolerance: the larger of the mesh's error and the rounding of the
# references (the discs are drawn by 48 straight pieces); lowest frequencies above 0 [Hz].
PANELS = {
    "sandwich": (
        sandwich, "sandwich 1.5 m x 1 m, orthotropic core, hard simple support",
        "Navier series of the sandwich plate with rotary inertia",
        "Reissner-Mindlin P3/P2 triangles", 0.0002,
        [131.395, 250.475, 389.143, 444.475, 501.871, 685.934],
    ),
    "thin square": (
        thin_nafems, "thin square, NAFEMS forced vibration test 13",
        "NAFEMS R0016, Selected Benchmarks for Forced Vibration (2.377 ... Hz)",
        "Bogner-Fox-Schmit quadrilaterals", 0.0005,
        [2.377, 5.942, 5.942, 9.507, 11.884, 11.884, 15.449],
    ),
    "thick square": (
        thick_nafems, "thick square, NAFEMS forced vibration test 21",
        "NAFEMS R0016, Selected Benchmarks for Forced Vibration (45.897 ... Hz)",
        "Reissner-Mindlin P4/P3 triangles", 0.0005,
        [45.897, 109.44, 109.44, 167.89, 204.51, 204.51, 256.50, 256.50],
    ),
    "clamped square": (
        partial(unit_plate, outline=SQUARE, size=0.25, support="clamped"), "thin clamped square",
        "Leissa, Vibration of Plates, NASA SP-160, table 4.28: 35.9855 ...",
        "Argyris triangles", 0.0002, angular(35.9855, 73.394, 73.394, 108.22),
    ),
    "free square": (
        partial(unit_plate, outline=SQUARE, size=0.25, support="free"),
        "thin free square, nu = 0.3",
        "Leissa, J. Sound Vib. 31 (1973) 257, and later Ritz values: 13.468, 19.596, 24.270",
        "Argyris triangles", 0.0002, angular(13.468, 19.596, 24.270, 34.801, 34.801),
    ),
    "supported disc": (
        partial(unit_plate, outline=DISC, size=0.4, support="simply_supported"),
        "thin simply supported disc, nu = 0.3", "Leissa, NASA SP-160, table 2.2: 4.935 ...",
        "Argyris triangles", 0.001, angular(4.9351, 13.8982, 13.8982, 25.6133),
    ),
    "clamped disc": (
        partial(unit_plate, outline=DISC, size=0.4, support="clamped"), "thin clamped disc",
        "Leissa, NASA SP-160, table 2.1: 10.2158 ...",
        "Argyris triangles", 0.0025, angular(10.2158, 21.261, 21.261, 34.877),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PANELS)
def test_frequencies_are_the_published_ones(record, tmp_path, name):
    assemble, case, source, element, tolerance, reference = PANELS[name]
    plate = assemble(tmp_path / "panel.msh")
    frequency, _ = normal_modes(plate, 1.02 * float(reference[-1]))
    rigid = np.sum(frequency == 0)
    method = f"{element}, {plate.stiffness.shape[0]} coordinates"
    for mode, pair in enumerate(zip(frequency[rigid:], reference, strict=False), 1):
        record(
            f"frequency of mode {mode}", *pair, unit="Hz", tolerance=tolerance, case=case,
            method=method, source=source,
        )  # fmt: skip
    record(
        "number of rigid-body modes", rigid, 3 if name == "free square" else 0, tolerance=0.0,
        case=case, method=element, source="statics",
    )  # fmt: skip


TAPE = Material(280e9, 6.5e9, 4.5e9, 0.3, 1600.0)
CORNERS = np.array([(0.0, 0.0), (0.9, 0.1), (0.8, 0.7), (0.1, 0.6)])


def orthotropic_frequencies(mesh, turn):
    """Of an unsymmetric layup, clamped on one edge, rotated about the origin."""
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    face = tuple(Ply(TAPE, 0.15e-3, np.radians(angle) + turn) for angle in (20.0, 75.0))
    section = SandwichSection(face, face, Core(310e6, 138e6, 50.0, 20e-3, np.radians(25.0) + turn))
    edge = EdgeSupport(*(tuple(end) for end in (CORNERS[1:3] @ matrix.T).tolist()), "clamped")
    turned = replace(mesh, vertices=mesh.vertices @ matrix.T)
    plate = assemble_shear_plate(turned, section, Supports("simply_supported", edges=[edge]))
    return normal_modes(plate, 2000.0)[0]


def test_a_panel_turned_with_its_layup_and_ribbon_has_the_same_frequencies(record, tmp_path):
    outline = Polygon(tuple((float(x), float(y)) for x, y in CORNERS))
    mesh = mesh_triangles(tmp_path / "panel.msh", outline, 0.08, {}, {})
    reference = orthotropic_frequencies(mesh, 0.0)
    for degrees in (37, 90):
        frequency = orthotropic_frequencies(mesh, np.radians(degrees))
        for mode, pair in enumerate(zip(frequency, reference, strict=True), 1):
            record(
                f"turned by {degrees}°: frequency {mode}", *pair, unit="Hz", tolerance=1e-8,
                case="Orthotropic sandwich, layup and ribbon turned with the panel",
                method=f"{len(mesh.cells)} triangles",
                source="the same elements turned; tolerance: rounding",
            )  # fmt: skip


@pytest.mark.parametrize("size", [(1.0, 1.0), (1.5, 1.0), (2.0, 1.0)])
def test_rectangles_stretch_as_the_closed_forms_of_their_edges(record, tmp_path, size):
    """Cubic stiffness of w = q sin(πx/a) sin(πy/b).

    The edges cannot move along their normal in the plane (Chu and Herrmann), or stay straight
    without a force on the average (Levy). Tangential motion is free.
    """
    nu, (a, b) = UNIT_PLATE.poissons_ratio, size
    A = replace(UNIT_PLATE, extensional_stiffness=1.0).extensional
    basis = in_plane_basis(mesh_triangles(tmp_path / "a.msh", rectangle(a, b), 0.05, {}, {}))
    x, y = np.pi * basis.global_coordinates().reshape(2, -1) / np.array([[a], [b]])
    slopes = np.pi * np.stack([np.cos(x) * np.sin(y) / a, np.sin(x) * np.cos(y) / b])
    straight = (1 - nu**2) * np.pi**4 * a * b / 64 * (a**-4 + b**-4)
    stretch = np.pi**4 * a * b / 32 * (a**-4 + b**-4 + 2 * nu / (a * b) ** 2)
    for edges, expected in (("straight", straight), ("immovable", straight + stretch)):
        free = edges_along_normal(basis, size, is_straight=edges == "straight")
        tensor = membrane_tensor(basis, A, slopes[:, :, None], free)
        record(
            f"{a:g} × {b:g} m, {edges} edges: cubic stiffness", 2 * tensor.item(), expected,
            unit="1/m2",
            tolerance=1e-4,  # the error falls with the fourth power of the size of the triangles
            case="Membrane stiffness of rectangles that deflect as half a wave",
            method="quadratic triangles of 0.05 m",
            source="π⁴Ch (1/a⁴ + 1/b⁴) of straight edges, Levy, NACA Report 737 (1942); of immovable "
            "ones with the mean strain too, Chu & Herrmann, J. Appl. Mech. 23, 532 (1956)",
        )  # fmt: skip


def edges_along_normal(basis, size, *, is_straight):
    """Free in-plane coordinates of a rectangle from the origin.

    Edges do not move along their normal; or the two far ones, if straight, by one amount each.
    """
    component = np.zeros(basis.N, dtype=np.int64)
    for dofs in (basis.nodal_dofs, basis.facet_dofs, basis.interior_dofs):
        component[dofs[1::2].ravel()] = 1
    blocks, edges = [], basis.get_dofs().flatten()
    for axis, length in enumerate(size):
        normal = edges[component[edges] == axis]
        far, near = (normal[np.isclose(basis.doflocs[axis][normal], at)] for at in (length, 0.0))
        blocks += [Block(f"edge {axis}", np.array([dof]), np.ones((1, 0))) for dof in near]
        blocks.append(Block(f"far edge {axis}", far, np.ones((len(far), int(is_straight)))))
    return free_coordinates(basis.N, blocks)
