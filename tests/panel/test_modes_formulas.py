"""Modes and residual vectors of chains of masses and springs, whose frequencies are known."""

import dataclasses

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import panel_basis, patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.modes import LEAST_MODES, count_modes_below, normal_modes, residual_vectors
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate

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


@pytest.mark.parametrize("ends_held", [True, False])
@pytest.mark.parametrize("below", [1, 2, 5, 12])
def test_all_modes_of_a_chain_below_a_limit_are_found(ends_held, below):
    # red: (2 * np.pi * f) ** 2 → * 2, 3 * np.pi; / np.sqrt(stiffness) → *; U.diagonal() < 0 → >= 0;
    # energy < RIGID → >=
    exact = frequencies(ends_held, below + 1)
    limit = exact[-2:].mean()
    plate = chain(ends_held)
    assert count_modes_below(plate, limit) == below
    frequency, modes = normal_modes(plate, limit)
    np.testing.assert_allclose(frequency, exact[:-1], rtol=1e-9)
    assert (frequency[0] == 0) == (not ends_held)
    np.testing.assert_allclose(np.abs(modes).max(axis=0), 1, rtol=1e-12)
    # of several largest deflections the first is positive
    for mode in modes.T:
        assert mode[np.flatnonzero(np.abs(mode) > 1 - 0.5e-6)[0]] > 0


@pytest.mark.parametrize(("share", "first"), [(0.95e-6, 1), (1.05e-6, -1)])
def test_the_first_of_the_largest_deflections_to_a_millionth_is_positive(share, first):
    # of the second mode, with a peak on either side, the first made smaller by a share
    # red: 1 - 1e-6 → 1 - 1.1e-6 in `_normalise`
    plate = chain(True)
    (_, second) = normal_modes(plate, frequencies(True, 3)[-2:].mean())[1].T
    seen = np.ones(COUNT)
    seen[: COUNT // 2] = 1 - share
    plate = dataclasses.replace(plate, at_vertices=sp.csr_array(np.diag(seen)))
    _, modes = normal_modes(plate, frequencies(True, 3)[-2:].mean())
    np.testing.assert_allclose(modes[:, 1], first * second, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("below", [50, 120, 199])
def test_a_chain_has_as_many_modes_as_it_carries(below):
    # red: 3 * wanted < n_free → True: Lanczos finds no more than it has coordinates for
    exact = frequencies(True, below + 1)
    frequency, modes = normal_modes(chain(True), exact[-2:].mean(), 10)
    np.testing.assert_allclose(frequency, exact[:-1], rtol=1e-9)
    assert modes.shape == (COUNT, below)


def test_modes_above_the_limit_are_kept_up_to_a_number():
    # red: kept = slice(count)
    frequency, modes = normal_modes(chain(True), 1e-3 * frequencies(True, 1)[0], 15)
    np.testing.assert_allclose(frequency, frequencies(True, 15), rtol=1e-9)
    assert modes.shape == (COUNT, 15)


@pytest.mark.parametrize("ends_held", [True, False])
@pytest.mark.parametrize("tolerance", [0.3, 0.03, 1e-3])
def test_residual_vectors_are_the_strongest_static_answers_that_the_modes_lack(
    ends_held, tolerance
):
    # by a singular value decomposition in the norm of the elastic energy, without a Gram matrix
    # red: static -= → +=; tolerance**2 → tolerance; energy[-1] → energy[-2]; / np.sqrt(energy) → *;
    # first.item() * plate.mass → /; / (2 * np.pi) → * in the frequencies
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
    # red: arange >= len(frequency) → <; vectors.T @ (overlap @ vectors) → -; cells not in the patch
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
    np.testing.assert_array_equal(basis.shape_at_points[0], basis.shape_at_vertices[at])
    np.testing.assert_array_equal(basis.curvature_at_points[0], basis.curvature_at_vertices[at])
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
