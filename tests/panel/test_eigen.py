"""Eigenpairs slice by slice are all that there are."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from pidpanel.panel import eigen


def membrane(sides, rigid=False):
    """K and M of a net of springs on a grid, whose eigenvalues are sums of those along its sides.

    Free along its sides it moves as a rigid body; a square has its eigenvalues twice.
    """
    parts = []
    for count in sides:
        line = sp.diags_array(
            [-np.ones(count - 1), 2 * np.ones(count), -np.ones(count - 1)], offsets=[-1, 0, 1]
        ).tolil()
        if rigid:
            line[0, 0] = line[-1, -1] = 1
        parts.append(line.tocsr())
    (a, b), (m, n) = parts, sides
    stiffness = sp.kron(a, sp.eye_array(n)) + sp.kron(sp.eye_array(m), b)
    exact = np.add.outer(*(la.eigvalsh(part.toarray()) for part in parts)).ravel()
    return sp.csr_array(stiffness), sp.csr_array(2.0 * sp.eye_array(m * n)), np.sort(exact) / 2


@pytest.mark.parametrize("rigid", [False, True])
@pytest.mark.parametrize("slices", [1, 3])
@pytest.mark.parametrize("lost", [eigen.LOST, 0.0])
def test_all_eigenvalues_below_the_limit_are_found_once_pairs_included(
    monkeypatch, rigid, slices, lost
):
    # a square of 40 × 40 springs: nearly all eigenvalues are pairs
    monkeypatch.setattr(eigen, "LOST", lost)
    monkeypatch.setattr(eigen, "ROOM", 48)
    K, M, exact = membrane((40, 40), rigid)
    limit = (exact[119] + exact[120]) / 2 if exact[120] - exact[119] > 1e-6 else exact[121] + 1e-9
    expected = exact[exact < limit]
    monkeypatch.setattr(eigen, "SLICE", -(-len(expected) // slices))
    value, vectors = eigen.eigenpairs(K, M, limit, len(expected))
    # the square of `CONVERGED` is below rounding, that of 8, the largest of K
    np.testing.assert_allclose(value, expected, atol=1e-12)
    np.testing.assert_allclose(vectors.T @ (M @ vectors), np.eye(len(value)), atol=1e-7)
    np.testing.assert_allclose(K @ vectors, M @ vectors * value, atol=1e-7)


def test_eigenpairs_do_not_depend_on_units():
    # stiffness of a panel is 1e10 of ours
    K, M, exact = membrane((40, 40))
    limit = (exact[119] + exact[122]) / 2 + 1e-9
    expected = exact[exact < limit]
    for scale in (1e-10, 1e10):
        value, vectors = eigen.eigenpairs(scale * K, M, scale * limit, len(expected))
        np.testing.assert_allclose(value / scale, expected, atol=1e-12)
        np.testing.assert_allclose(K @ vectors, M @ vectors * (value / scale), atol=1e-7)


def test_a_slice_without_eigenvalues_is_empty(monkeypatch):
    # two blocks far apart: the middle of the spectrum is empty
    value = np.concatenate([np.linspace(1, 2, 20), np.linspace(80, 400, 980)])
    K, M = sp.csr_array(sp.diags_array(value)), sp.csr_array(sp.eye_array(1000))
    monkeypatch.setattr(eigen, "SLICE", 20)
    found, _ = eigen.eigenpairs(K, M, 88.0, 80)
    np.testing.assert_allclose(found, value[value < 88], atol=1e-9)


def test_more_vectors_than_coordinates_are_refused(monkeypatch):
    # 36 coordinates have no fifth block of eight
    K = sp.csr_array(sp.diags_array(np.arange(1.0, 37.0)))
    monkeypatch.setattr(eigen, "CONVERGED", 0.0)
    with pytest.raises(RuntimeError, match="Lanczos iteration ended before"):
        eigen.eigenpairs(K, sp.csr_array(sp.eye_array(36)), 31.0, 30)


@pytest.mark.parametrize("scale", [1.0, 1e10])
def test_an_error_along_an_earlier_block_is_taken_out_and_remembered(monkeypatch, scale):
    # the fourth and the sixth block err by 1e-3 of their own size against the first: by three,
    # the fourth is orthogonalised, and says that the sixth has to be, whatever sign and unit
    K, M, exact = membrane((40, 40))
    factors, forces = eigen.factors, []

    def erring(matrix):
        solve = factors(matrix).solve

        def answer(force):
            forces.append(force)
            columns = solve(force)
            if len(forces) in (5, 7):  # the first starts the iteration
                first = M.diagonal()[0] ** -1 * forces[1]
                columns -= 1e-3 * np.linalg.norm(columns, axis=0).min() * first[:, :1]
            return columns

        return SimpleNamespace(solve=answer)

    monkeypatch.setattr(eigen, "factors", erring)
    monkeypatch.setattr(eigen, "CONVERGED", 1e-2)
    limit = scale * ((exact[119] + exact[122]) / 2 + 1e-9)
    _, vectors = eigen.eigenpairs(scale * K, M, limit, 120)
    np.testing.assert_allclose(vectors.T @ (M @ vectors), np.eye(vectors.shape[1]), atol=1e-10)
