"""Moments, peaks and fatigue against closed forms and against counts of Gaussian noise."""

import itertools

import numpy as np
import pytest
from scipy.integrate import quad

from pidpanel.severity.fatigue import FatigueLine, dirlik_damage_rate, narrow_band_damage_rate
from pidpanel.severity.moments import peak_factor, spectral_moment, zero_crossing_rate

FREQUENCY = np.arange(20.0, 1000.5, 0.5)
RATE, DURATION = 12_000.0, 150.0


def resonance(natural, ratio=0.02):
    r = FREQUENCY / natural
    return 1e12 / ((1 - r**2) ** 2 + (2 * ratio * r) ** 2)


PSDS = {
    "one resonance": resonance(300.0),
    "three, the middle one highest": 0.1 * resonance(100.0)
    + resonance(300.0)
    + 0.3 * resonance(700.0),
    "wide band": np.full(FREQUENCY.size, 1e12),
}


def noise(psd, seed):
    """Gaussian noise with a PSD, and its turning points."""
    count = int(RATE * DURATION)
    frequency = np.fft.rfftfreq(count, 1 / RATE)
    level = np.interp(frequency, FREQUENCY, psd, left=0.0, right=0.0)
    draw = np.random.default_rng(seed).normal(size=(2, frequency.size))
    wave = np.fft.irfft((draw[0] + 1j * draw[1]) * np.sqrt(level * DURATION) / 2 * RATE, count)
    slope = np.diff(wave)
    turns = np.flatnonzero(slope[1:] * slope[:-1] < 0) + 1
    return wave, wave[turns]


def rainflow_amplitudes(turns):
    """Amplitudes of the cycles of turning points, and their weights (ASTM E 1049)."""
    amplitude, weight, stack = [], [], []
    for value in turns.tolist():
        stack.append(value)
        while len(stack) >= 3:
            last, before = abs(stack[-1] - stack[-2]), abs(stack[-2] - stack[-3])
            if last < before:
                break
            amplitude.append(before / 2)
            if len(stack) == 3:
                weight.append(0.5)
                stack.pop(0)
            else:
                weight.append(1.0)
                del stack[-3:-1]
    amplitude += [abs(b - a) / 2 for a, b in itertools.pairwise(stack)]
    weight += [0.5] * (len(stack) - 1)
    return np.array(amplitude), np.array(weight)


def test_rainflow_counts_the_example_of_the_standard():
    # ASTM E 1049-85, figure 6: ranges 3, 4, 6, 8, 9 with 0.5, 1.5, 0.5, 1, 0.5 cycles
    amplitude, weight = rainflow_amplitudes(np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2]))
    ranges = {size: weight[2 * amplitude == size].sum() for size in (3, 4, 6, 8, 9)}
    assert ranges == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}


@pytest.mark.parametrize("order", range(5))
def test_moments_of_straight_lines_are_exact(order):
    frequency = np.array([10.0, 20.0, 70.0])
    psd = np.stack([3 + 0.2 * frequency, np.ones(3)], axis=1)

    def power(n):
        return (70.0**n - 10.0**n) / n

    exact = [3 * power(order + 1) + 0.2 * power(order + 2), power(order + 1)]
    np.testing.assert_allclose(spectral_moment(frequency, psd, order), exact, rtol=1e-13)


@pytest.mark.parametrize(
    ("name", "closest"),
    [("one resonance", 0.07), ("three, the middle one highest", 0.1), ("wide band", 0.1)],
)
def test_dirlik_counts_like_rainflow_and_the_narrow_band_count_is_safe(name, closest):
    # 0.07: what chance leaves of A⁶ in 150 s
    psd = PSDS[name]
    wave, turns = noise(psd, seed=3)
    m0 = spectral_moment(FREQUENCY, psd, 0)
    assert wave.std() == pytest.approx(np.sqrt(m0), rel=0.02)
    crossings = np.sum((wave[1:] >= 0) & (wave[:-1] < 0)) / DURATION
    assert crossings == pytest.approx(zero_crossing_rate(FREQUENCY, psd), rel=0.01)
    amplitude, weight = rainflow_amplitudes(turns)
    for exponent in (4.0, 6.0):
        line = FatigueLine(stress=1e8, cycles=1e6, exponent=exponent)
        counted = np.sum(weight * (amplitude / 1e8) ** exponent) / 1e6 / DURATION
        assert dirlik_damage_rate(FREQUENCY, psd, line) == pytest.approx(counted, rel=closest)
        assert narrow_band_damage_rate(FREQUENCY, psd, line) > 0.95 * counted


