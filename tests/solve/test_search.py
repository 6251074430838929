"""The motions of several patches at which all reproduce themselves: sets of Γ with closed forms."""

import math

import numpy as np
import pytest
from solving import panel_solver, solve_layout

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.solve.layout import AttachedDamper
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.search import (
    LinearisationError,
    NotConverged,
    Solution,
    approach,
    find_motions,
    governing,
    iterate,
    starts_between,
)

LOW, HIGH = np.log(0.1), np.log(1e4)


def starts(n):
    return starts_between(np.full(n, LOW), np.full(n, HIGH))


@pytest.mark.parametrize("n", [1, 2, 40])
def test_coupled_power_laws_meet_where_linear_algebra_says(n):
    # Γ_out,i = e^a_i Π_j Γ_j^−B_ij, straight in ln Γ: x = (1 + B)⁻¹ a
    draw = np.random.default_rng(n)
    B = np.diag(draw.uniform(-0.3, 1.2, n)) + draw.uniform(-0.2, 0.2, (n, n)) / math.sqrt(n)
    a = draw.uniform(2, 5, n)
    solutions = find_motions([lambda x: a - B @ x], starts(n))
    expected = np.linalg.solve(np.eye(n) + B, a)
    assert len(solutions) == 1
    # |F(x) − x| ≤ 1e-6 leaves at most that over the least singular value of 1 + B
    room = 1e-6 * math.sqrt(n) / np.linalg.svd(np.eye(n) + B, compute_uv=False).min()
    np.testing.assert_allclose(governing(solutions).log_gamma, expected, atol=room)
    assert governing(solutions).residual <= 1e-6
    # F is ∓B here: all eigenvalues of −B lie below 1
    assert governing(solutions).stable


def peaked(gamma):
    """Damping that rises steeply to Γ = 2.5 and falls like 1/Γ^2.5 beyond: three Γ = 60/C."""
    return 0.2 + 100 / ((2.5 / gamma) ** 4 + (gamma / 2.5) ** 2.5)


def crossings():
    gamma = np.geomspace(0.01, 1000, 400_001)
    above = 60 / peaked(gamma) > gamma
    at = np.flatnonzero(above[1:] != above[:-1])
    return np.log(np.sqrt(gamma[at] * gamma[at + 1]))


def test_two_loads_with_three_motions_each_have_their_four_stable_pairs_and_the_highest_governs():
    # uncoupled, so that each load alone has low, middle (unstable) and high, found by a fine scan
    low, _, high = crossings()
    solutions = find_motions([lambda x: np.log(60 / peaked(np.exp(x)))], starts(2))
    found = {tuple(np.round(one.log_gamma, 3)) for one in solutions if one.stable}
    expected = {(a, b) for a in (low, high) for b in (low, high)}
    assert found == {tuple(np.round(pair, 3)) for pair in expected}
    np.testing.assert_allclose(governing(solutions).log_gamma, [high, high], atol=1e-4)


@pytest.mark.parametrize(("slope", "cubic"), [(1.7, 0.25), (1.2, 0.05)])
def test_a_repelling_motion_is_told_from_one_that_attracts(slope, cubic):
    # x → s x − c x³ away from 0: F' = s at 0, 3 − 2s at the others; the first is repelling
    other = math.sqrt((slope - 1) / cubic)
    solutions = find_motions(
        [lambda x: slope * x - cubic * x**3], [np.array([0.0]), np.array([1.5])], tolerance=1e-9
    )
    stable = {round(float(one.log_gamma[0]), 4): one.stable for one in solutions}
    assert stable == {0.0: False, round(other, 4): True}
    assert governing(solutions).log_gamma[0] == pytest.approx(other)


def test_a_motion_that_repels_one_load_of_two_is_not_stable():
    solutions = find_motions(
        [lambda x: np.array([1.7 * x[0] - 0.25 * x[0] ** 3, 0.5 * x[1]])],
        [np.array([0.0, 1.0]), np.array([1.5, 1.0])],
    )
    assert [one.stable for one in solutions] == [False, True]


def test_few_lines_lead_to_the_motion_of_all_lines():
    # F on all lines, 3 % and 10 % off on fewer
    asked = []
    B = np.array([[0.5, 0.1], [0.2, -0.3]])

    def whole(x):
        asked.append(x)
        return np.array([3.0, 2.0]) - B @ x + 0.02 * np.sin(x)

    maps = [whole, lambda x: np.array([3.03, 2.0]) - B @ x, lambda x: [3.1, 1.9] - 1.1 * B @ x]
    solutions = find_motions(maps, starts(2))
    assert len(solutions) == 1
    x = governing(solutions).log_gamma
    assert np.max(np.abs(whole(x) - x)) <= 1e-6
    assert len(asked) < 8  # a search of its own takes twenty


