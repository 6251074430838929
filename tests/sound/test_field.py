"""Modal force of sound fields, held to closed forms and to independent quadratures.

Shapes are products of sines on the paper's 1.5 m × 1.0 m panel.
"""

import numpy as np
import pytest

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound.field import (
    FieldError,
    diffuse_modal_force,
    diffuse_modal_force_on_grid,
    lumped_area,
    plane_wave_modal_force,
    tabulate_diffuse,
    tabulate_plane_waves,
    uncorrelated_modal_force,
    uniform_modal_force,
    wavenumber,
)
from pidpanel.sound.plane_waves import PlaneWaves
from tests.sound.panels import SIDES, sine_panel, sines

SPEED = 343.0
MODES = [(1, 1), (2, 1), (3, 1), (3, 3), (9, 1)]


def natural_frequency(m, n):
    return 44.9332 * (m**2 / SIDES[0] ** 2 + n**2 / SIDES[1] ** 2)


@pytest.fixture(scope="module")
def panel():
    """The load quadrature of the paper's mesh: order 5 on 5 cm."""
    return sine_panel(MODES)


@pytest.fixture(scope="module")
def table(panel):
    """G of the diffuse field up to 2 kHz."""
    return tabulate_diffuse(float(wavenumber(2000.0, SPEED)), panel)


def double_integral(k, quadrature):
    """∬ φ_i φ_j sin(kR)/(kR) dA dA′ as it stands, without plane waves."""
    apart = quadrature.position[:, None, :] - quadrature.position[None, :, :]
    coherence = np.sinc(k * np.linalg.norm(apart, axis=2) / np.pi)
    load = quadrature.weight[:, None] * quadrature.shape
    return load.T @ coherence @ load


def test_radiation_efficiency_of_a_panel_far_above_coincidence_tends_to_one():
    # (1,1) at kL = 66: the edges' share is of order 1/kL, 1.5 %
    # by reciprocity G_11 = (2π/k²) σ ∫φ_1² dA
    quadrature, k = sine_panel([(1, 1)]), float(wavenumber(2000.0, SPEED))
    square = quadrature.product_integral.item()
    sigma = k**2 * diffuse_modal_force(k, quadrature).item() / (2 * np.pi * square)
    assert sigma == pytest.approx(1.0, abs=0.015)


@pytest.mark.parametrize(("reach", "error"), [(0.5, 1e-14), (20, 1e-14), (66, 1e-9), (200, 1e-6)])
def test_plane_waves_sum_to_the_coherence_of_points_as_far_apart_as_can_be(reach, error):
    # rounding up to kL = 20; what `SPARE_NODES` leaves beyond, 2e-10 and 3e-7, falls on points that
    # lie a diameter apart
    rng = np.random.default_rng(4)
    position = np.vstack([[[0, 0], [1.5, 1.0]], rng.uniform((0, 0), SIDES, (6, 2))])
    points = PanelQuadrature(position, np.ones(8), np.eye(8))
    k = reach / points.diameter
    np.testing.assert_allclose(
        diffuse_modal_force(k, points), double_integral(k, points), rtol=0, atol=error
    )


def test_load_quadrature_of_order_five_is_enough_at_2_khz(panel):
    # against 40 points to a side, converged: 1e-5 of the largest is 0.00004 dB there
    k = float(wavenumber(2000.0, SPEED))
    fine = diffuse_modal_force(k, sine_panel(MODES, (1, 1), 48))
    np.testing.assert_allclose(diffuse_modal_force(k, panel), fine, atol=1e-5 * fine.max())


def test_a_long_wave_pushes_like_one_uniform_pressure(panel):
    # sin(kR)/(kR) ≥ 1 − (kR)²/6, R ≤ 1.81 m: 5.5e-7 at k = 1e-3
    uniform = uniform_modal_force(panel)
    assert uniform[0, 0] == pytest.approx((1.5 * (2 / np.pi) ** 2) ** 2, rel=1e-6)
    diffuse = diffuse_modal_force(1e-3, panel)
    np.testing.assert_allclose(diffuse, uniform, atol=1e-6 * uniform.max())
    np.testing.assert_allclose(diffuse_modal_force(0.0, panel), uniform, atol=1e-12)


