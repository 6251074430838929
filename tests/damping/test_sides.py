"""A function with a jump: mean and covariance are those of the mixture, by drawing it."""

import numpy as np
import pytest

from pidpanel.damping.gaussian_process import GaussianProcess
from pidpanel.damping.sides import GRAIN, Sides, common, even_steps

POINTS = np.array([[0.2, 3.0, -3.0], [0.3, 3.4, -2.0], [0.5, 4.0, -1.0], [0.9, 5.0, 0.5]])
ASKED = np.array([[0.25, 3.2, -2.4], [0.3, 3.2, -2.3], [0.5, 3.2, -1.4], [0.5, 3.2, -1.2]])
CROSSING = np.array([0.02, 0.3, 0.6, 0.95])
EXPECTED = np.array([3.0, 3.1, 3.2, 3.1])
RESTLESS = np.array([[0.0, 0.1, 0.2, 0.2], [0.1, 0.1, 0.05, 0.0]])
LENGTHS = np.array([0.5, 2.0, 1.5])


def process(values, size, scatter, **prior):
    return GaussianProcess(
        POINTS, np.array(values), np.full(4, 0.05), LENGTHS, size, scatter, **prior
    )


@pytest.fixture(scope="module")
def sides():
    return Sides(
        process([1.0, 1.2, 0.7, 0.9], 0.4, 0.1),
        process([0.1, -0.1, 0.0, 0.05], 0.2, 0.05, centre=0.0, unit=0.2),
    )


@pytest.fixture(scope="module")
def drawn(sides):
    """(draws, 4) of the function: both processes, and one jump common to all points."""
    rng = np.random.default_rng(3)
    count = 200_000

    def draw(of, restless):
        near = np.maximum(1 - np.abs(ASKED[:, None] - ASKED[None]) / GRAIN, 0).prod(axis=2)
        covariance = of.covariance(ASKED) + (of.scatter**2 + np.outer(restless, restless)) * near
        return rng.multivariate_normal(of.mean(ASKED), covariance, count)

    riding = draw(sides.riding, RESTLESS[0])
    crossing = draw(sides.crossing, RESTLESS[1]) + EXPECTED
    crosses = rng.uniform(size=(count, 1)) < CROSSING
    return np.where(crosses, crossing, riding), crosses, riding, crossing


@pytest.mark.parametrize(
    ("high", "values"),
    [(2.0, [2.0, 2.3]), (2.2, [2.0, 2.2]), (2.6, [2.0, 2.3, 2.6]), (2.75, [2.0, 2.25, 2.5, 2.75])],
)
def test_steps_from_end_to_end_are_even_and_at_most_as_wide_as_asked(high, values):
    np.testing.assert_allclose(even_steps(2.0, high, 0.3000001 if high == 2.6 else 0.3), values)


def test_mean_and_covariance_are_those_of_the_draws(sides, drawn):
    # 200 000 draws: 5 standard errors of a covariance of numbers of spread 1.2 are 0.02
    at = sides.mixture(ASKED, CROSSING, EXPECTED, RESTLESS)
    np.testing.assert_allclose(at.mean, drawn[0].mean(axis=0), atol=0.02)
    covariance = sides.covariance(at, at)
    np.testing.assert_allclose(covariance, np.cov(drawn[0].T), atol=0.02)
    np.testing.assert_allclose(sides.variance(at), np.diag(covariance))
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_a_second_function_that_jumps_with_it_errs_with_it(sides, drawn):
    at = sides.mixture(ASKED, CROSSING, EXPECTED, RESTLESS)
    step = np.array([5.0, -4.0, 3.0, 6.0])
    other = drawn[1] * step  # known exactly on either side
    joint = np.cov(drawn[0].T, other.T)[:4, 4:]
    np.testing.assert_allclose(common(at, at, at.step, step), joint, atol=0.08)


def test_a_case_left_out_is_predicted_by_the_others_of_its_side_and_by_the_other_side(sides):
    # the processes made again without it at the same constants, mixed by what is told of the side
    crosses = np.array([False, False, True, True])
    riding, crossing = (
        GaussianProcess(of.points[own], of.values[own], of.error[own], of.lengths, of.size,
                        of.scatter, 0.3, 0.5)
        for of, own in ((sides.riding, ~crosses), (sides.crossing, crosses))
    )  # fmt: skip
    split, p = Sides(riding, crossing), np.array([0.1, 0.4, 0.5, 0.9])
    values = np.where(crosses, sides.crossing.values + EXPECTED, sides.riding.values)
    at = split.mixture(POINTS, p, EXPECTED, RESTLESS)
    error, size = split.leave_one_out(values, np.full(4, 0.05), crosses.astype(float), at)
    for i in range(4):
        of, own = ((riding, ~crosses), (crossing, crosses))[int(crosses[i])]
        rest = np.flatnonzero(own) != i
        less = GaussianProcess(of.points[rest], of.values[rest], of.error[rest], of.lengths,
                               of.size, of.scatter, 0.3, 0.5)  # fmt: skip
        parts = Sides(riding, less) if crosses[i] else Sides(less, crossing)
        at = parts.mixture(POINTS[[i]], p[[i]], EXPECTED[[i]], RESTLESS[:, [i]])
        value = of.values[~rest][0] + (EXPECTED[i] if crosses[i] else 0.0)
        assert error[i] == pytest.approx(at.mean[0] - value)
        assert size[i] == pytest.approx(np.sqrt(parts.variance(at)[0] + 0.05**2))


def test_a_process_without_values_is_what_was_known_before():
    empty = GaussianProcess(POINTS[:0], np.zeros(0), np.zeros(0), LENGTHS, 0.3, 0.1, 0.7, 0.2)
    np.testing.assert_allclose(empty.mean(ASKED), 0.7)
    np.testing.assert_allclose(empty.standard_error(ASKED), np.hypot(0.3, 3 * 0.2))
