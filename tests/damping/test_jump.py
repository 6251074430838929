"""Where beds begin to cross the gap: as sure as the cases make it, never where they cannot."""

import numpy as np
import pytest
import scipy

from pidpanel.damping import jump as module
from pidpanel.damping.jump import CENTRE, LENGTHS, SIZE, WIDTH, Jump, reach

R, GAMMA = 0.5, np.log(60.0)


def jump(*cases):
    """Of (r, ln Γ, u, crosses)."""
    r, gamma, reached, crosses = (np.array(v) for v in zip(*cases, strict=True))
    return Jump(np.column_stack([r, gamma]), reached, crosses.astype(float))


def matern(distance):
    a = np.sqrt(5) * distance
    return (1 + a + a**2 / 3) * np.exp(-a)


def test_a_bed_that_is_not_thrown_up_to_the_lid_never_crosses():
    # thrown at ωW it rises by WΓ/2, in units of the gap Γ(W/L)/2
    stroke, gamma = np.array([0.3, 0.3]), np.array([6.6, 6.8])
    found = reach(np.log(stroke), np.log(gamma), 1.0)
    assert np.isinf(found[0]) and np.isfinite(found[1])
    left = np.sqrt(1 - 2 / (0.3 * 6.8))  # speed at the lid over ωW
    assert found[1] == pytest.approx(np.log(0.3 * left))
    assert reach(np.log(0.3), np.log(1.0), 0.0) == pytest.approx(np.log(0.3))
    cases = [(R, GAMMA, CENTRE + 0.1, 1), (R, GAMMA, CENTRE - 0.1, 0)]
    assert (jump(*cases).probability(np.full((1, 2), R), found[:1]) == 0).all()


def test_without_cases_that_tell_it_lies_where_the_closed_form_has_it():
    none = Jump(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    u = CENTRE + SIZE * np.array([-1.0, 0.0, 2.0])
    found = none.probability(np.full((3, 2), R), u)
    np.testing.assert_allclose(found, scipy.stats.norm.cdf((u - CENTRE) / np.hypot(SIZE, WIDTH)))


@pytest.mark.parametrize(
    ("away", "crosses"), [(0.1, True), (-0.4, False), (0.3, False), (1.0, True)]
)
def test_one_case_moves_it_as_the_integral_over_all_jumps_says(away, crosses):
    # P(u > τ | case) by quadrature over τ at the case and the normal of τ elsewhere given it; for
    # one case the method is exact at the case itself and the normal that stands for it elsewhere
    case, other = np.array([R, GAMMA]), np.array([R + 0.1, GAMMA + 0.4])
    found = Jump(case[None], np.array([CENTRE + away]), np.array([float(crosses)]))
    tau = np.linspace(-6 * SIZE, 6 * SIZE, 40001)
    weight = scipy.stats.norm.pdf(tau, scale=SIZE)
    weight *= scipy.stats.norm.cdf((1 if crosses else -1) * (away - tau) / WIDTH)
    weight /= weight.sum()
    mean, variance = tau @ weight, (tau**2) @ weight - (tau @ weight) ** 2
    share = matern(np.linalg.norm((other - case) / LENGTHS))
    there_mean = share * mean
    there_variance = SIZE**2 * (1 - share**2) + share**2 * variance
    u = CENTRE + np.array([-0.3, 0.0, 0.25])
    expected = scipy.stats.norm.cdf((u - CENTRE - there_mean) / np.sqrt(WIDTH**2 + there_variance))
    np.testing.assert_allclose(found.probability(np.tile(other, (3, 1)), u), expected, atol=1e-6)


def test_many_cases_agree_with_draws_of_the_jump():
    # draws of τ at the cases and at a further point, kept with the probability of all the sides;
    # 3 standard errors of the draws and 0.03 for the normal that stands for what is kept
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(0.2, 0.8, 6), rng.uniform(3, 5, 6)])
    away = np.array([-0.3, -0.1, 0.05, 0.2, 0.3, -0.2])
    crosses = np.array([False, False, True, True, False, False])
    at = np.vstack([points, [[0.5, 4.0]]])
    distance = np.linalg.norm((at[:, None] - at[None]) / LENGTHS, axis=2)
    tau = rng.multivariate_normal(np.zeros(7), SIZE**2 * matern(distance), 400_000)
    weight = scipy.stats.norm.cdf(np.where(crosses, 1, -1) * (away - tau[:, :6]) / WIDTH).prod(
        axis=1
    )
    found = Jump(points, CENTRE + away, crosses.astype(float))
    for u in (-0.1, 0.1, 0.3):
        expected = (weight * scipy.stats.norm.cdf((u - tau[:, 6]) / WIDTH)).sum() / weight.sum()
        got = found.probability(at[6:], np.array([CENTRE + u]))[0]
        kept = weight.sum() ** 2 / (weight**2).sum()
        assert got == pytest.approx(expected, abs=0.03 + 1.5 / np.sqrt(kept))


def test_a_case_left_out_is_judged_by_the_others_alone():
    cases = [(R, GAMMA, CENTRE - 0.2, 0), (R, GAMMA, CENTRE + 0.1, 1), (R, GAMMA, CENTRE + 9, 1)]
    found = jump(*cases)
    for i in range(3):
        others = jump(*(case for j, case in enumerate(cases) if j != i))
        alone = others.probability(np.array([[R, GAMMA]]), np.array([cases[i][2]]))
        assert found.leave_one_out()[i] == pytest.approx(alone[0])


def test_a_case_between_has_the_jump_where_it_is():
    # on both sides of it at once
    found = jump((R, GAMMA, CENTRE + 0.2, 0.5))
    u = CENTRE + 0.2 + 3 * WIDTH * np.array([-1.0, 0.0, 1.0])
    p = found.probability(np.tile([R, GAMMA], (3, 1)), u)
    assert p[0] < 0.1 and p[1] == pytest.approx(0.5, abs=0.03) and p[2] > 0.9


def test_in_a_sweep_a_case_is_judged_by_what_those_before_it_have_told(monkeypatch):
    # two steps from normal to normal, each with the moments of its product by quadrature
    monkeypatch.setattr(module, "SWEEPS", 1)
    points = np.array([[R, GAMMA], [R + 0.1, GAMMA + 0.4]])
    away, sign = np.array([0.1, 0.3]), np.array([-1, 1])  # one rides, then one crosses
    distance = np.linalg.norm((points[:, None] - points) / LENGTHS, axis=2)
    mean, covariance = np.zeros(2), SIZE**2 * matern(distance)
    for i in range(2):
        sd = np.sqrt(covariance[i, i])
        tau = mean[i] + sd * np.linspace(-8, 8, 40001)
        weight = scipy.stats.norm.pdf(tau, mean[i], sd)
        weight *= scipy.stats.norm.cdf(sign[i] * (away[i] - tau) / WIDTH)
        weight /= weight.sum()
        share, centre = covariance[:, i] / sd**2, tau @ weight
        mean = mean + share * (centre - mean[i])
        covariance += np.outer(share, share) * (weight @ (tau - centre) ** 2 - sd**2)
    found = Jump(points, CENTRE + away, np.array([0.0, 1.0]))
    expected = scipy.stats.norm.cdf(-mean / np.sqrt(WIDTH**2 + np.diag(covariance)))
    np.testing.assert_allclose(found.probability(points, np.full(2, CENTRE)), expected, rtol=1e-5)
