"""Multisines: power, lines, and what straight lines between samples make of them."""

import numpy as np
import pytest

from pidpanel.coupon.multisine import draw_multisine

PSD = np.array([20.0, 100.0, 101.0, 102.0, 900.0]), np.array([1.0, 1.0, 200.0, 1.0, 4.0])


def drawn(period, seed=1, band=(20.0, 900.0)):
    return draw_multisine(*PSD, band, period, np.random.default_rng(seed))


@pytest.mark.parametrize("period", [0.1, 0.37, 1.0, 4.0])
def test_it_has_the_power_of_the_psd_however_coarse_its_lines(period):
    # red: `/ width` → `/ width * 1.1` in draw_multisine
    motion = drawn(period)
    square = np.sum(np.abs(motion.acceleration) ** 2) / period
    # the first and the last line stand for half of 1/T beyond them
    assert square == pytest.approx(np.trapezoid(*PSD[::-1]), rel=0.03 / period**0.5)


def test_a_resonance_narrower_than_the_lines_keeps_its_power():
    # red: `np.diff(_integral(edges, …))` → the PSD at the lines
    motion = drawn(0.1)
    near = np.abs(motion.frequency - 100) < 5
    share = np.sum(np.abs(motion.acceleration[near]) ** 2) / 0.1
    assert share == pytest.approx(8 + 200, rel=0.01)  # 100.5 + 100.5 − 1 of the peak, 1 beside it


def test_the_lines_are_those_of_the_period_within_the_band():
    # red: `np.floor(high` → `np.ceil(high` in draw_multisine
    motion = drawn(0.25)
    assert motion.frequency[[0, -1]] == pytest.approx([20, 900])
    assert np.diff(motion.frequency) == pytest.approx(4)


def test_straight_lines_between_the_samples_have_the_spectrum_asked_for():
    # red: `** 2` → nothing, of the sinc in Multisine.values
    motion = drawn(0.25)
    values = motion.values()
    times = np.linspace(0, 0.25, 64 * motion.samples, endpoint=False)
    at = np.arange(motion.samples + 1) / motion.rate
    finely = np.interp(times, at, np.append(values, values[0]))
    found = np.fft.rfft(finely)[np.rint(motion.frequency * 0.25).astype(int)]
    found *= np.sqrt(2 * 0.25) / len(finely)
    # 64 points on a line miss sinc² by 1e-5 of it
    assert found == pytest.approx(motion.acceleration, rel=1e-4)


def test_a_spectrum_of_samples_is_normalised_as_the_motion_is():
    # red: `/ self._scale` → `* self._scale` in spectrum_of
    motion = drawn(1.0)
    tone = 3.0 * np.cos(2 * np.pi * 50 * np.arange(motion.samples) / motion.rate)
    found = motion.spectrum_of(tone)
    # a tone of amplitude 3 has 3²/2, all on one line 1/T wide
    assert np.sum(np.abs(found) ** 2) / 1.0 == pytest.approx(4.5)
    assert motion.frequency[np.argmax(np.abs(found))] == 50


def test_it_has_ten_samples_to_the_shortest_period_and_phases_all_round():
    # red: `np.ceil(SAMPLES` → `np.floor(SAMPLES`; `rng.uniform(0.0,` → `rng.uniform(1.0,`
    assert drawn(0.25).samples == 2250
    assert drawn(0.2505).samples == 2255
    angle = np.angle(drawn(4.0).acceleration)
    # of 3500 phases none is missing over a twentieth of the circle
    assert (np.histogram(angle, 20, (-np.pi, np.pi))[0] > 100).all()


def test_phases_are_those_of_the_seed_and_of_no_other():
    # red: `rng.uniform(0.0, 2 * np.pi, …)` → zeros
    same, other = drawn(0.5), drawn(0.5, seed=2)
    assert (same.acceleration == drawn(0.5).acceleration).all()
    coherent = np.mean(same.acceleration * other.acceleration.conj())
    assert abs(coherent) < 0.3 * np.mean(np.abs(same.acceleration) ** 2)


def test_a_band_without_a_line_is_refused():
    # red: `if not lines.size` → `if False`
    with pytest.raises(ValueError, match=r"period = 0\.1 s: no line between 21 and 29 Hz"):
        drawn(0.1, band=(21.0, 29.0))