def test_modal_force_is_symmetric_and_positive_semidefinite(table):
    # eigenvalues of a sum of squares; rounding only
    for matrix in table.matrix(wavenumber([20.0, 150.0, 700.0, 2000.0], SPEED)):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-16)
        eigenvalue = np.linalg.eigvalsh(matrix)
        assert eigenvalue[0] >= -1e-14 * eigenvalue[-1]


def test_shapes_even_and_odd_about_the_middle_do_not_couple(panel):
    # (1,1) even and (2,1) odd in x: zero to rounding, where (1,1) and (3,1) share 1e-2 m⁴
    matrix = diffuse_modal_force(3.0, panel)
    assert abs(matrix[0, 1]) < 1e-13
    assert abs(matrix[0, 2]) > 1e-3


@pytest.mark.slow
def test_the_table_is_the_direct_sum_at_every_frequency(panel, table):
    # entire in k: 47 nodes reach rounding, 1e-13 of the largest, also between the checked points
    k_max = table.wavenumber_max
    largest = np.sqrt(np.max(np.diagonal(table.even, axis1=1, axis2=2), axis=0))
    scale = np.outer(largest, largest)
    wavenumbers = np.array([0.0, 0.02, 0.31, 0.77, 0.999, 1.0]) * k_max
    for k, tabulated in zip(wavenumbers, table.matrix(wavenumbers), strict=True):
        assert np.max(np.abs(tabulated - diffuse_modal_force(k, panel)) / scale) < 1e-13


def test_plane_waves_from_all_sides_make_the_diffuse_field(panel):
    # a plain midpoint rule in cos θ and azimuth, 24 × 24: 1e-3 of the largest at 150 Hz
    k = float(wavenumber(150.0, SPEED))
    middles = (np.arange(24) + 0.5) / 24
    angles = np.meshgrid(np.arccos(middles), 2 * np.pi * middles)
    waves = PlaneWaves(*(angle.ravel() for angle in angles), np.full(576, 1 / 576))
    total = plane_wave_modal_force([k], waves, panel)[0]
    diffuse = diffuse_modal_force(k, panel)
    np.testing.assert_allclose(total, diffuse, atol=1e-3 * diffuse.max())


def test_a_plane_wave_drives_a_sine_as_its_fourier_transform_says(panel):
    # |∫ sin(mπx/a) e^{−iκx} dx|² = (mπ/a)² · 2(1 − (−1)^m cos κa)/((mπ/a)² − κ²)²; Gauss: 1e-6;
    # (2,1) is odd about the middle, so that the sine part carries it
    k = float(wavenumber(500.0, SPEED))
    kappa, wave = k * np.sin(0.7), 2 * np.pi / SIDES[0]
    along = wave**2 * 2 * (1 - np.cos(kappa * SIDES[0])) / (wave**2 - kappa**2) ** 2
    matrix = plane_wave_modal_force([k], PlaneWaves.lone(0.7, 0.0), panel)[0]
    assert matrix[1, 1].real == pytest.approx(along * (2 / np.pi) ** 2, rel=1e-6)
    np.testing.assert_allclose(matrix, matrix.conj().T, atol=1e-16)
    assert np.linalg.matrix_rank(matrix, tol=1e-12) == 1


def test_a_plane_wave_across_the_panel_pushes_later_where_it_comes_later(panel):
    # G_ij = E[f_i f_j*]: for shapes (1,1), (2,1) and a wave along +x the phase is that of
    # b_1 b_2* with b = ∫ φ e^{−ikx}; computed here by a sum over the points as it stands
    k = float(wavenumber(200.0, SPEED))
    force = (panel.weight * np.exp(-1j * k * panel.position[:, 0])) @ panel.shape
    matrix = plane_wave_modal_force([k], PlaneWaves.lone(np.pi / 2, 0.0), panel)[0]
    np.testing.assert_allclose(matrix, np.outer(force, force.conj()), atol=1e-13)


