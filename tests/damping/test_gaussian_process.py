"""Gaussian process regression against the formulas it rests on."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from pidpanel.damping.gaussian_process import MEAN_SD, GaussianProcess, fit, spreads

RNG = np.random.default_rng(4)
POINTS = RNG.uniform(0, 1, (12, 2))
VALUES = np.sin(5 * POINTS[:, 0]) + POINTS[:, 1]
ERROR = RNG.uniform(0.02, 0.2, 12)
LENGTHS = np.array([0.6, 1.3])
PROCESS = GaussianProcess(POINTS, VALUES, ERROR, LENGTHS, size=0.9, scatter=0.05)


def kernel(x, y):
    """Matérn 5/2 with the constant of the mean, by scipy's distances."""
    a = np.sqrt(5) * cdist(x / LENGTHS, y / LENGTHS)
    return (MEAN_SD * VALUES.std()) ** 2 + 0.81 * (1 + a + a**2 / 3) * np.exp(-a)


def conditional(points, values, error, at):
    """Mean and covariance of a Gaussian vector, given others, by the textbook formula."""
    inverse = np.linalg.inv(kernel(points, points) + np.diag(error**2 + 0.05**2))
    cross = kernel(at, points)
    centre = VALUES.mean()
    mean = centre + cross @ inverse @ (values - centre)
    return mean, kernel(at, at) - cross @ inverse @ cross.T


def test_the_posterior_is_the_conditional_of_a_gaussian_vector():
    at = RNG.uniform(-0.5, 1.5, (7, 2))
    mean, covariance = conditional(POINTS, VALUES, ERROR, at)
    np.testing.assert_allclose(PROCESS.mean(at), mean, atol=1e-9)
    np.testing.assert_allclose(PROCESS.covariance(at), covariance, atol=1e-9)
    np.testing.assert_allclose(PROCESS.standard_error(at), np.sqrt(np.diag(covariance)), atol=1e-7)


def test_leaving_one_out_is_asking_without_it():
    error, expected = PROCESS.leave_one_out()
    for i in range(len(VALUES)):
        rest = np.arange(len(VALUES)) != i
        mean, covariance = conditional(POINTS[rest], VALUES[rest], ERROR[rest], POINTS[i : i + 1])
        assert error[i] == pytest.approx(mean[0] - VALUES[i], abs=1e-9)
        scatter = covariance[0, 0] + ERROR[i] ** 2 + 0.05**2
        assert expected[i] == pytest.approx(np.sqrt(scatter), rel=1e-8)


@pytest.mark.slow
def test_functions_drawn_from_a_process_lie_within_the_errors_foretold():
    # 40 functions of known smoothness, constants fitted anew to 40 noisy values of each: of the
    # 2000 values between them 95 % lie within 1.96 standard errors; 93 to 97 % leaves room for
    # their being correlated within a function
    rng = np.random.default_rng(1)
    hits = []
    for _ in range(40):
        x = rng.uniform(0, 10, 90)[:, None]
        a = np.sqrt(5) * cdist(x, x) / 2.0
        true = np.linalg.cholesky((1 + a + a**2 / 3) * np.exp(-a) + 1e-10 * np.eye(90)) @ (
            rng.normal(size=90)
        )
        seen, error = true[:40] + 0.1 * rng.normal(size=40), np.full(40, 0.1)
        found = fit(x[:40], seen, error)
        z = (found.mean(x[40:]) - true[40:]) / found.standard_error(x[40:])
        hits += list(np.abs(z) < 1.96)
    assert 0.93 < np.mean(hits) < 0.97


def test_scatter_beyond_the_stated_errors_is_found():
    rng = np.random.default_rng(2)
    x = np.linspace(0, 10, 200)[:, None]
    seen = np.sin(x[:, 0]) + 0.3 * rng.normal(size=200)
    # the standard error of a standard deviation of 200 values is 5 %
    assert fit(x, seen, np.full(200, 0.01)).scatter == pytest.approx(0.3, rel=0.15)


PLANE_RNG = np.random.default_rng(14)
PLANE_POINTS = PLANE_RNG.uniform(0, 1, (16, 2)) * [3.0, 40.0]
PLANE_ERROR = PLANE_RNG.uniform(0.1, 0.4, 16)
PLANE_VALUES = (
    7 + 5 * np.sin(PLANE_POINTS[:, 0]) + 0.03 * PLANE_POINTS[:, 1] + 1.5 * PLANE_RNG.normal(size=16)
)


