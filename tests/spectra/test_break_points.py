"""A PSD of break points against fine quadrature, with and without steps."""

import itertools

import numpy as np
import pytest

from pidpanel.spectra.break_points import BreakPoints

STEPS = BreakPoints(np.array([20.0, 80.0, 80.0, 90.0, 200.0]), np.array([1.0, 16.0, 2.0, 2.0, 0.9]))


def test_steps_are_where_a_frequency_repeats():
    assert STEPS.jumps.tolist() == [80.0]


@pytest.mark.parametrize(("low", "high"), [(20.0, 200.0), (30.0, 85.0), (81.0, 89.0), (50.0, 60.0)])
def test_the_mean_square_is_that_of_many_lines(low, high):
    parts = np.unique(np.clip([low, 80.0, high], low, high))
    total = 0.0
    for begin, end in itertools.pairwise(parts):
        f = np.linspace(begin + 1e-9, end - 1e-9, 20_001)
        total += np.trapezoid(STEPS(f), f)
    assert STEPS.mean_square(low, high) == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize(
    ("low", "high", "frequency"),
    [(1.0, 999.0, [20, 80, 300, 500]), (40.0, 400.0, [40, 80, 300, 400]), (90.0, 100.0, [90, 100])],
)
def test_a_part_has_the_break_points_within_it_and_its_ends(low, high, frequency):
    whole = BreakPoints(np.array([20.0, 80.0, 300.0, 500.0]), np.array([1.0, 16.0, 16.0, 2.0]))
    part = whole.segment(low, high)
    np.testing.assert_allclose(part.frequency, frequency)
    np.testing.assert_allclose(part.psd, whole(np.array(frequency, float)))
