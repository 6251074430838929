"""Truths of the assembled thin plate, against polynomials, sines and membranes."""

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from skfem import CellBasis, ElementQuad1, ElementQuadBFS, ElementTriP1, MeshQuad, MeshTri

from pidpanel.geometry.polygon import Circle, Polygon, Rectangle
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.plate import corner_basis, vertex_values
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate, bending_form
from pidpanel.panel.triangles import mesh_triangles

A, B = 1.5, 1.0
OUTLINE = Polygon(((0.0, 0.0), (A, 0.0), (A, B), (0.0, B)))
# elongated and off the middle, so that x and y cannot be taken for one another
PATCH = Rectangle((0.4, 0.6), (0.4, 0.2))
SECTION = ThinSection(bending_stiffness=3273.07, mass_per_area=4.0, poissons_ratio=0.25)


@pytest.fixture(scope="module", params=["quadrilaterals", "triangles"])
def coarse(request, tmp_path_factory):
    """Coarse mesh of the paper's rectangle with one patch, and its plate."""
    path = tmp_path_factory.mktemp("coarse") / "m.msh"
    if request.param == "quadrilaterals":
        mesh = mesh_quadrilaterals(path, (A, B), (15, 10), {"P": PATCH}, {})
    else:
        mesh = mesh_triangles(path, OUTLINE, 0.3, {"P": PATCH}, {})
    return mesh, assemble_thin_plate(mesh, SECTION)


def bubble(x, y):
    """A deflection x (a - x) y (b - y), zero on the edges, in the span of either element."""
    return x * (A - x) * y * (B - y)


def coordinates_of(plate, w):
    """Free coordinates u of a deflection w(x, y) that the element can represent.

    Least squares at the quadrature points, refined once.
    """
    N = plate.at_quadrature
    target = w(*plate.quadrature_position.T)
    normal = spla.splu((N.T @ N).tocsc())
    u = normal.solve(N.T @ target)
    u += normal.solve(N.T @ (target - N @ u))
    np.testing.assert_allclose(N @ u, target, atol=1e-11)
    return u


def polynomial_integral(coefficients, lower, upper):
    """Exact integral of a polynomial in one variable."""
    primitive = np.polynomial.Polynomial(coefficients).integ()
    return primitive(upper) - primitive(lower)


@pytest.mark.parametrize(
    ("name", "curvatures", "energy"),
    [
        ("cylinder x^2 / 2", (1, 0, 0), 1.0),
        ("bowl (x^2 + y^2) / 2", (1, 0, 1), 2 + 2 * SECTION.poissons_ratio),
        ("saddle (x^2 - y^2) / 2", (1, 0, -1), 2 - 2 * SECTION.poissons_ratio),
        ("twist x y", (0, 1, 0), 2 * (1 - SECTION.poissons_ratio)),
    ],
)
def test_bending_energy_of_a_free_plate_is_that_of_its_curvatures(name, curvatures, energy):
    """Twice the energy over D, per area, of w_xx, w_xy, w_yy, on an unsupported unit square.

    Supported along straight edges, a plate cannot tell nu: the test below.
    """
    basis = CellBasis(MeshQuad(), ElementQuadBFS())
    x, y = basis.mesh.p
    xx, xy, yy = curvatures
    u = np.zeros(basis.N)
    u[basis.nodal_dofs] = [
        xx * x**2 / 2 + xy * x * y + yy * y**2 / 2,
        xx * x + xy * y,
        xy * x + yy * y,
        xy + 0 * x,
    ]
    K = bending_form.assemble(basis, bending=SECTION.bending)
    assert u @ K @ u == pytest.approx(SECTION.bending_stiffness * energy, rel=1e-12), name


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.5])
def test_poissons_ratio_drops_out_between_straight_simple_supports(tmp_path, nu):
    section = ThinSection(SECTION.bending_stiffness, SECTION.mass_per_area, nu)
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (3, 2), {}, {})
    plate = assemble_thin_plate(mesh, section)
    u = coordinates_of(plate, bubble)
    X2 = polynomial_integral([0, 0, A**2, -2 * A, 1], 0, A)
    Y2 = polynomial_integral([0, 0, B**2, -2 * B, 1], 0, B)
    XXpp = polynomial_integral([0, -2 * A, 2], 0, A)
    YYpp = polynomial_integral([0, -2 * B, 2], 0, B)
    laplacian_squared = 4 * A * Y2 + 4 * B * X2 + 2 * XXpp * YYpp
    energy = SECTION.bending_stiffness * laplacian_squared
    assert u @ plate.stiffness @ u == pytest.approx(energy, rel=1e-8)