def minus_log_posterior(logs, points, values, error):
    """Of ln l/sd(x), ln s/sd(y), ln t/sd(y): Gaussian values, log-normal priors, by scipy.

    Medians and widths as stated for the priors: l 1.5 and a factor e, s 1.5 and e^0.7, t 0.03
    and e^1.5; m = 3 standard deviations.
    """
    (*lengths, size, scatter) = np.exp(logs)
    unit = values.std()
    x = points / points.std(axis=0) / lengths
    a = np.sqrt(5) * cdist(x, x)
    covariance = 9 + size**2 * (1 + a + a**2 / 3) * np.exp(-a)
    covariance += np.diag((error / unit) ** 2 + scatter**2)
    y = (values - values.mean()) / unit
    prior = scipy.stats.norm(np.log([1.5, 1.5, 1.5, 0.03]), [1.0, 1.0, 0.7, 1.5])
    return -scipy.stats.multivariate_normal(cov=covariance).logpdf(y) - prior.logpdf(logs).sum()


@pytest.mark.parametrize("count", [16, 5])
def test_the_constants_are_those_of_largest_posterior_probability(count):
    # a search without gradients from where the fit ended goes nowhere: no term of the posterior
    # or of its gradient, and no constant of a prior, can be another
    points, values, _ = data = PLANE_POINTS[:count], PLANE_VALUES[:count], PLANE_ERROR[:count]
    found, unit = fit(*data), values.std()
    logs = np.log([*found.lengths / points.std(axis=0), found.size / unit, found.scatter / unit])
    best = minimize(minus_log_posterior, logs, data, method="Nelder-Mead",
                    options={"xatol": 1e-5, "fatol": 1e-10, "maxiter": 2000})  # fmt: skip
    # L-BFGS-B ends where the posterior is flat to 1e-8 or so: 1e-3 of a flat direction
    np.testing.assert_allclose(logs, best.x, atol=2e-3)


def test_values_in_another_unit_have_the_same_smoothness():
    one, other = (
        fit(PLANE_POINTS, PLANE_VALUES, PLANE_ERROR),
        fit(PLANE_POINTS * [2.0, 0.1], 50 * PLANE_VALUES - 3, 50 * PLANE_ERROR),
    )
    np.testing.assert_allclose(other.lengths, one.lengths * [2.0, 0.1], rtol=1e-3)
    assert other.size == pytest.approx(50 * one.size, rel=1e-3)
    assert other.scatter == pytest.approx(50 * one.scatter, rel=1e-3)


def bumpy(error=0.05):
    """A process through a sine with a value at x = 3 that is 2 too large."""
    x = np.linspace(0, 6, 13)[:, None]
    values = np.sin(x[:, 0])
    values[6] += 2.0
    lengths = np.array([1.5])
    return GaussianProcess(x, values, np.full(13, error), lengths, 1.0, 0.02)


def test_an_outlier_lies_at_the_limit_of_what_the_others_predict():
    process = bumpy()
    others = np.arange(13) != 6
    alone = replace(process, points=process.points[others], values=process.values[others],
                    error=process.error[others], centre=float(np.mean(process.values)),
                    unit=float(np.std(process.values)))  # fmt: skip
    away = alone.mean(process.points[[6]])[0] - process.values[6]
    weaker = process.with_weaker_outliers(np.arange(13) == 6)
    spread = alone.standard_error(process.points[[6]])[0]
    expected = np.sqrt((away / 2) ** 2 - spread**2 - 0.02**2)
    assert weaker.error[6] == pytest.approx(expected, rel=1e-6)
    assert np.array_equal(weaker.error[others], process.error[others])
    # the sine at x = 3 is nearer to what is predicted there
    near = [abs(p.mean(np.array([[3.0]]))[0] - np.sin(3.0)) for p in (weaker, process)]
    assert near[0] < 0.2 * near[1]


def test_a_fit_near_another_ends_where_both_starts_end():
    rng = np.random.default_rng(3)
    x = rng.uniform(0, 6, (40, 2)) * [1, 10]
    values = 5 * np.sin(x[:, 0]) + rng.normal(0, 0.2, 40)
    error = np.full(40, 0.1)
    first = fit(x, values, error)
    start = replace(first, lengths=first.lengths * [1.3, 0.8], scatter=0.7 * first.scatter)
    again = fit(x, values, error, near=start)
    assert again.constants == pytest.approx(first.constants, rel=2e-3)
    assert first.constants.tolist() == [*first.lengths, first.size, first.scatter]


def test_an_axis_whose_points_are_alike_but_for_rounding_has_the_spread_one():
    column = np.array([0.1 + 0.2, 0.3, 0.3])
    points = np.column_stack([np.full(3, -5.0), 1e6 * column, [0.0, 2.0, 4.0]])
    np.testing.assert_allclose(spreads(points), [1, 1, np.sqrt(8 / 3)], rtol=1e-12)


def test_without_values_all_is_as_expected_beforehand():
    # medians of the priors in the units that are given
    empty = fit(
        np.empty((0, 3)), np.empty(0), np.empty(0), axes=np.array([1.0, 2.0, 4.0]), centre=0.7,
        unit=2.0,
    )  # fmt: skip
    np.testing.assert_allclose(empty.constants, [1.5, 3.0, 6.0, 3.0, 0.06])
    assert (empty.centre, empty.unit) == (0.7, 2.0)
