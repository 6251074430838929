"""Motions of the bare panel: shapes among what is looked at change nothing."""

import numpy as np
import pytest

from pidpanel.solve.bare_motions import InVacuum, ShapesInVacuum

N = 5
DRAW = np.random.default_rng(2)
STIFFNESS = DRAW.normal(size=(3, N)) + 1j * DRAW.normal(size=(3, N))
OBSERVED = np.hstack([np.eye(N), DRAW.normal(size=(N, 2))])
ROOT = DRAW.normal(size=(3, N, 2)) + 1j * DRAW.normal(size=(3, N, 2))
FORCE = ROOT @ ROOT.conj().swapaxes(1, 2)
SHAPES, OTHERS = slice(0, N), slice(N, N + 2)


@pytest.mark.parametrize("left", [SHAPES, OTHERS])
@pytest.mark.parametrize("right", [SHAPES, OTHERS])
def test_shapes_themselves_move_as_any_motions_do(left, right):
    # against Wᵀ Z⁻¹ G Z⁻ᴴ W of diagonal Z; red: swapaxes(2, 2), the rows' own conjugates
    f = np.array([1.0, 2.0, 3.0])
    inverse = np.array([np.diag(1 / z) for z in STIFFNESS])
    psd = OBSERVED[:, left].T @ inverse @ FORCE @ inverse.conj() @ OBSERVED[:, right]
    rows = np.r_[OTHERS, left]
    receptance = OBSERVED[:, rows].T @ inverse @ OBSERVED[:, right]
    for form in (InVacuum, ShapesInVacuum):
        moved = form(STIFFNESS, OBSERVED)
        np.testing.assert_allclose(moved.psd(FORCE, f, slice(None))(left, right), psd)
        np.testing.assert_allclose(moved.receptance(rows, right), receptance)
