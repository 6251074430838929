"""The trend of beds that ride."""

import numpy as np
import pytest
from atlas_fit import TREND_START, fit_riding

from pidpanel.damping.atlas import riding_trend
from pidpanel.damping.inelastic import slug

# ln A … w that no search starts from
CONSTANTS = np.array([0.3, 0.25, 0.95, 0.2, -0.7, 0.6, 0.1, 1.3, -1.1, -0.5, 1.6])


def coordinates(groups):
    """Of r, ln Γ, ln(Γ W/L), ln N(1 − e²), ln μ, ln(width/d), ln N, upright, (n, 8)."""
    fill, gamma, _, loss, _, width, layers, _ = groups.T
    result = groups.copy()
    result[:, 4] += layers - np.log(fill) - width
    return np.column_stack([result, gamma - loss])


def points(count):
    rng = np.random.default_rng(3)
    low = np.log([1.0, 1.5, 1e-4, 0.3, 0.05, 2.0, 0.5, 1.0])
    high = np.log([1.0, 700.0, 50.0, 15.0, 0.8, 10.0, 30.0, 1.0])
    result = rng.uniform(low, high, (count, 8))
    result[:, 0], result[:, 7] = rng.uniform(0.05, 0.95, count), rng.integers(0, 2, count)
    return coordinates(result)


def trend(groups):
    return riding_trend(CONSTANTS, coordinates(groups))


def test_a_gas_loses_no_more_than_the_body_that_crosses():
    # few elastic particles at L = πW: 4 m A²ω² is the most.
    gas = np.array([[0.1, np.log(7000), np.log(7000 / np.pi), -4, -1, 1, 0.0, 0.0]])
    np.testing.assert_allclose(trend(gas), np.log(8), atol=0.1)


def test_a_search_finds_the_constants_in_spite_of_outliers():
    where = points(400)
    values = riding_trend(CONSTANTS, where)
    values[::20] += 2.0
    found = fit_riding(where, values, np.full(400, 0.05))
    np.testing.assert_allclose(found, CONSTANTS, atol=0.12)
    alone = fit_riding(where[where[:, 7] == 0], riding_trend(CONSTANTS, where[where[:, 7] == 0]),
                       np.full((where[:, 7] == 0).sum(), 0.05))  # fmt: skip
    np.testing.assert_allclose(alone[4:6], TREND_START[4:6], atol=1e-6)


@pytest.mark.parametrize("upright", [0, 1])
@pytest.mark.parametrize("constants", [CONSTANTS, 0.4 - CONSTANTS])
def test_the_loss_is_that_of_the_thrown_bed_and_of_the_gas(constants, upright):
    # the formula with powers in place of logarithms
    fill, gamma, gap, elastic, friction, width, layers = 0.3, 4.0, 3.0, 0.7, 0.2, 5.0, 2.6
    log_a, p, q, k, across, k_across, log_b, s, t, v, w = constants
    thrown = np.exp(log_a) * layers**p * gamma**-q * friction**k
    thrown *= (np.exp(across) * friction**k_across) ** upright
    gas = np.exp(log_b + w * fill) * gap**-s * (layers * elastic) ** t * layers**v
    gas = 1 / (1 / gas + np.pi / slug(np.array([gap]))[0])
    groups = [fill, *np.log([gamma, gamma / gap, layers * elastic, friction, width, layers])]
    values = riding_trend(constants, coordinates(np.array([[*groups, upright]])))
    np.testing.assert_allclose(values, np.log(2 * np.pi * (thrown + gas)), rtol=1e-12)


def test_without_cases_a_thrown_bed_loses_by_its_drive_and_a_gas_by_its_collisions():
    # η = Γ^−0.9, across √μ of it, and N(1 − e²) of the gas
    constants = fit_riding(np.empty((0, 9)), np.empty(0), np.empty(0))
    np.testing.assert_allclose(constants[[2, 5, 7]], [0.9, 0.5, 1.0], atol=1e-6)
    others = np.delete(constants, [2, 5, 7])
    np.testing.assert_allclose(others, 0.0, atol=1e-6)
