"""Equivalent linearisation, against exact densities and dense solutions."""

import itertools

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.matrices import Stretching
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.layout import AttachedDamper, DamperLayout, solve_with
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.search import LinearisationError
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.stretching import (
    SLOPE,
    duffing_excess,
    gaussian_stiffness,
    linearised_stiffness,
    stretched_responses,
)

RNG = np.random.default_rng(7)


def energy_tensor(n, scale=1.0, rng=RNG):
    """A tensor of membrane energy: Gram matrix of symmetric e_ij in a space of many dimensions."""
    e = rng.normal(size=(n, n, 2 * n))
    e += 2 * np.eye(n)[:, :, None] + e.swapaxes(0, 1)
    return scale * np.einsum("ijp,klp->ijkl", e, e) / e.shape[2]


def test_the_stiffness_is_the_mean_hessian_of_the_energy():
    # E[∂²U] = 6 S:C of the tensor S symmetric in all indices (Isserlis)
    tensor = energy_tensor(3)
    S = np.mean([tensor.transpose(p) for p in itertools.permutations(range(4))], axis=0)
    half = RNG.normal(size=(3, 3))
    C = half @ half.T
    expected = 6 * np.einsum("ijkl,kl->ij", S, C)
    np.testing.assert_allclose(gaussian_stiffness(tensor, C), expected, rtol=1e-12)


def exact_rms(stiffness, tensor, temperature, covariance, count=200_000):
    """Rms of modes of the density exp(−V/T) by importance sampling, and its standard error."""
    n = len(stiffness)
    z = np.random.default_rng(3).normal(size=(count, n))
    q = z @ np.linalg.cholesky(1.3 * covariance).T
    pairs = (q[:, :, None] * q[:, None]).reshape(count, n * n)
    membrane = np.einsum("pi,pi->p", pairs @ tensor.reshape(n * n, n * n), pairs) / 2
    log_weight = -(membrane + q**2 @ stiffness / 2) / temperature + (z**2).sum(axis=1) / 2
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    square = weight @ q**2
    spread = np.sqrt(weight**2 @ (q**2 - square) ** 2)
    return np.sqrt(square), spread / square / 2


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("scale", [0.03, 0.3, 3.0])
def test_modes_together_move_between_the_linearised_rms_and_that_of_a_mode_alone(seed, scale):
    # none of these set the excess
    rng = np.random.default_rng(seed)
    stiffness = rng.uniform(1, 4, 4) ** 2
    tensor = energy_tensor(4, scale, rng)
    K = linearised_stiffness(tensor, lambda K: np.linalg.inv(np.diag(stiffness) + K))
    covariance = np.linalg.inv(np.diag(stiffness) + K)
    exact, sampling = exact_rms(stiffness, tensor, 1.0, covariance)
    excess = duffing_excess(np.diag(K) / (stiffness + np.diag(K)))
    more = exact / np.sqrt(np.diag(covariance)) - 1
    assert (-4 * sampling <= more).all() and (more <= excess + 4 * sampling).all()


def averaged_excess(cubic, p):
    """Rms of a mode whose load falls as f^−p over the linearised one, less 1, by its energy.

    V = x²/2 + cubic x⁴/4; T = 1 at the linearised frequency.
    """
    square = (np.sqrt(1 + 12 * cubic) - 1) / (6 * cubic)
    A = np.linspace(1e-4, 9 * np.sqrt(square), 1500)  # largest x of an orbit
    x = A[:, None] * np.sin((np.arange(200) + 0.5) / 200 * np.pi / 2)
    slowness = 1 / np.sqrt(1 + cubic * (A[:, None] ** 2 + x**2) / 2)
    period = 2 * np.pi * slowness.mean(axis=1)
    orbit = (x**2 * slowness).mean(axis=1) / slowness.mean(axis=1)
    T = (2 * np.pi / period / np.sqrt(1 + 3 * cubic * square)) ** -p
    dE = np.gradient(A**2 / 2 + cubic * A**4 / 4)
    density = period / T * np.exp(-np.cumsum(dE / T)) * dE
    share = 1 - 1 / (1 + 3 * cubic * square)
    return share, np.sqrt((density @ orbit) / density.sum() / square) - 1


@pytest.mark.parametrize("cubic", [0.02, 0.2, 1.0, 3.0])
@pytest.mark.parametrize("p", [-1.0, 1.0])
def test_a_load_that_falls_with_frequency_moves_a_mode_by_the_stated_part(cubic, p):
    share, excess = averaged_excess(cubic, p)
    _, white = averaged_excess(cubic, 0.0)
    assert white == pytest.approx(float(duffing_excess(np.array(share))), abs=2e-3)
    assert (excess - white) == pytest.approx(SLOPE * share * p, rel=0.15)


