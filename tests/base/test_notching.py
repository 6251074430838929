"""Notches keep every limit and take no more than that."""

import numpy as np
import pytest

from pidpanel.base.random import Limit, notch_input

FREQUENCY = np.linspace(10.0, 500.0, 4000)
STATED = np.full(FREQUENCY.shape, 0.5)
GAIN = np.array(
    [
        1 / ((1 - (FREQUENCY / own) ** 2) ** 2 + (0.1 * FREQUENCY / own) ** 2)
        for own in (100.0, 250.0)
    ]
)


def rms(psd):
    return np.sqrt(np.trapezoid(psd, FREQUENCY))


def test_a_limit_of_a_psd_holds_and_leaves_the_rest():
    lowered = notch_input(FREQUENCY, STATED, GAIN, [Limit(0, "a", 4.0)])
    response = GAIN[0] * lowered.psd
    assert response.max() == pytest.approx(4.0)
    free = GAIN[0] * STATED <= 4.0
    assert np.array_equal(lowered.psd[free], STATED[free])
    np.testing.assert_allclose(response[~free], 4.0)
    assert set(lowered.reason[~free]) == {0} and set(lowered.reason[free]) == {-1}


def test_a_limit_of_the_overall_value_is_met_by_lowering_the_peak():
    lowered = notch_input(FREQUENCY, STATED, GAIN, [Limit(1, "b", 20.0, is_rms=True)])
    assert rms(GAIN[1] * STATED) > 20
    assert rms(GAIN[1] * lowered.psd) == pytest.approx(20.0, rel=1e-9)
    cap = (GAIN[1] * lowered.psd)[lowered.reason == 0]
    np.testing.assert_allclose(cap, cap[0])
    assert np.array_equal(lowered.psd[:100], STATED[:100])


def test_all_limits_hold_together_whatever_their_order():
    limits = [Limit(0, "rms", 15.0, is_rms=True), Limit(0, "psd", 4.0), Limit(1, "b", 9.0)]
    both = [notch_input(FREQUENCY, STATED, GAIN, some).psd for some in (limits, limits[::-1])]
    np.testing.assert_allclose(*both)
    assert (GAIN[0] * both[0]).max() <= 4 * (1 + 1e-12)
    assert (GAIN[1] * both[0]).max() <= 9 * (1 + 1e-12)
    assert rms(GAIN[0] * both[0]) <= 15 * (1 + 1e-9)


@pytest.mark.parametrize("unit", [1.0, 1e-3])
@pytest.mark.parametrize(("second", "first"), [(0.05, 0.0), (0.2, 0.05)])
def test_no_limit_takes_what_another_has_taken(unit, second, first):
    narrow = np.array([GAIN[0] + first * GAIN[1], GAIN[0] + second * GAIN[1]])
    for limits in (
        [Limit(0, "a", 10 * unit, is_rms=True), Limit(1, "b", 14 * unit, is_rms=True)],
        [Limit(1, "b", 14 * unit, is_rms=True), Limit(0, "a", 10 * unit, is_rms=True)],
    ):
        lowered = notch_input(FREQUENCY, unit**2 * STATED, narrow, limits)
        for index, limit in enumerate(limits):
            reached = rms(narrow[limit.location] * lowered.psd)
            assert reached <= limit.value * (1 + 1e-6)
            assert reached == pytest.approx(limit.value, rel=1e-6) or index not in lowered.reason


def test_a_limit_that_is_kept_leaves_no_notch():
    limits = [Limit(0, "a", 1e9), Limit(0, "a", 1e9, is_rms=True)]
    lowered = notch_input(FREQUENCY, STATED, GAIN, limits)
    assert np.array_equal(lowered.psd, STATED)
    assert set(lowered.reason) == {-1}


def test_each_line_has_the_limit_that_lowers_it():
    lowered = notch_input(FREQUENCY, STATED, GAIN, [Limit(0, "a", 4.0), Limit(1, "b", 9.0)])
    low, high = (FREQUENCY[lowered.reason == index] for index in (0, 1))
    assert low.min() < 100 < low.max() < high.min() < 250 < high.max()
