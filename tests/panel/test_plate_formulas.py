"""Quadrature of the load and means over the cells at a vertex, on meshes counted by hand."""

import numpy as np
import pytest
import scipy.linalg as la
from skfem import ElementQuad1, ElementTriP1, MeshQuad, MeshTri

from pidpanel.geometry.polygon import Circle, Rectangle
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.plate import at_quadrature, corner_basis, corner_mean
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import PointSupport, Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles


def test_the_load_has_nine_points_on_a_quadrilateral_and_seven_on_a_triangle(tmp_path):
    # red: LOAD_ORDER = 5 → 6
    section = ThinSection(3273.07, 4.0)
    square = mesh_quadrilaterals(tmp_path / "q.msh", (1.0, 1.0), (3, 2), {}, {})
    plate = assemble_thin_plate(square, section)
    assert len(plate.quadrature_weight) == 9 * 6
    triangles = mesh_triangles(tmp_path / "t.msh", Rectangle((0, 0), (1, 1)), 0.5, {}, {})
    found = assemble_thin_plate(triangles, section).quadrature_weight
    assert len(found) == 7 * len(triangles.cells)


def test_a_hinge_takes_one_coordinate_and_a_hold_down_three(tmp_path):
    # w, and with it both slopes; red: 1 if point.kind == "hinge" else 3 → 4
    points = {"7": (0.5, 0.5)}
    mesh = mesh_triangles(tmp_path / "t.msh", Rectangle((0.5, 0.5), (1, 1)), 0.4, {}, points)
    count = {}
    for kind in ("hinge", "hold_down", None):
        held = {"H": PointSupport((0.5, 0.5), kind)} if kind else {}
        plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0), Supports("free", points=held))
        count[kind] = plate.stiffness.shape[0]
    assert count[None] - count["hinge"] == 1
    assert count[None] - count["hold_down"] == 3


def test_a_clamped_square_of_quadrilaterals_has_its_known_frequency(tmp_path):
    # ω a² √(m″/D) = 35.985 (Leissa 1973); six by six elements of order four are 1e-3 above at most
    # red: clamped and basis.facet_dofs.size → or
    mesh = mesh_quadrilaterals(tmp_path / "q.msh", (1.0, 1.0), (6, 6), {}, {})
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0), Supports("clamped"))
    frequency, _ = normal_modes(plate, 200.0)
    exact = 35.985 / (2 * np.pi) * np.sqrt(3273.07 / 4.0)
    assert exact * (1 - 1e-4) < frequency[0] < exact * (1 + 1e-3)


def test_on_a_curved_simple_support_the_deflection_turns_with_the_edge(tmp_path):
    # w = 0 along a circle of radius R: d²w/ds² = w_tt - w_n/R = 0, for every free coordinate
    # red: / spacing ** order → * spacing ** order in `_held` of `thin`; h * turn → turn / h
    radius, pieces = 0.5, 24
    mesh = mesh_triangles(tmp_path / "t.msh", Circle((0.0, 0.0), radius, pieces), 0.3, {}, {})
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    rim = np.flatnonzero(np.linalg.norm(mesh.vertices, axis=1) > 0.999 * radius)
    assert len(rim) == pieces
    outward = mesh.vertices[rim] / radius
    tx, ty = -outward[:, 1:], outward[:, :1]
    xx, yy, twist = (-kappa[rim].toarray() for kappa in plate.curvature_at_vertices)
    along = tx**2 * xx + ty**2 * yy + tx * ty * twist
    step = 1e-5
    once, twice = (
        plate.interpolate((1 - k * step / radius) * mesh.vertices[rim]).toarray() for k in (1, 2)
    )
    slope = -(4 * once - twice) / (2 * step)
    scale = np.abs(along).max()
    assert scale > 1e-2 * np.abs(xx).max()
    # differences over 1e-5 m of shapes that vary over 0.1 m
    np.testing.assert_allclose(along, slope / radius, atol=1e-5 * scale)