def test_mass_and_patch_overlap_of_a_polynomial_are_its_integrals(coarse):
    _, plate = coarse
    u = coordinates_of(plate, bubble)
    square_x, square_y = [0, 0, A**2, -2 * A, 1], [0, 0, B**2, -2 * B, 1]
    whole = polynomial_integral(square_x, 0, A) * polynomial_integral(square_y, 0, B)
    patch = polynomial_integral(square_x, 0.2, 0.6) * polynomial_integral(square_y, 0.5, 0.7)
    # 1e-10: u is found to 1e-11
    assert u @ plate.mass @ u == pytest.approx(SECTION.mass_per_area * whole, rel=1e-10)
    assert u @ plate.patch_overlap["P"] @ u == pytest.approx(patch, rel=1e-10)


def test_consistent_load_of_a_pressure_is_its_work_on_the_deflection(coarse):
    _, plate = coarse
    u = coordinates_of(plate, bubble)
    x = plate.quadrature_position[:, 0]
    assert plate.quadrature_weight.sum() == pytest.approx(A * B, rel=1e-12)
    work = u @ plate.at_quadrature.T @ (plate.quadrature_weight * x)
    exact = polynomial_integral([0, 0, A, -1], 0, A) * polynomial_integral([0, B, -1], 0, B)
    # x times the bubble has degree 5, for which the load quadrature is exact
    assert work == pytest.approx(exact, rel=1e-10)


def test_interpolation_returns_the_deflection_anywhere(coarse):
    mesh, plate = coarse
    u = coordinates_of(plate, bubble)
    position = np.random.default_rng(1).uniform((0, 0), (A, B), (50, 2))
    np.testing.assert_allclose(plate.interpolate(position) @ u, bubble(*position.T), atol=1e-10)
    np.testing.assert_allclose(plate.at_vertices @ u, bubble(*mesh.vertices.T), atol=1e-10)
    with pytest.raises(ValueError):
        plate.interpolate(np.array([[1.6, 0.5]]))


def test_no_coordinate_moves_the_supported_edge(coarse):
    """The derivatives along the edge must vanish too, or w would leave 0 between vertices."""
    _, plate = coarse
    s = np.linspace(0, 1, 101)
    edges = [(A * s, 0 * s), (A * s, 0 * s + B), (0 * s, B * s), (0 * s + A, B * s)]
    for x, y in edges:
        on_edge = plate.interpolate(np.column_stack([x, y]))
        # rounding; a free u_x or u_xx would give about h / 8 or h^2 / 60
        assert abs(on_edge).max() < 1e-12


def rectangle_of_split_quads(nx, ny):
    """A regular mesh of triangles, independent of gmsh, so that refinements are nested."""
    x, y = np.meshgrid(np.linspace(0, A, nx + 1), np.linspace(0, B, ny + 1))
    lower_left = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    right, up = lower_left + 1, lower_left + nx + 1
    cells = np.vstack(
        [np.column_stack([lower_left, right, up + 1]), np.column_stack([lower_left, up + 1, up])]
    )
    return PanelMesh(np.column_stack([x.ravel(), y.ravel()]), cells, "triangles", {}, {})


def first_six_errors(mesh):
    """Relative errors of the frequencies of (1,1) (2,1) (1,2) (3,1) (2,2) (3,2)."""
    # (4, 1) lies at 364.5 Hz
    frequency, _ = normal_modes(assemble_thin_plate(mesh, SECTION), 364.0)
    m, n = np.array([(1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (3, 2)]).T
    unit = np.pi / 2 * np.sqrt(SECTION.bending_stiffness / SECTION.mass_per_area)
    return frequency / (unit * ((m / A) ** 2 + (n / B) ** 2)) - 1


@pytest.mark.slow
def test_bogner_fox_schmit_converges_to_navier_from_above_at_order_4(tmp_path):
    errors = np.array(
        [
            first_six_errors(mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (nx, ny), {}, {}))
            for nx, ny in [(6, 4), (12, 8), (24, 16)]
        ]
    )
    # conforming and exactly integrated: Rayleigh's quotient is an upper bound
    assert errors.min() > 0
    orders = np.log2(errors[:-1] / errors[1:])
    # cubics: 2 (3 + 1 - 2) = 4; the coarsest mesh has two elements to a half wave of (3, 1)
    assert 3.8 < orders.min() and orders.max() < 4.2
    # (kh)^4 / 1440 to leading order, for (3, 1) with pi / 8 per element: 0.00166 %
    assert errors[-1].max() < 1.7e-5


