"""Truths of the modes and residual vectors: Table 1, orthogonality, and a direct solve."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel import modes as modes_module
from pidpanel.panel.basis import patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.modes import count_modes_below, is_rigid, normal_modes
from pidpanel.panel.navier import mode_orders, thin_plate_frequency
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import LEAST_MODES, residual_vectors
from pidpanel.panel.thin import assemble_thin_plate
from tests.panel_basis import panel_basis

A, B = 1.5, 1.0
SECTION = ThinSection(bending_stiffness=3273.07, mass_per_area=4.0)
# Table 1 of the paper: m, n, frequency in Hz
TABLE_1 = [
    (1, 1, 64.90), (2, 1, 124.81), (1, 2, 199.70), (3, 1, 224.67), (2, 2, 259.62),
    (3, 2, 359.46), (1, 3, 424.37), (2, 3, 484.28), (3, 3, 584.13), (1, 4, 738.90),
    (4, 2, 499.26), (4, 3, 723.92), (2, 4, 798.81), (4, 4, 1038.46), (6, 3, 1123.33),
    (6, 4, 1437.87), (7, 2, 1158.28), (7, 4, 1697.48), (8, 1, 1323.04), (5, 1, 544.19),
    (7, 1, 1023.48), (9, 1, 1662.53),
]  # fmt: skip


def table_frequency(m, n):
    """Hz; all rows of Table 1 to 0.005 %."""
    return 44.9332 * (m**2 / A**2 + n**2 / B**2)


@pytest.fixture(scope="module")
def frequency_of_order(paper_basis):
    orders, share = mode_orders(paper_basis, (A, B))
    # every mode is a sine, or a pair of modes spans a pair of sines
    assert share.min() > 0.9999
    assert len({tuple(order) for order in orders}) == len(orders)
    frequency = paper_basis.natural_frequency[: len(orders)]
    return {(m, n): f for (m, n), f in zip(orders.tolist(), frequency, strict=True)}


@pytest.mark.parametrize(("m", "n", "frequency"), TABLE_1)
def test_table_1_is_reproduced(frequency_of_order, m, n, frequency):
    # 0.005 % in the table, (kh)^4 / 1440 of the element: 0.05 % for (9, 1)
    assert frequency_of_order[m, n] == pytest.approx(frequency, rel=6e-4)


def test_39_modes_lie_below_1700_hz_pairs_and_those_missing_from_table_1_included(
    paper_basis, frequency_of_order
):
    m, n = (grid.ravel() for grid in np.mgrid[1:12, 1:12])
    exact = {(i, j): table_frequency(i, j) for i, j in zip(m.tolist(), n.tolist(), strict=True)}
    below = [order for order, frequency in exact.items() if frequency < 1700]
    # the element tells exact pairs apart by its own error only
    for order in below:
        assert frequency_of_order[order] == pytest.approx(exact[order], rel=6e-4)
    modes = paper_basis.natural_frequency[~paper_basis.is_residual]
    assert np.sum(modes < 1700) == len(below) == 39


def test_inertia_counts_the_modes_of_navier(paper_plate):
    m, n = np.mgrid[1:40, 1:40]
    exact = np.sort(table_frequency(m, n).ravel())
    # away from the frequencies themselves, by more than the error of the element
    middle = (exact[1:] + exact[:-1]) / 2
    clear = (exact[1:] - exact[:-1] > 5e-3 * middle) & (middle < 3000)
    for frequency in middle[clear][::3]:
        assert count_modes_below(paper_plate, frequency) == np.sum(exact < frequency)


def test_a_pivot_that_vanishes_is_no_count():
    K = sp.csr_array(np.array([[4.0, 1.0], [1.0, 4.0]]))
    nothing = [None] * (sum(not part.kw_only for part in dataclasses.fields(AssembledPlate)) - 2)
    plate = AssembledPlate(K, sp.csr_array(np.eye(2)), *nothing)
    with pytest.raises(RuntimeError, match="a pivot vanished there"):
        count_modes_below(plate, 2 / (2 * np.pi))


def test_a_missed_mode_is_an_error(paper_plate, monkeypatch):
    eigenpairs = modes_module.eigenpairs

    def without_the_third(*args):
        eigenvalue, vectors = eigenpairs(*args)
        return np.delete(eigenvalue, 2), np.delete(vectors, 2, axis=1)

    monkeypatch.setattr(modes_module, "eigenpairs", without_the_third)
    with pytest.raises(RuntimeError, match="4 modes were found below 300 Hz, where 5 exist"):
        normal_modes(paper_plate, 300.0)


def test_the_same_plate_gives_the_same_modes_to_the_last_bit(paper_mesh, paper_plate):
    first, second = (panel_basis(paper_mesh, paper_plate, 1000.0) for _ in range(2))
    for field in dataclasses.fields(first):
        np.testing.assert_array_equal(getattr(first, field.name), getattr(second, field.name))


def test_shapes_have_a_largest_deflection_of_one_upwards(paper_basis):
    shapes = paper_basis.shape_at_vertices
    np.testing.assert_allclose(np.abs(shapes).max(axis=0), 1, rtol=1e-12)
    # of two equal largest deflections the first is upwards: (2, 1) rises first at small x
    np.testing.assert_allclose(shapes.max(axis=0), 1, rtol=2e-6)
    left = np.argmin(np.hypot(*(paper_basis.vertex_position - (0.4, 0.5)).T))
    assert shapes[left, 1] > 0.9


def test_the_first_mode_carries_a_quarter_of_the_mass(paper_basis):
    # m'' a b / 4; its crest is a grid point, the shape is a sine to 1e-6
    assert paper_basis.modal_mass[0] == pytest.approx(4.0 * 1.5 / 4, rel=1e-5)


def sine_overlap(m, p, length, lower, upper):
    """Integral of sin(m pi x / l) sin(p pi x / l) from lower to upper."""

    def primitive(x):
        difference = (
            x if m == p else np.sin((m - p) * np.pi * x / length) * length / (m - p) / np.pi
        )
        return (difference - np.sin((m + p) * np.pi * x / length) * length / (m + p) / np.pi) / 2

    return primitive(upper) - primitive(lower)


@pytest.mark.parametrize(
    ("name", "box"),
    [
        ("PID-1", (0.65, 0.85, 0.40, 0.60)),
        ("PID-2", (0.00, 0.20, 0.20, 0.40)),
        ("PID-3", (0.25, 0.45, 0.40, 0.60)),
    ],
)
def test_patch_overlap_is_the_integral_of_products_of_sines(paper_basis, name, box):
    overlap = paper_basis.patch_overlap[paper_basis.patch_names.index(name)]
    orders = [(1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (3, 2)]
    # amplitudes of the computed shapes against sines, from the deflection at one grid point
    # where none of the six sines is small
    x, y = 0.3, 0.4
    vertex = np.argmin(np.hypot(*(paper_basis.vertex_position - (x, y)).T))
    sines = np.array([np.sin(m * np.pi * x / A) * np.sin(n * np.pi * y / B) for m, n in orders])
    amplitude = paper_basis.shape_at_vertices[vertex, :6] / sines
    expected = np.array(
        [
            [sine_overlap(m, p, A, *box[:2]) * sine_overlap(n, q, B, *box[2:]) for p, q in orders]
            for m, n in orders
        ]
    )
    # shapes of the element are sines to (kh)^4 / 720, 3e-5 for (3, 2)
    np.testing.assert_allclose(
        overlap[:6, :6], np.outer(amplitude, amplitude) * expected, atol=1e-4 * 0.04
    )


def test_patches_that_tile_the_panel_add_up_to_the_mass(tmp_path):
    tiles = {
        f"{i}{j}": Rectangle((0.25 + 0.5 * i, 0.25 + 0.5 * j), (0.5, 0.5))
        for i in range(3)
        for j in range(2)
    }
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (18, 12), tiles, {})
    basis = panel_basis(mesh, assemble_thin_plate(mesh, SECTION), 800.0)
    whole = basis.patch_overlap.sum(axis=0)
    # M-orthogonality to rounding, over m''; 1e-8 for residual vectors, freed of modes twice
    np.testing.assert_allclose(whole, np.diag(basis.modal_mass / 4.0), atol=1e-9)


@pytest.fixture(scope="module")
def vectors(paper_plate):
    """Modes below 3 kHz and residual vectors in the coordinates of the elements."""
    _, modes = normal_modes(paper_plate, 3000.0)
    _, residuals = residual_vectors(paper_plate, modes, tolerance=1e-4)
    return modes, residuals


def test_modes_and_residual_vectors_diagonalise_mass_and_stiffness(
    paper_plate, paper_basis, vectors
):
    basis = np.hstack(vectors)
    angular = 2 * np.pi * paper_basis.natural_frequency
    for matrix, diagonal in [
        (paper_plate.mass, paper_basis.modal_mass),
        (paper_plate.stiffness, angular**2 * paper_basis.modal_mass),
    ]:
        product = basis.T @ (matrix @ basis)
        scale = np.sqrt(np.outer(diagonal, diagonal))
        # Lanczos converges to 1e-12, the residual vectors span frequencies of 3 to 40 kHz
        np.testing.assert_allclose(product / scale, np.eye(len(angular)), atol=1e-8)


def test_static_answers_to_the_patches_lie_in_the_basis(paper_plate, vectors):
    modes = vectors[0]
    basis = np.hstack(vectors)
    K = paper_plate.stiffness
    stiffness = np.einsum("ki,ki->i", basis, K @ basis)
    for overlap in paper_plate.patch_overlap.values():
        answer = spla.spsolve(K.tocsc(), overlap @ modes)
        rest = answer - basis @ (basis.T @ (K @ answer) / stiffness[:, None])
        energy = np.einsum("ki,ki->i", rest, K @ rest)
        largest = np.einsum("ki,ki->i", answer, K @ answer).max()
        # directions below 1e-4 of the largest were dropped
        assert np.sqrt(energy.max() / largest) < 1e-4


def diffuse_waves(angular_frequency, position):
    """Pressures of 72 plane waves that together make a diffuse field, (n_positions, 72).

    Gauss points in the cosine of the angle to the normal, equal steps of azimuth.
    """
    cosine, weight = np.polynomial.legendre.leggauss(6)
    azimuth = np.arange(12) * 2 * np.pi / 12 + 0.1
    sine = np.sqrt(1 - ((cosine + 1) / 2) ** 2)[:, None]
    trace = np.array([sine * np.cos(azimuth), sine * np.sin(azimuth)]).reshape(2, -1)
    amplitude = np.sqrt(np.repeat(weight / 2, 12) / 12)
    return amplitude * np.exp(1j * angular_frequency / 343 * (position @ trace))


@pytest.mark.slow
@pytest.mark.parametrize("patch", ["PID-2"])
def test_a_strong_patch_moves_as_in_a_direct_solve_of_the_whole_plate(
    paper_plate, paper_mesh, paper_basis, patch
):
    C_e, m_a = 3e4, 3.0  # N s/m^3 and kg/m^2: at 2 kHz the patch all but pins the panel
    loss = 0.02  # K (1 + 0.02 i): structural, 1 % critical
    weight = paper_plate.quadrature_weight[:, None]
    K, M, D = paper_plate.stiffness, paper_plate.mass, paper_plate.patch_overlap[patch]

    modal_mass = paper_basis.modal_mass
    modal_stiffness = (2 * np.pi * paper_basis.natural_frequency) ** 2 * modal_mass
    overlap = paper_basis.patch_overlap[paper_basis.patch_names.index(patch)]
    for frequency in [70.0, 200.0, 500.0, 1000.0, 1500.0, 1800.0, 2000.0]:
        omega = 2 * np.pi * frequency
        Z = 1j * omega * C_e - omega**2 * m_a
        waves = diffuse_waves(omega, paper_plate.quadrature_position)
        # one uniform pressure before the waves of the diffuse field
        pressure = weight * np.column_stack([np.ones(len(waves)), waves])

        dynamic = K * (1 + 1j * loss) - omega**2 * M + Z * D
        direct = spla.splu(dynamic.tocsc()).solve(paper_plate.at_quadrature.T @ pressure)
        expected = paper_plate.at_vertices[[325, 188, 317]] @ direct

        modal = np.diag(modal_stiffness * (1 + 1j * loss) - omega**2 * modal_mass) + Z * overlap
        q = np.linalg.solve(modal, paper_basis.shape_at_quadrature.T @ pressure)
        w = paper_basis.shape_at_points @ q

        # What the modes above 3 kHz hold back of the direct force of the sound: 0.35 % of the
        # deflection, 0.11 % of the PSD. Without residual vectors it is 15 % and 14 %.
        np.testing.assert_allclose(w[:, 0], expected[:, 0], rtol=5e-3)
        psd, expected_psd = (np.sum(np.abs(d[:, 1:]) ** 2, axis=1) for d in (w, expected))
        np.testing.assert_allclose(psd, expected_psd, rtol=5e-3)


def test_a_patch_of_one_element_has_no_more_residual_vectors_than_coordinates(tmp_path):
    """Tolerance 0 drops what rounding makes of the null space of D."""
    patch = {"P": Rectangle((0.35, 0.45), (0.1, 0.1))}
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (15, 10), patch, {})
    plate = assemble_thin_plate(mesh, SECTION)
    _, modes = normal_modes(plate, 1200.0)
    assert modes.shape[1] > 16
    _, residuals = residual_vectors(plate, modes, 0.0)
    # a bicubic has 16 coordinates; a few lie in rounding themselves
    assert 10 <= residuals.shape[1] <= 16


def test_a_panel_without_patches_has_no_residual_vectors(tmp_path):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (15, 10), {}, {"326": (0.5, 0.5)})
    basis = panel_basis(mesh, assemble_thin_plate(mesh, SECTION), 500.0)
    assert not basis.is_residual.any()
    assert basis.patch_overlap.shape == (0, len(basis.modal_mass), len(basis.modal_mass))


def test_a_panel_that_is_stiff_in_its_range_keeps_the_first_modes_above_it(tmp_path):
    # 0.3 m × 0.2 m: the first at 1622 Hz, where a study ends at 200 Hz
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (0.3, 0.2), (12, 8), {}, {"c": (0.15, 0.1)})
    basis = panel_basis(mesh, assemble_thin_plate(mesh, SECTION), 400.0)
    m, n = np.mgrid[1:12, 1:12]
    exact = np.sort(thin_plate_frequency(m, n, (0.3, 0.2), ThinSection(3273.07, 4.0)).ravel())[
        :LEAST_MODES
    ]
    assert basis.natural_frequency.size == LEAST_MODES
    # bicubics, two to a half wave and more: 2e-3
    np.testing.assert_allclose(basis.natural_frequency, exact, rtol=2e-3)


COUNT, SPRING, MASS = 200, 3e7, 0.25


def chain(ends_held, patches=()):
    """Masses in a row between springs; a patch is some of the masses, by their weights."""
    K = 2 * np.eye(COUNT) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1)
    if not ends_held:
        K[0, 0] = K[-1, -1] = 1
    empty = dict.fromkeys(field.name for field in dataclasses.fields(AssembledPlate))
    return AssembledPlate(
        **empty
        | {
            "stiffness": sp.csr_array(SPRING * K),
            "mass": sp.csr_array(MASS * np.eye(COUNT)),
            "patch_overlap": {str(k): sp.csr_array(np.diag(w)) for k, w in enumerate(patches)},
            "at_vertices": sp.csr_array(np.eye(COUNT)),
            "at_quadrature": sp.csr_array((0, COUNT)),
        }
    )


def frequencies(ends_held, count):
    """f_j = (1/π) √(k/m) sin(jπ/2(n + 1)), or sin(jπ/2n) from j = 0 of a free chain."""
    j = np.arange(count) + (1 if ends_held else 0)
    angle = np.pi * j / (2 * (COUNT + 1 if ends_held else COUNT))
    return np.sqrt(SPRING / MASS) / np.pi * np.sin(angle)


def patch(first, last):
    weight = np.zeros(COUNT)
    weight[first:last] = np.linspace(0.01, 0.02, last - first)
    return weight


@pytest.mark.parametrize("below", [50, 120, 199])
def test_a_chain_has_as_many_modes_as_it_carries(below):
    exact = frequencies(True, below + 1)
    frequency, modes = normal_modes(chain(True), exact[-2:].mean(), 10)
    np.testing.assert_allclose(frequency, exact[:-1], rtol=1e-9)
    assert modes.shape == (COUNT, below)


@pytest.mark.parametrize("ends_held", [True, False])
@pytest.mark.parametrize("tolerance", [0.3, 0.03, 1e-3])
def test_residual_vectors_are_the_strongest_static_answers_that_the_modes_lack(
    ends_held, tolerance
):
    # by a singular value decomposition in the norm of the elastic energy, without a Gram matrix
    plate = chain(ends_held, [patch(30, 50), patch(120, 170)])
    limit = frequencies(ends_held, 7)[-2:].mean()
    frequency, modes = normal_modes(plate, limit)
    found, residuals = residual_vectors(plate, modes, tolerance)
    K, M = plate.stiffness.toarray(), plate.mass.toarray()

    lowest = frequency[frequency > 0][0]
    inverted = K if ends_held else K + (2 * np.pi * lowest) ** 2 * M
    forces = np.hstack([D.toarray() @ modes for D in plate.patch_overlap.values()])
    static = np.linalg.solve(inverted, forces)
    for _ in range(2):
        static -= modes @ np.linalg.solve(modes.T @ M @ modes, modes.T @ M @ static)
    root = la.sqrtm(K).real
    left, strength, _ = np.linalg.svd(root @ static, full_matrices=False)
    expected = int(np.sum(strength > tolerance * strength[0]))
    assert 0 < expected < 12
    assert residuals.shape[1] == expected

    both = np.hstack([modes, residuals])
    for matrix in (K, M):
        product = both.T @ matrix @ both
        size = np.sqrt(np.maximum(np.diag(product), 1e-9 * np.diag(product).max()))
        off = product - np.diag(np.diag(product))
        assert np.abs(off / np.outer(size, size)).max() < 1e-6
    ratio = np.einsum("ki,ki->i", residuals, K @ residuals) / np.einsum(
        "ki,ki->i", residuals, M @ residuals
    )
    np.testing.assert_allclose(found, np.sqrt(ratio) / (2 * np.pi), rtol=1e-8)
    assert (np.diff(found) > 0).all() and found[0] > frequency[-1]
    np.testing.assert_allclose(np.abs(residuals).max(axis=0), 1, rtol=1e-12)
    # they span the strongest directions
    inside, _ = np.linalg.qr(root @ residuals)
    rest = left[:, :expected] - inside @ (inside.T @ left[:, :expected])
    assert np.abs(rest).max() < 1e-5


def test_the_basis_holds_the_modes_at_points_patches_and_quadrature(tmp_path):
    # of a coarse plate, against sums over its quadrature
    box = {"P": Rectangle((0.4, 0.6), (0.4, 0.2)), "Q": Rectangle((1.2, 0.3), (0.2, 0.4))}
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (1.5, 1.0), (15, 10), box, {"7": (0.4, 0.3)})
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    basis = panel_basis(mesh, plate, 300.0, 1e-2)
    n_modes = LEAST_MODES
    assert basis.is_residual.tolist() == [k >= n_modes for k in range(len(basis.modal_mass))]
    assert basis.is_residual.any()
    np.testing.assert_allclose(patch_areas(basis), [0.08, 0.08], rtol=1e-12)
    assert basis.patch_names == ("P", "Q") and basis.point_names == ("7",)
    np.testing.assert_allclose(basis.point_position, [[0.4, 0.3]])
    (at,) = np.flatnonzero(np.linalg.norm(mesh.vertices - (0.4, 0.3), axis=1) < 1e-9)
    np.testing.assert_allclose(basis.shape_at_points[0], basis.shape_at_vertices[at], rtol=1e-12)
    curvature = basis.curvature_at_vertices[at]
    np.testing.assert_allclose(
        basis.curvature_at_points[0], curvature, atol=1e-9 * np.abs(curvature).max()
    )
    weight = basis.quadrature_weight[:, None]
    shape = basis.shape_at_quadrature
    # nine points on a cell integrate the square of the modes to a part in 10⁵ there
    whole = shape.T @ (weight * shape)
    np.testing.assert_allclose(
        4.0 * np.diag(whole)[:n_modes], basis.modal_mass[:n_modes], rtol=1e-4
    )
    x, y = basis.quadrature_position.T
    for number, (lower, upper) in enumerate((((0.2, 0.5), (0.6, 0.7)), ((1.1, 0.1), (1.3, 0.5)))):
        inside = (x > lower[0]) & (x < upper[0]) & (y > lower[1]) & (y < upper[1])
        part = (shape[inside].T @ (weight[inside] * shape[inside]))[:n_modes, :n_modes]
        np.testing.assert_allclose(
            basis.patch_overlap[number][:n_modes, :n_modes], part, atol=1e-4 * np.abs(part).max()
        )


def test_a_tilt_has_no_elastic_energy_but_rounding():
    # three deflections with a curvature
    curvature = np.array([[1.0, -2.0, 1.0]])
    plate = SimpleNamespace(stiffness=sp.csr_array(curvature.T @ curvature))
    modes = np.array([[-1.0, 1e-9, 1.0], [1.0, 1.0, 1.0], [-1.0, 1e-3, 1.0]]).T
    np.testing.assert_array_equal(is_rigid(plate, modes), [True, True, False])
