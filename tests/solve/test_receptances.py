"""Motions of the bare panel: shapes among what is observed change nothing; diagonals are matrices."""

import numpy as np
import pytest

from pidpanel.solve.model import ModalBasis
from pidpanel.solve.moved_panel import MovedPanel, coupled_shapes
from pidpanel.solve.receptances import Receptances, times

N, LINES = 5, 3
DRAW = np.random.default_rng(2)
FREQUENCY = np.array([40.0, 90.0, 200.0])
BASIS = ModalBasis(np.linspace(50.0, 250.0, N), np.linspace(1.0, 2.0, N), 0.02)
OTHERS = DRAW.normal(size=(N, 2))
ROOT = DRAW.normal(size=(LINES, N, 2)) + 1j * DRAW.normal(size=(LINES, N, 2))
FORCE = ROOT @ ROOT.conj().swapaxes(1, 2)
COUPLED = 1e4 * (DRAW.normal(size=(N, N)) + 1j * DRAW.normal(size=(N, N)))
AIR = np.broadcast_to(COUPLED + COUPLED.T, (LINES, N, N))


@pytest.mark.parametrize("air", [None, AIR], ids=["in vacuum", "in air"])
@pytest.mark.parametrize("pulled", [0, 1])
def test_shapes_themselves_move_as_any_motions_do(air, pulled):
    # against Wᵀ Z⁻¹ G Z⁻ᴴ W
    stiffness = BASIS.dynamic_stiffness(FREQUENCY)[:, :, None] * np.eye(N)
    inverse = np.linalg.inv(stiffness if air is None else stiffness + air)
    sets = [np.eye(N), OTHERS]
    moved = MovedPanel(FREQUENCY, BASIS, coupled_shapes(air, FREQUENCY, BASIS), [None, OTHERS])
    psds, factored = (
        moved.psds(pulled, [0, 1], force, is_factor=force is ROOT) for force in (FORCE, ROOT)
    )
    for part, columns in enumerate(sets):
        receptance = columns.T @ inverse @ sets[pulled]
        psd = columns.T @ inverse @ FORCE @ inverse.conj().swapaxes(1, 2) @ sets[pulled]
        np.testing.assert_allclose(moved.receptances(pulled, [part])[0], receptance, rtol=1e-9)
        np.testing.assert_allclose(psds[part], psd, rtol=1e-9, atol=1e-12 * np.abs(psd).max())
        np.testing.assert_allclose(factored[part], psds[part], atol=1e-12 * np.abs(psd).max())


@pytest.mark.parametrize("pull_is_diagonal", [False, True])
@pytest.mark.parametrize("felt_is_diagonal", [False, True])
def test_a_panel_with_dampers_is_that_of_the_sum_of_stiffnesses(felt_is_diagonal, pull_is_diagonal):
    # R' = (R⁻¹ + S)⁻¹ and its PSDs, with diagonals stored alone
    diagonal = 1 / BASIS.dynamic_stiffness(FREQUENCY)
    full = diagonal[:, :, None] * np.eye(N)
    felt = full if felt_is_diagonal else np.linalg.inv(np.linalg.inv(full) + AIR)
    pull = 2e4j * (np.ones((LINES, N)) if pull_is_diagonal else np.eye(N)[None] + AIR / 1e5)
    matrix = pull[:, :, None] * np.eye(N) if pull_is_diagonal else pull
    follows = np.linalg.inv(np.eye(N) + felt @ matrix)
    across, psd = OTHERS.T @ felt, felt @ FORCE @ felt.conj().swapaxes(1, 2)
    panel = Receptances(diagonal if felt_is_diagonal else felt, across, psd, OTHERS.T @ psd)
    damped_psd = follows @ psd @ follows.conj().swapaxes(1, 2)
    for found, expected in zip(panel.felt_with(pull), (follows @ felt, damped_psd), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(panel.felt_psd_with(pull), damped_psd.real, rtol=1e-8, atol=1e-20)
    reaction = panel.reaction(pull)
    remaining = OTHERS.T @ psd @ OTHERS - reaction.drop
    expected = OTHERS.T @ damped_psd @ OTHERS
    np.testing.assert_allclose(remaining, expected, atol=1e-10 * np.abs(expected).max())
    u0, w0 = ROOT[:, :, 0], ROOT[:, :2, 1]
    u = (follows @ u0[:, :, None])[:, :, 0]
    moved = w0 - (across @ (matrix @ u[:, :, None]))[:, :, 0]
    np.testing.assert_allclose(panel.motions(pull, u0, w0), moved, rtol=1e-9)


@pytest.mark.parametrize("left", ["diagonal", "full"])
@pytest.mark.parametrize("right", ["diagonal", "full"])
def test_products_of_diagonals_are_those_of_matrices(left, right):
    draws = {"diagonal": DRAW.normal(size=(LINES, N)), "full": DRAW.normal(size=(LINES, N, N))}
    full = [
        values[:, :, None] * np.eye(N) if values.ndim == 2 else values
        for values in (draws[left], draws[right])
    ]
    found = times(draws[left], draws[right])
    found = found[:, :, None] * np.eye(N) if found.ndim == 2 else found
    np.testing.assert_allclose(found, full[0] @ full[1], atol=1e-12)