@pytest.mark.slow
def test_argyris_converges_to_navier_from_above_at_order_8():
    errors = np.array([first_six_errors(rectangle_of_split_quads(n, n)) for n in (4, 6, 9)])
    assert errors.min() > 0
    orders = np.log(errors[:-1] / errors[1:]) / np.log(1.5)
    # quintics: 2 (5 + 1 - 2) = 8, reached as the mesh gets fine enough
    assert 7.0 < orders.min() and orders.max() < 8.6
    # (3, 2), one and a half cells along x and two along y to a half wave: 2.2e-6
    assert errors[-1].max() < 3e-6


@pytest.mark.slow
def test_oblique_supports_reproduce_the_right_isosceles_triangle(tmp_path):
    """Its modes are the antisymmetric ones of the square, sin m sin n - sin n sin m."""
    mesh = mesh_triangles(tmp_path / "t.msh", Polygon(((0, 0), (1, 0), (0, 1))), 0.25, {}, {})
    frequency, _ = normal_modes(assemble_thin_plate(mesh, SECTION), 700.0)
    unit = np.pi / 2 * np.sqrt(SECTION.bending_stiffness / SECTION.mass_per_area)
    expected = unit * np.array([5, 10, 13])  # 1 + 4, 1 + 9, 4 + 9
    # 1.3e-4 at (2, 3): barely one cell to a half wave; with the derivatives of the oblique edge
    # left free or held too fast it is 1 % and more
    np.testing.assert_allclose(frequency[:3], expected, rtol=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("shift", [0.0, 10.0])
def test_the_plate_is_the_same_wherever_it_lies(shift):
    mesh = rectangle_of_split_quads(6, 4)
    moved = PanelMesh(mesh.vertices + shift, mesh.cells, mesh.cell_kind, {}, {})
    here, there = (assemble_thin_plate(each, SECTION) for each in (mesh, moved))
    scale = abs(here.stiffness).max()
    # 10 m is 40 cells: coordinates are rounded to 1e-15 of a cell times 40
    assert abs(here.stiffness - there.stiffness).max() < 1e-11 * scale


def test_a_clamped_square_of_quadrilaterals_has_its_known_frequency(tmp_path):
    # ω a² √(m″/D) = 35.985 (Leissa 1973); six by six elements of order four are 1e-3 above at most
    mesh = mesh_quadrilaterals(tmp_path / "q.msh", (1.0, 1.0), (6, 6), {}, {})
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0), Supports("clamped"))
    frequency, _ = normal_modes(plate, 200.0)
    exact = 35.985 / (2 * np.pi) * np.sqrt(3273.07 / 4.0)
    assert exact * (1 - 1e-4) < frequency[0] < exact * (1 + 1e-3)


def test_on_a_curved_simple_support_the_deflection_turns_with_the_edge(tmp_path):
    # w = 0 along a circle of radius R: d²w/ds² = w_tt - w_n/R = 0, for every free coordinate
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


def test_a_thin_plate_has_three_curvatures_and_two_shears_that_vanish(tmp_path):
    square = mesh_quadrilaterals(tmp_path / "q.msh", (1.0, 1.0), (3, 2), {}, {})
    plate = assemble_thin_plate(square, ThinSection(3273.07, 4.0))
    assert len(plate.curvature_at_vertices) == 3
    assert [abs(shear).sum() for shear in plate.shear_at_vertices] == [0, 0]


@pytest.mark.parametrize(
    ("mesh", "element"), [(MeshTri(), ElementTriP1()), (MeshQuad(), ElementQuad1())]
)
def test_a_value_at_a_vertex_is_the_mean_of_those_of_its_cells(mesh, element):
    # fewer cells than corners
    basis = corner_basis(mesh, element)
    corners = np.asarray(basis.global_coordinates())
    np.testing.assert_allclose(corners, mesh.p[:, mesh.t.T])
    free = sp.identity(mesh.p.shape[1], format="csr")
    values = vertex_values(basis, np.asarray, free)
    np.testing.assert_allclose(values.toarray(), np.eye(mesh.p.shape[1]), atol=1e-15)
    of_cells = np.arange(1.0, 1 + mesh.t.shape[1])[:, None]
    scaled = vertex_values(basis, lambda function: np.asarray(function) * of_cells, free)
    expected = [np.mean(1 + np.flatnonzero((mesh.t == v).any(axis=0))) for v in range(4)]
    np.testing.assert_allclose(scaled.sum(axis=1), expected)
