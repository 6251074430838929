"""The impedance comes back from records in which the panel answers the bed's own force."""

import numpy as np
import pytest

from pidpanel.coupled.identification import (
    band_impedance,
    band_sums,
    over_frequency,
    own_force,
    pressure_spectra,
    smoothed,
    spectra_of,
)

EDGE = np.array([[50.0, 100.0], [100.0, 200.0]])


def noise(rng, *size):
    return (rng.standard_normal(size) + 1j * rng.standard_normal(size)) / np.sqrt(2)


def loop(seed, lines=4000):
    """σ and v of three stations: v answers the sound, and n as much; σ = Z v + n."""
    rng = np.random.default_rng(seed)
    frequency = np.linspace(50, 200, lines)
    sound, own = noise(rng, lines, 3), 1000 * noise(rng, lines, 3)
    z, receptance = 400 + 100j, 1e-3 * np.exp(0.7j)
    speed = (sound - receptance * own) / (1 + receptance * z)
    return frequency, z * speed + own, speed, sound, z


def test_the_impedance_comes_back_although_the_panel_answers_the_bed():
    # each band has 3·2000 pairs: Z to 1000·1.3/√6000 = 17, four of them
    # red: `instrument.conj()` → `velocity.conj()` in `band_impedance` (Z is then wrong by 270)
    frequency, pressure, speed, sound, z = loop(1)
    area = np.array([1.0, 2.0, 3.0])
    found = band_impedance(frequency, pressure, speed, sound, area, EDGE)
    spread = np.sqrt(found.variance)
    assert np.all(np.abs(found.ratio - z) < 4 * spread)
    assert np.all(spread < 0.1 * np.abs(z))


def test_the_stated_variance_is_that_of_many_records():
    # 200 records: their scatter is known to 5 %, the mean of their variances better; 20 % allowed,
    # four errors, beside the factor 1.15 of a tapered window, which these lines do not have
    # red: |Σ y|² → Σ |y|² in `variance`
    ratios, variances = [], []
    for seed in range(200):
        frequency, pressure, speed, sound, _ = loop(seed, 300)
        one = band_impedance(frequency, pressure, speed, sound, np.ones(3), EDGE)
        ratios.append(one.ratio)
        variances.append(one.variance / 1.15)
    scatter = np.var(ratios, axis=0)
    assert np.mean(variances, axis=0) == pytest.approx(scatter, rel=0.2)


def test_a_mass_and_a_dashpot_come_back_from_rows_in_time():
    # impulse and place of a body of 3 kg/m² on a dashpot of 500 N s/m³ that is shaken at random
    # red: the turn by half an interval left out of `pressure_spectra`
    rng = np.random.default_rng(3)
    interval, rows = 5e-5, 40000
    f = np.fft.rfftfreq(rows, interval)
    band = (f > 40) & (f < 2000)
    w = np.where(band, noise(rng, len(f)) / np.maximum(f, 1), 0)
    place = np.fft.irfft(w, rows)
    impulse = np.fft.irfft((500 + 3 * 2j * np.pi * f) * w, rows)  # ∫ (C ẇ + m ẅ) dt
    edge = np.array([[50.0, 100.0], [900.0, 1100.0], [1500.0, 1900.0]])
    motion = spectra_of(place[:-1, None], interval)
    speed = 2j * np.pi * motion.frequency[:, None] * motion.values
    pressure = pressure_spectra(impulse[:, None], interval).values
    bands = band_impedance(motion.frequency, pressure, speed, speed, np.ones(1), edge)
    found = bands.ratio
    # the window mixes lines 1/2 Hz apart: 0.25 % at 50 Hz
    assert found.real == pytest.approx([500] * 3, rel=5e-3)
    # red: frequency * y → y in `moment`
    assert found.imag / (2 * np.pi * bands.frequency) == pytest.approx([3] * 3, rel=5e-3)


