"""Constants of the paper's form: found from noisy data, with intervals that hold what they say."""

import numpy as np
import pytest

from pidpanel.damping import fit
from pidpanel.damping.laws import equation_5

FREQUENCY = np.array([30.0, 80.0, 250.0, 700.0, 2000.0])
FILLS = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
DRAWS = 4000
"""The share of 4000 intervals that hold the truth has a standard error of 0.34 %: 93 to 97 % is
six of them to either side."""


def covered(estimate, true):
    return ((estimate.low <= true) & (true <= estimate.high)).mean(axis=0)


def test_data_without_noise_give_the_constants_back():
    damping = equation_5(2 * np.pi * FREQUENCY, 2e-3, 1.9, 1e-4)
    found = fit.fit_at_fill(FREQUENCY, damping, np.ones(5))
    np.testing.assert_allclose(found.value, [np.log(2e-3), 1.9, 1e-4], rtol=1e-9)


def test_at_one_fill_95_percent_of_the_intervals_hold_the_constants():
    # five values, three constants: two degrees of freedom, where a normal interval holds 81 %
    rng = np.random.default_rng(0)
    error = np.array([0.02, 0.1, 0.05, 0.05, 0.2])
    clean = equation_5(2 * np.pi * FREQUENCY, 2e-3, 1.9, 1e-4)
    noisy = clean * np.exp(error * rng.normal(size=(DRAWS, 5)))
    found = fit.fit_at_fill(FREQUENCY, noisy, error)
    share = covered(found, [np.log(2e-3), 1.9, 1e-4])
    assert ((share > 0.93) & (share < 0.97)).all(), share


TRUE = np.array([np.log(2e-2), 1.5, -0.8, 2.1, -0.4, 2e-4, -1e-4])


@pytest.fixture(scope="module")
def sweep():
    r, f = (g.ravel() for g in np.meshgrid(FILLS, FREQUENCY, indexing="ij"))
    a1, a2, a3 = fit.constants_at(r, TRUE)
    return f, r, equation_5(2 * np.pi * f, a1, a2, a3)


def test_over_fill_data_without_noise_give_the_constants_back(sweep):
    f, r, damping = sweep
    found = fit.fit_over_fill(f, r, damping, np.ones(25))
    np.testing.assert_allclose(found.value, TRUE, rtol=1e-6)


def test_over_fill_95_percent_of_the_intervals_hold_the_constants(sweep):
    # linearised intervals: with 5 % of noise the curvature of the problem does not show
    f, r, damping = sweep
    rng = np.random.default_rng(1)
    error = 0.05 * np.where(f > 500, 2.0, 1.0)
    noisy = damping * np.exp(error * rng.normal(size=(DRAWS, 25)))
    found = fit.fit_over_fill(f, r, noisy, error)
    share = covered(found, TRUE)
    assert ((share > 0.93) & (share < 0.97)).all(), share


def test_the_intervals_over_fill_are_those_of_a_general_solver(sweep):
    from scipy.optimize import curve_fit

    f, r, damping = sweep
    noisy = damping * np.exp(0.05 * np.random.default_rng(3).normal(size=25))

    def log_law(_, *constants):
        a1, a2, a3 = fit.constants_at(r, np.array(constants))
        return np.log(equation_5(2 * np.pi * f, a1, a2, a3))

    value, covariance = curve_fit(
        log_law, f, np.log(noisy), p0=TRUE, method="trf", x_scale=np.abs(TRUE)
    )
    found = fit.fit_over_fill(f, r, noisy, np.ones(25))
    np.testing.assert_allclose(found.value, value, rtol=1e-3)
    half = 2.1009 * np.sqrt(np.diag(covariance))  # Student, 18 degrees of freedom, tables
    np.testing.assert_allclose((found.high - found.low) / 2, half, rtol=5e-3)


def test_the_scatter_is_that_of_the_data(sweep):
    f, r, damping = sweep
    noisy = damping * np.exp(0.2 * np.random.default_rng(5).normal(size=(500, 25)))
    found = fit.fit_over_fill(f, r, noisy, np.ones(25))
    # mean of 500 variances of 18 degrees of freedom: 1.5 % of its own error
    assert np.mean(found.scatter**2) == pytest.approx(0.04, rel=0.05)


def test_too_few_points_are_refused():
    with pytest.raises(ValueError, match="3 frequencies"):
        fit.fit_at_fill(FREQUENCY[:3], np.ones(3), np.ones(3))
    with pytest.raises(ValueError, match="10 points, 2 fills, 5 frequencies"):
        fit.fit_over_fill(np.tile(FREQUENCY, 2), np.repeat([0.1, 0.5], 5), np.ones(10), np.ones(10))