@pytest.mark.parametrize(("name", "low", "high"), [("wide band", -4, 4), ("one resonance", -20, 0)])
def test_the_largest_peak_of_noise_is_that_of_davenport(name, low, high):
    # peaks of one resonance come in clumps, so theirs is lower; in standard errors of the mean
    wave, _ = noise(PSDS[name], seed=5)
    pieces = wave[: 100 * (wave.size // 100)].reshape(100, -1)
    largest = pieces.max(axis=1) / wave.std()
    factor = peak_factor(zero_crossing_rate(FREQUENCY, PSDS[name]), DURATION / 100)
    assert low < (largest.mean() - factor) / (largest.std() / 10) < high


def test_the_largest_of_very_many_independent_peaks_is_that_of_davenport():
    # peaks of a narrow band are those of Rayleigh: ∫ 1 − (1 − e^(−x²/2))^N dx; terms of order
    # (2 ln N)^(−3/2), 0.0024, are left out.
    count = 1e12
    largest, _ = quad(lambda x: -np.expm1(count * np.log1p(-np.exp(-(x**2) / 2))), 1e-9, 20)
    assert peak_factor(np.array(count / 60), 60.0) == pytest.approx(largest, abs=0.004)


FLIFE = {1.0: 2.27422317e-05, 3.0: 4.04134444e-06, 5.0: 1.38283611e-06, 7.3: 6.21038889e-07}
"""Damage a second by `FLife.Dirlik` 2.3 with the moments of two flat bands, by exponent."""


@pytest.mark.parametrize("exponent", FLIFE)
def test_two_flat_bands_have_the_damage_that_flife_states(exponent):
    # variances of 5 and 2 on 20 to 60 and 100 to 120 Hz
    edges = np.array([20, 60, 60 + 1e-9, 100 - 1e-9, 100, 120])
    psd = np.array([5 / 40, 5 / 40, 0, 0, 2 / 20, 2 / 20])
    line = FatigueLine(stress=10.0, cycles=1e6, exponent=exponent)
    assert dirlik_damage_rate(edges, psd, line) == pytest.approx(FLIFE[exponent], rel=1e-7)


def test_a_negative_r_has_the_damage_that_flife_states():
    # variances of 5 and 0.02 on 1 to 60 and 300 to 310 Hz
    edges = np.array([1, 60, 60 + 1e-9, 300 - 1e-9, 300, 310])
    psd = np.array([5 / 59, 5 / 59, 0, 0, 0.02 / 10, 0.02 / 10])
    line = FatigueLine(stress=10.0, cycles=1e6, exponent=7.3)
    assert dirlik_damage_rate(edges, psd, line) == pytest.approx(1.04749279e-07, rel=1e-6)


@pytest.mark.parametrize("count", [dirlik_damage_rate, narrow_band_damage_rate])
def test_the_damage_does_not_depend_on_the_unit_of_stress(count):
    psd = PSDS["one resonance"]
    in_pascal = count(FREQUENCY, psd, FatigueLine(1e8, 1e6, 5.0))
    in_gigapascal = count(FREQUENCY, psd / 1e18, FatigueLine(0.1, 1e6, 5.0))
    assert in_gigapascal == pytest.approx(in_pascal, rel=1e-9)


@pytest.mark.parametrize("name", PSDS)
def test_amplitudes_sum_to_a_quarter_of_all_that_the_stress_moves(name):
    # E|σ̇| = √(2/π) 2π √m₂, whatever the count; 1.25 in q stands for √(π/2): 0.3 %
    moved = np.sqrt(2 / np.pi) * 2 * np.pi * np.sqrt(spectral_moment(FREQUENCY, PSDS[name], 2))
    line = FatigueLine(stress=1e8, cycles=1e6, exponent=1.0)
    found = dirlik_damage_rate(FREQUENCY, PSDS[name], line)
    assert found == pytest.approx(moved / 4 / 1e8 / 1e6, rel=3e-3)


@pytest.mark.parametrize(("exponent", "mean_power"), [(2.0, 2.0), (4.0, 8.0), (6.0, 48.0)])
def test_rayleigh_amplitudes_have_their_even_moments(exponent, mean_power):
    # E A^b = 2^(b/2) (b/2)! σ^b
    psd = PSDS["one resonance"]
    rms = np.sqrt(spectral_moment(FREQUENCY, psd, 0))
    line = FatigueLine(stress=3 * float(rms), cycles=1e6, exponent=exponent)
    rate = zero_crossing_rate(FREQUENCY, psd) * mean_power / 3**exponent / 1e6
    assert narrow_band_damage_rate(FREQUENCY, psd, line) == pytest.approx(rate, rel=1e-12)


def test_no_stress_makes_no_damage():
    line = FatigueLine(1e8, 1e6, 5.0)
    psd = np.zeros((FREQUENCY.size, 2))
    for count in (dirlik_damage_rate, narrow_band_damage_rate):
        np.testing.assert_array_equal(count(FREQUENCY, psd, line), 0.0)
