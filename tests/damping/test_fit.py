"""Constants of the paper's form: found from noisy data, with intervals that hold what they say."""

import numpy as np
import pytest

from pidpanel.damping import fit
from pidpanel.damping.laws import equation_5

FREQUENCY = np.array([30.0, 80.0, 250.0, 700.0, 2000.0])
FILLS = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
DRAWS = 2000
"""The share of 2000 intervals that hold the truth has a standard error of 0.5 %: 93 to 97 % is
four of them to either side."""


def covered(fitted, true):
    return np.mean([(one.low <= true) & (true <= one.high) for one in fitted], axis=0)


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
    fitted = [fit.fit_at_fill(FREQUENCY, values, error) for values in noisy]
    share = covered(fitted, [np.log(2e-3), 1.9, 1e-4])
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
    noisy = damping * np.exp(0.2 * np.random.default_rng(5).normal(size=(250, 25)))
    scatter = [fit.fit_over_fill(f, r, values, np.ones(25)).scatter for values in noisy]
    # mean of 250 variances of 18 degrees of freedom: 2.1 % of its own error
    assert np.mean(np.square(scatter)) == pytest.approx(0.04, rel=0.05)


def test_too_few_points_are_refused():
    with pytest.raises(ValueError, match="3 frequencies"):
        fit.fit_at_fill(FREQUENCY[:3], np.ones(3), np.ones(3))
    with pytest.raises(ValueError, match="10 points, 2 fills, 5 frequencies"):
        fit.fit_over_fill(np.tile(FREQUENCY, 2), np.repeat([0.1, 0.5], 5), np.ones(10), np.ones(10))


SIX_FREQUENCIES = np.array([30.0, 80.0, 250.0, 700.0, 1100.0, 2000.0])
ERROR = np.array([0.02, 0.1, 0.05, 0.05, 0.2, 0.3])
NOISE = np.array([0.3, -1.2, 0.8, 0.1, -0.9, 1.4])


def fields(estimate):
    return np.concatenate([estimate.value, estimate.low, estimate.high, [estimate.scatter]])


def test_errors_in_another_unit_change_nothing():
    damping = equation_5(2 * np.pi * SIX_FREQUENCIES, 2e-3, 1.9, 1e-4) * np.exp(ERROR * NOISE)
    one, other = (fields(fit.fit_at_fill(SIX_FREQUENCIES, damping, u * ERROR)) for u in (1, 7))
    np.testing.assert_allclose(other, one, rtol=1e-9)


def test_where_one_error_is_unknown_all_count_alike():
    damping = equation_5(2 * np.pi * SIX_FREQUENCIES, 2e-3, 1.9, 1e-4) * np.exp(ERROR * NOISE)
    unknown = fit.fit_at_fill(SIX_FREQUENCIES, damping, np.where(ERROR == 0.02, 0.0, ERROR))
    alike = fit.fit_at_fill(SIX_FREQUENCIES, damping, np.ones(6))
    np.testing.assert_array_equal(fields(unknown), fields(alike))


def test_the_scatter_is_that_of_a_value_of_average_weight():
    # weighted least squares by numpy, with weights of mean square 1: s² = Σ(w e)²/(n − 3)
    damping = equation_5(2 * np.pi * SIX_FREQUENCIES, 2e-3, 1.9, 1e-4) * np.exp(ERROR * NOISE)
    omega = 2 * np.pi * SIX_FREQUENCIES
    weight = (1 / ERROR) / np.sqrt(np.mean(1 / ERROR**2))
    design = np.stack([np.ones(6), np.log(omega), -omega / 1e4], axis=1) * weight[:, None]
    _, (left,), *_ = np.linalg.lstsq(design, np.log(2 * np.pi * damping * omega) * weight)
    found = fit.fit_at_fill(SIX_FREQUENCIES, damping, ERROR)
    assert found.scatter == pytest.approx(np.sqrt(left / 3), rel=1e-6)


def test_data_that_ask_for_a_negative_factor_are_fitted_as_well_as_they_can_be():
    # C_e vanishes towards full: the full step from the start leaves a₁ > 0
    true = np.array([np.log(2e-2), 3.0, -4.1, 2.1, -0.4, 2e-4, -1e-4])
    r, f = (
        g.ravel() for g in np.meshgrid(np.linspace(0.05, 0.97, 8), SIX_FREQUENCIES, indexing="ij")
    )
    damping = equation_5(2 * np.pi * f, *fit.constants_at(r, true))
    assert (damping > 0).all()
    found = fit.fit_over_fill(f, r, damping, np.ones(r.size))
    np.testing.assert_allclose(found.value, true, rtol=1e-5)