def test_a_stiffness_that_does_not_settle_is_an_error():
    jumps = itertools.cycle([1.0, 100.0])
    with pytest.raises(LinearisationError, match="has not settled"):
        linearised_stiffness(np.ones((1, 1, 1, 1)), lambda _: np.full((1, 1), next(jumps)))


# ------------------------------------------------------------------ a panel with a damper

N = 6
MODES = np.array([0, 1, 2])
FREQUENCY = np.array([40.0, 70.0, 95.0, 130.0, 180.0, 260.0])


def panel_of(lines):
    rng = np.random.default_rng(11)
    rows = rng.normal(size=(1, 8, N)) * 0.1
    points = rng.normal(size=(2, N))
    basis = ModalBasis(FREQUENCY, np.full(N, 1.5), 0.02)
    return ModalPanel(basis, Patches.of_rows(rows, [0.04]), lines, points, lines)


def force_of():
    half = np.random.default_rng(12).normal(size=(N, N))
    return ModalForce(np.ones_like, half @ half.T)


LINES = frequency_grid(20.0, 400.0, 0.02, lines_per_bandwidth=6)
TENSOR = energy_tensor(3, 2e5, np.random.default_rng(2))


def dense(panel, force, layout, gamma, K):
    """Mean squares of w and acceleration at the points and of the patch, all shapes at once."""
    w = 2 * np.pi * LINES
    Z = panel.basis.dynamic_stiffness(LINES)[:, :, None] * np.eye(N) + K
    for damper in layout.dampers:
        value, mass, _ = damper.damping(LINES, gamma)
        Z = Z + (1j * w * value - w**2 * mass)[:, None, None] * panel.patches.overlap[0]
    H = np.linalg.inv(Z)
    S = layout.factor * (H @ force(LINES) @ H.conj().swapaxes(1, 2)).real
    C = np.trapezoid(S, LINES, axis=0)
    Ca = np.trapezoid(w[:, None, None] ** 4 * S, LINES, axis=0)
    points = panel.points[:, 0]
    at = [np.sqrt(np.einsum("pi,ij,pj->p", points, part, points)) for part in (C, Ca)]
    patch = np.sqrt(np.sum(panel.patches.overlap[0] * Ca) / panel.patches.area[0])
    return C, at, np.sqrt(2) * patch / STANDARD_GRAVITY


def damping_of(frequency, gamma):
    ones = np.ones_like(frequency)
    return 300.0 * ones / np.sqrt(gamma), 2.0 * ones, np.ones(frequency.shape, bool)


@pytest.mark.parametrize("is_damped", [False, True])
def test_a_panel_that_stretches_is_that_of_all_shapes_with_its_stiffness(is_damped):
    panel, force = panel_of(LINES), force_of()
    layout = DamperLayout([AttachedDamper(0, damping_of)] if is_damped else [], 4e4)
    solver = PanelSolver(panel, force)
    (linear,) = solve_with(solver, [layout])
    cases = [(layout, linear.acceleration_g)]
    (answer,) = stretched_responses(solver, Stretching(MODES, TENSOR), cases)
    gamma = answer.acceleration_g[0] if is_damped else np.nan

    def with_stiffness(K):
        full = np.zeros((N, N))
        full[:3, :3] = K
        return dense(panel, force, layout, gamma, full)

    K = linearised_stiffness(TENSOR, lambda K: with_stiffness(K)[0][:3, :3])
    _, (w, a), patch = with_stiffness(K)
    linear_gamma = linear.acceleration_g[0] if is_damped else np.nan
    _, (w0, a0), _ = dense(panel, force, layout, linear_gamma, np.zeros((N, N)))
    np.testing.assert_allclose(answer.displacement, w / w0, rtol=2e-4)
    np.testing.assert_allclose(answer.acceleration, a / a0, rtol=2e-4)
    assert (answer.displacement_error > 0.002).all()
    share = K[0, 0] / (K[0, 0] + 1.5 * (2 * np.pi * 40.0) ** 2)
    assert 0.1 < share < 0.9 and (w < 0.97 * w0).all()
    if is_damped:
        assert patch == pytest.approx(gamma, rel=0.012)
        assert abs(np.log(gamma / linear_gamma)) > 0.02


def test_a_panel_that_hardly_moves_is_linear():
    # K ∝ mean square of the motion, so the change too
    solver = PanelSolver(panel_of(LINES), force_of())
    changes = []
    for factor in (1.0, 10.0):
        case = DamperLayout((), factor), np.zeros(0)
        (answer,) = stretched_responses(solver, Stretching(MODES, TENSOR), [case])
        changes.append([answer.frequency - 1, *(answer.displacement - 1)])
    assert np.abs(changes[0]).max() < 1e-3
    np.testing.assert_allclose(changes[1], 10 * np.array(changes[0]), rtol=0.05)