def test_spectra_have_the_mean_square_of_the_rows():
    # red: 2 → 1 in the scale of `spectra_of`
    rows = np.random.default_rng(5).standard_normal((200000, 1))
    found = spectra_of(rows, 1e-3)
    psd = np.mean(np.abs(found.values) ** 2)
    assert psd * 500 == pytest.approx(1.0, rel=0.02)


def test_a_line_at_an_edge_counts_once():
    # red: side="right" in `band_sums`
    frequency = np.array([50.0, 75.0, 100.0, 150.0, 200.0])
    assert band_sums(frequency, np.ones((5, 1)), EDGE).ravel().tolist() == [2.0, 2.0]


@pytest.mark.parametrize("stations", [4, 16])
def test_own_force_is_told_apart_into_common_and_independent(stations):
    # 20000 lines: each part to 1 % of the whole; four of them
    # red: pairs → stations² in `own_force`
    rng = np.random.default_rng(stations)
    lines = 40000
    own = np.sqrt(3) * noise(rng, lines, stations) + np.sqrt(2) * noise(rng, lines, 1)
    found = own_force(np.linspace(50, 200, lines), own, EDGE)
    assert found.independent == pytest.approx([3.0] * 2, abs=0.2)
    assert found.common == pytest.approx([2.0] * 2, abs=0.2)


def test_the_common_part_of_chance_is_as_likely_negative_and_counts_little():
    # 300 times without any: its variance is known to 8 %, the mean of what counts is zero
    # red: pairs left out of `chance`; `square` → `abs` in `likely_common`
    rng = np.random.default_rng(9)
    found = [own_force(np.linspace(50, 199.9, 400), noise(rng, 400, 8), EDGE) for _ in range(300)]
    common = np.array([one.common for one in found])
    stated = np.mean([one.common_variance for one in found], axis=0) / 1.15
    assert stated == pytest.approx(common.var(axis=0), rel=0.35)
    likely = np.array([one.likely_common for one in found])
    assert np.abs(likely.mean(axis=0)).max() < 4 * common.std() / np.sqrt(300)
    assert likely.std() < 0.8 * common.std()


def test_of_one_station_all_of_the_own_force_is_independent():
    # red: the branch of one station left out (0/0)
    found = own_force(np.linspace(50, 200, 100), np.ones((100, 1), complex), EDGE)
    assert found.common.tolist() == [0.0, 0.0]
    assert found.independent == pytest.approx([1.0, 1.0])


def test_bands_that_are_known_stay_and_others_follow_their_neighbours():
    # red: weight * ratio → ratio in `smoothed`
    ratio = np.array([400.0, 420.0, 430.0, -5000.0, 460.0, 470.0]) + 0j
    variance = np.array([1.0, 1.0, 1.0, 1e8, 1.0, 1.0])
    found, _ = smoothed(ratio, variance)
    assert np.delete(found, 3) == pytest.approx(np.delete(ratio, 3), rel=1e-3)
    assert 400 < found[3].real < 480


def test_a_mass_is_not_smoothed_away():
    # Im Z = ω m grows by 26 % from band to band, with errors of 10 %
    # red: STEP_OF_BAND = 0.03
    centre = 10 ** (np.arange(20, 31) / 10)
    mass = 2j * np.pi * centre * 6.0
    found, _ = smoothed(mass, (0.1 * np.abs(mass)) ** 2)
    assert found[1:-1] == pytest.approx(mass[1:-1], rel=0.05)


def test_between_bands_damping_and_mass_are_linear_over_the_logarithm():
    # red: 2π centre → 1 in `over_frequency`
    centre = np.array([100.0, 400.0])
    value = np.array([300.0, 500.0]) + 2j * np.pi * centre * np.array([2.0, 1.0])
    found = over_frequency(np.array([50.0, 200.0, 800.0]), centre, value)
    assert found.real == pytest.approx([300, 400, 500])
    assert found.imag == pytest.approx(2 * np.pi * np.array([50 * 2.0, 200 * 1.5, 800 * 1.0]))
