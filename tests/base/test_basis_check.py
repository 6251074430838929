"""The basis under base motion against all elements."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as la
from moving import APPARENT, DAMPING, HIGHEST, RATIO, solved

from pidpanel.base import basis_check
from pidpanel.base.basis_check import base_errors
from pidpanel.damping_ratio import DampingRatio
from pidpanel.solve.basis_error import (
    ALLOWED,
    ATTEMPTS,
    check_basis,
)
from pidpanel.solve.elements import ElementMotion
from pidpanel.solve.receptances import patch_stiffness

LINES = np.array([35.0, 110.0, 224.0, 390.0])


def checked(panel, kept):
    """Errors (2, nf) of some shapes, of the bare panel and with a damper."""
    supported = panel.supported
    arrays = {
        name: getattr(supported.basis, name)[kept]
        for name in ("natural_frequency", "modal_mass", "is_residual")
    }
    basis, vectors = replace(supported.basis, **arrays), supported.vectors[:, kept]
    ones = np.ones((1, LINES.size))
    dampers = np.array(
        [patch_stiffness(LINES, C * ones, m * ones) for C, m in ((0.0, 0.0), (DAMPING, APPARENT))]
    )
    return check_basis(
        basis, panel.plate, vectors, base_errors(basis, panel.plate, vectors),
        DampingRatio((RATIO,)), HIGHEST, LINES, dampers,
    ).error  # fmt: skip


def dense_gains(panel, frequency, damping, mass, kept):
    """Absolute over base acceleration at the points, of all elements and of some shapes."""
    plate, supported, w = panel.plate, panel.supported, 2 * np.pi * frequency
    K, M = plate.stiffness.toarray(), plate.mass.toarray()
    square, vector = la.eigh(K, M)
    omega, cutoff = np.sqrt(square), 2 * np.pi * 2 * HIGHEST
    ratio = np.where(omega < cutoff, RATIO, RATIO * omega / cutoff)
    D, s = plate.patch_overlap["PID-1"].toarray(), 1j * w * damping - w**2 * mass
    Z = K - w**2 * M + 1j * w * M @ vector @ np.diag(2 * ratio * omega) @ vector.T @ M + s * D
    per_cell = len(plate.quadrature_weight) // len(supported.basis.cells)
    weight = plate.quadrature_weight * np.repeat(supported.basis.cell_in_patch[0], per_cell)
    force = s / w**2 * (plate.at_quadrature.T @ weight) - plate.inertia
    points = plate.at_points.toarray()
    V = supported.vectors[:, kept]
    answers = np.linalg.solve(Z, force), V @ np.linalg.solve(V.T @ Z @ V, V.T @ force)
    return [np.abs(1 - w**2 * points @ answer) ** 2 for answer in answers]


def test_the_modal_basis_is_good_under_base_motion(panel):
    assert checked(panel, slice(None)).max() < ALLOWED / 10


@pytest.mark.parametrize("count", [3, 6])
def test_the_error_is_that_against_dense_matrices(panel, count):
    modes = np.flatnonzero(~panel.supported.basis.is_residual)[:count]
    errors = checked(panel, modes)
    assert errors.max() > 0.02
    for row, damper in zip(errors, ((0.0, 0.0), (DAMPING, APPARENT)), strict=True):
        for error, frequency in zip(row, LINES, strict=True):
            whole, reduced = dense_gains(panel, frequency, *damper, modes)
            exact = np.abs(reduced - whole).max() / whole.max()
            assert error == pytest.approx(exact, rel=0.1, abs=1e-3)


@pytest.mark.parametrize(
    ("missed", "calls", "error", "lines"),
    [
        ([0, 0], 1, 0.001, 0),  # good for both motions at once
        ([2, 0], ATTEMPTS, 0.001, ATTEMPTS - 1),
        ([0, 3], ATTEMPTS, 0.2, ATTEMPTS),
    ],
)
def test_a_basis_is_widened_by_what_all_motions_miss_until_the_last_attempt(
    monkeypatch, capsys, missed, calls, error, lines
):
    widths = []

    def supported_in(start, plate, further_shapes, highest, mass, translation):
        widths.append(further_shapes.shape[1])
        return len(widths)

    def check(panel, *_):
        missing = np.ones((5, missed[panel]))
        return SimpleNamespace(
            error=np.array([[error, 0.0], [error / 4, 0.0]]) / (1 + panel), missing_shapes=missing
        )

    monkeypatch.setattr(basis_check, "supported_panel", supported_in)
    monkeypatch.setattr(basis_check, "_check", check)
    plate = SimpleNamespace(shapes=np.zeros((5, 4)))
    last, largest = basis_check.checked_panel(
        None, plate, np.zeros((5, 0)), HIGHEST, 1.0, lambda supported: (0, 1), []
    )
    assert (last, largest) == (calls, error)
    assert widths == [sum(missed) * attempt for attempt in range(calls)]
    assert len(capsys.readouterr().err.splitlines()) == lines


def test_dampers_on_both_parts_of_the_face_are_one_on_the_whole_face(panel):
    basis, vectors = panel.supported.basis, panel.supported.vectors
    draw = np.random.default_rng(0)
    of_basis, whole = (1e-5j * draw.normal(size=(rows, 2)) for rows in vectors.T.shape)
    motion = ElementMotion(of_basis, whole, whole)
    inside = basis.cell_in_patch[0]
    errors = [
        base_errors(SimpleNamespace(cells=basis.cells, cell_in_patch=parts), panel.plate, vectors)(
            40.0, np.full((1, len(parts)), 3e5j - 2e4), [motion]
        )
        for parts in (np.array([inside, ~inside]), np.array([inside | ~inside]))
    ]
    assert errors[0] == pytest.approx(errors[1], rel=1e-9)


def test_all_elements_move_as_the_shapes(panel):
    whole, _ = dense_gains(panel, 110.0, DAMPING, APPARENT, slice(None))
    motion, _, _ = solved(panel, np.array([110.0]), DAMPING, APPARENT)
    gain = np.abs((2 * np.pi * 110.0) ** 2 * motion[0, :-1, 0]) ** 2
    np.testing.assert_allclose(gain, whole, rtol=ALLOWED / 10)