@pytest.mark.parametrize("kind", ["clamped", "simply_supported"])
def test_a_turned_plate_has_the_frequencies_of_one_that_is_not(kind):
    # red: 1 more in any row of `_forbidden` of `thin` that mixes w_x, w_y with w_xx, w_xy, w_yy
    x, y = np.meshgrid([0, 0.5, 1.1, 1.5], [0, 0.6, 1.0])
    corner = np.array([0, 1, 2, 4, 5, 6])
    cells = np.vstack(
        [np.column_stack([corner, corner + 1, corner + 5]),
         np.column_stack([corner, corner + 5, corner + 4])]
    )  # fmt: skip
    vertices = np.column_stack([x.ravel(), y.ravel()])
    found = []
    for angle in np.radians([0, 31]):
        c, s = np.cos(angle), np.sin(angle)
        turned = vertices @ np.array([[c, s], [-s, c]])
        mesh = PanelMesh(turned, cells, "triangles", {}, {})
        plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0), Supports(kind))
        matrices = plate.stiffness.toarray(), plate.mass.toarray()
        found.append(la.eigh(*matrices, eigvals_only=True)[:8])
    # coordinates of three units condition the matrices to 1e-6 or so
    np.testing.assert_allclose(found[1], found[0], rtol=1e-7)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("lean", [0.1, -0.1])
def test_a_cell_that_leans_is_named_whichever_way_and_at_every_scale(scale, lean):
    # red: np.abs left out in `_check_rectangles`; argmax → argmin; / extent → * extent
    corners = [(0, 0), (1, 0), (0, 1), (1, 1), (lean, 2), (1 + lean, 2)]
    cells = np.array([[0, 1, 3, 2], [2, 3, 5, 4]])
    mesh = PanelMesh(scale * np.array(corners, dtype=float), cells, "quadrilaterals", {}, {})
    with pytest.raises(ValueError, match="cell 1 with corners"):
        assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    slight = mesh.vertices * 1.0
    slight[4:, 0] -= scale * (lean - 1e-11)  # as rounding in a file might make it
    mesh = PanelMesh(slight, cells, "quadrilaterals", {}, {})
    assemble_thin_plate(mesh, ThinSection(1.0, 1.0), Supports("free"))


def test_a_thin_plate_has_three_curvatures_and_two_shears_that_vanish(tmp_path):
    # red: * 2 → * 3
    square = mesh_quadrilaterals(tmp_path / "q.msh", (1.0, 1.0), (3, 2), {}, {})
    plate = assemble_thin_plate(square, ThinSection(3273.07, 4.0))
    assert len(plate.curvature_at_vertices) == 3
    assert [abs(shear).sum() for shear in plate.shear_at_vertices] == [0, 0]


@pytest.mark.parametrize(
    ("mesh", "element"), [(MeshTri(), ElementTriP1()), (MeshQuad(), ElementQuad1())]
)
def test_a_value_at_a_vertex_is_the_mean_of_those_of_its_cells(mesh, element):
    # fewer cells than corners; red: mesh.t.shape[0] → mesh.t.shape[1]; 1 / np.bincount → 1 *, 2 /
    basis = corner_basis(mesh, element)
    corners = np.asarray(basis.global_coordinates())
    np.testing.assert_allclose(corners, mesh.p[:, mesh.t.T])
    mean = corner_mean(mesh)
    values = mean @ at_quadrature(basis, [function[0] for function in basis.basis])
    np.testing.assert_allclose(values.toarray(), np.eye(mesh.p.shape[1]), atol=1e-15)
    of_cells = np.repeat(np.arange(1.0, 1 + mesh.t.shape[1]), mesh.t.shape[0])
    expected = [np.mean(1 + np.flatnonzero((mesh.t == v).any(axis=0))) for v in range(4)]
    np.testing.assert_allclose(mean @ of_cells, expected)