def test_a_jump_of_the_damping_is_not_taken_for_a_motion():
    # one load's Γ_out falls from 20 to 0.2 at Γ = 5, so none reproduces itself
    def jump(x):
        return np.array([math.log(20.0 if x[0] < math.log(5) else 0.2), 1.0])

    for maps in ([jump], [jump, jump]):
        with pytest.raises(NotConverged, match=r"of 2 loads is .* from each of 4 starts, more"):
            find_motions(maps, starts(2))


@pytest.mark.parametrize("slope", [-0.9, -3.0, 0.95])
def test_steep_maps_are_followed(slope):
    # plain iteration contracts by 0.9 and 0.95 a step or runs away with −3
    x, residual = iterate(lambda x: slope * (x - 1.5) + 1.5, np.array([4.0]), 1e-9)
    assert residual <= 1e-9
    assert x[0] == pytest.approx(1.5, abs=1e-7)


def test_one_mode_with_a_dashpot_that_grows_with_level_moves_as_miles_says():
    # white noise on one mode with c = 2ζmω + C_e A, C_e = 40 Γ: closed form of the mean square of
    # a Lorentzian of acceleration, S ω²/(4 c m), cut to ±10 Hz by its arctangent. What is left is
    # the slope of ω⁴ over the band, 0.2 % of Γ; 0.4 % is allowed
    mass, area, slope, force_psd, omega = 2.0, 0.1, 40.0, 300.0, 2 * np.pi * 100.0
    frequency = frequency_grid(90.0, 110.0, 0.01, lines_per_bandwidth=40)
    patches = Patches(np.array([[[area]]]), np.array([area]))
    basis = ModalBasis([100.0], [mass], 0.01)
    solver = panel_solver(basis, patches, frequency, [[1.0]], np.array([[force_psd]]))
    (gamma,) = solve_layout(
        solver, [AttachedDamper(0, lambda f, gamma: (0 * f + slope * gamma, 0 * f, f > 0))]
    ).acceleration_g
    damping = 2 * 0.01 * mass * omega + slope * gamma * area
    half_width = damping / (2 * mass) / (2 * np.pi)
    inside = np.arctan(10 / half_width) / (np.pi / 2)
    rms = math.sqrt(force_psd * omega**2 / (4 * damping * mass) * inside)
    assert math.sqrt(2) * rms / STANDARD_GRAVITY == pytest.approx(gamma, rel=0.004)


def test_a_motion_that_is_no_motion_is_refused():
    lines, patches = np.array([50.0, 60.0]), Patches(np.array([[[0.1]]]), np.array([0.1]))
    solver = panel_solver(ModalBasis([55.0], [1.0], 0.01), patches, lines, [[1.0]], np.eye(1))
    with pytest.raises(LinearisationError, match="finite, positive motion"):
        solve_layout(solver, [AttachedDamper(0, lambda f, _gamma: (0 * f, 0 * f + np.inf, f > 0))])


@pytest.mark.parametrize(
    ("stable", "expected"), [((True, False), 1.0), ((False, False), 2.0), ((True, True), 2.0)]
)
def test_the_highest_stable_motion_governs_and_the_highest_where_none_is_stable(stable, expected):
    solutions = [
        Solution(np.array([x]), 0.0, one) for x, one in zip((1.0, 2.0), stable, strict=True)
    ]
    assert governing(solutions).log_gamma == [expected]


def test_the_second_step_of_an_approach_ends_at_the_zero_of_a_straight_line():
    # F = −0.8 x from 0.3: the plain step goes to −0.24, the secant from there to 0
    tried = []

    def straight(x):
        tried.append(x)
        return -0.8 * x

    x = approach(straight, np.array([0.3, -0.4]))
    np.testing.assert_allclose(x, 0.0, atol=1e-15)
    assert len(tried) == 3


def recorded(F):
    """A map and the points at which it is evaluated."""
    tried = []

    def remembering(x):
        tried.append(x)
        return F(x)

    return remembering, tried


def test_six_coupled_straight_lines_meet_in_eight_evaluations():
    # a step for every direction, one to begin with and one that ends
    B = np.random.default_rng(8).uniform(-0.4, 0.4, (6, 6))
    F, tried = recorded(lambda x: np.arange(6) - B @ x)
    x, _ = iterate(F, np.zeros(6), 1e-8)
    np.testing.assert_allclose(x, np.linalg.solve(np.eye(6) + B, np.arange(6)), atol=1e-7)
    assert len(tried) <= 8