@pytest.mark.parametrize("incidence", [0.0, 0.7, np.pi / 2])
def test_the_table_of_a_plane_wave_is_the_wave_at_every_frequency(panel, incidence):
    # Re G even and Im G odd in k, both entire: rounding between the nodes too
    k_max = float(wavenumber(2000.0, SPEED))
    table = tabulate_plane_waves(k_max, PlaneWaves.lone(incidence, 0.4), panel)
    k = np.array([0.02, 0.31, 0.77, 1.0]) * k_max
    direct = plane_wave_modal_force(k, PlaneWaves.lone(incidence, 0.4), panel)
    np.testing.assert_allclose(table.matrix(k), direct, atol=1e-11 * np.abs(table.even).max())


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_tables_are_held_to_the_direct_field_at_every_size_of_shapes(size):
    # a shape that no wave pushes, odd about the middle under normal incidence, is measured against
    # the largest
    quadrature = sine_panel([(1, 1), (2, 1), (3, 1)], (1, 1), 16)
    scaled = PanelQuadrature(quadrature.position, quadrature.weight, size * quadrature.shape)
    tabulate_plane_waves(20.0, PlaneWaves.lone(0.0, 0.0), scaled)
    tabulate_diffuse(20.0, scaled)
    with pytest.raises(FieldError):
        tabulate_diffuse(20.0, scaled, nodes_in_k=6)


def lumped_panel(elements):
    """Centres of a grid of elements, their areas, the shapes there."""
    x, y = ((np.arange(n) + 0.5) * side / n for side, n in zip(SIDES, elements, strict=True))
    position = np.stack([g.ravel() for g in np.meshgrid(x, y, indexing="ij")], axis=1)
    area = np.full(position.shape[0], SIDES[0] * SIDES[1] / position.shape[0])
    return area, sines(position, MODES)


def test_each_halving_of_the_elements_takes_6_02_db_from_the_uncorrelated_field():
    # lumped sines keep their norm on a regular grid, so G falls exactly with the element area
    coarse = uncorrelated_modal_force(*lumped_panel((30, 20)))
    fine = uncorrelated_modal_force(*lumped_panel((60, 40)))
    decibels = 10 * np.log10(np.diag(fine) / np.diag(coarse))
    np.testing.assert_allclose(decibels, -6.0206, atol=1e-4)


@pytest.mark.parametrize(("mode", "decibels"), [((1, 1), 25.6), ((3, 1), 14.6), ((9, 1), 5.4)])
def test_the_uncorrelated_field_of_the_papers_mesh_is_too_weak(panel, mode, decibels):
    # one decimal is given, so 0.05 dB is in the rounding
    i = MODES.index(mode)
    diffuse = diffuse_modal_force(float(wavenumber(natural_frequency(*mode), SPEED)), panel)
    lumped = uncorrelated_modal_force(*lumped_panel((30, 20)))
    assert 10 * np.log10(diffuse[i, i] / lumped[i, i]) == pytest.approx(decibels, abs=0.06)


def test_lumped_areas_of_vertices_sum_to_the_panel():
    # two triangles and a square
    vertices = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]]
    square = lumped_area(vertices, np.array([[0, 1, 2, 3], [1, 4, 5, 2]]))
    np.testing.assert_allclose(square, [0.25, 0.5, 0.5, 0.25, 0.25, 0.25])
    triangles = lumped_area(vertices, np.array([[0, 1, 2], [0, 2, 3]]))
    np.testing.assert_allclose(triangles, [1 / 3, 1 / 6, 1 / 3, 1 / 6, 0, 0])
    clockwise = lumped_area(vertices, np.array([[3, 2, 1, 0]]))
    np.testing.assert_allclose(clockwise, [0.25, 0.25, 0.25, 0.25, 0, 0])


def test_parities_on_a_grid_give_the_sum_over_all_waves():
    rng = np.random.default_rng(3)
    scattered = rng.uniform(size=(400, 2)) * [1.2, 0.7]
    values = rng.normal(size=(400, 5))
    k = 30.0
    panel = condensed(PanelQuadrature(scattered, np.full(400, 0.84 / 400), values), k)
    direct = diffuse_modal_force(k, panel)
    np.testing.assert_allclose(
        diffuse_modal_force_on_grid(k, panel), direct, rtol=0, atol=1e-11 * np.abs(direct).max()
    )
