"""The impedance comes back from records in which the panel answers the bed's own force."""

import numpy as np
import pytest

from pidpanel.coupled.impedance import LINES_PER_FREEDOM, BandImpedance, ImpedanceSums, smoothed

EDGE = np.array([[50.0, 100.0], [100.0, 200.0]])
DAMPING, MASS = 400.0, 2.0
AREA = np.array([1.0, 2.0, 3.0])


def noise(rng, *size):
    return (rng.standard_normal(size) + 1j * rng.standard_normal(size)) / np.sqrt(2)


def loop(seed, lines=400, segments=10, own=1000.0):
    """f, σ, v and r of three cells: v answers the sound, and n as much; σ = Z v + n."""
    rng = np.random.default_rng(seed)
    frequency = np.linspace(50, 199.9, lines)
    size = (segments, lines, 3)
    sound, force = noise(rng, *size), own * noise(rng, *size)
    z = (DAMPING + 2j * np.pi * frequency * MASS)[:, None]
    receptance = 1e-3 * np.exp(0.7j)
    linear = sound / (1 + receptance * z)
    velocity = linear - receptance * force / (1 + receptance * z)
    return frequency, z * velocity + force, velocity, linear


def parts_of(found):
    return found.value.real, found.value.imag / (2 * np.pi * found.frequency)


def test_damping_and_mass_come_back_although_the_panel_answers_the_bed():
    # own force as large as the linear one: bands have 3·1300 and 3·2700 triples, C_e to
    # about 1000·1.3/√12000/√2 = 8 and m_a to 8/2πf; four of them
    damping, mass = parts_of(
        ImpedanceSums.from_spectra(*loop(1, lines=4000), AREA, EDGE).impedance()
    )
    assert damping == pytest.approx([DAMPING] * 2, abs=30)
    assert mass == pytest.approx([MASS] * 2, abs=0.07)


def test_without_own_force_every_subset_has_the_same_impedance():
    # and the frequency of a band is the mean of the motion in it
    sums = ImpedanceSums.from_spectra(*loop(2, own=0.0), AREA, EDGE)
    for weights in ({}, {"cells": np.array([0.0, 1.0, 1.0])}):
        damping, mass = parts_of(sums.impedance(**weights))
        # m_a: the mean frequency of the motion is that of all cells
        assert damping == pytest.approx([DAMPING] * 2, rel=1e-9)
        assert mass == pytest.approx([MASS] * 2, rel=0.01)


def test_what_is_left_out_does_not_count():
    frequency, *spectra = loop(3)
    sums = ImpedanceSums.from_spectra(frequency, *spectra, AREA, EDGE)
    two = ImpedanceSums.from_spectra(
        frequency, *(part[:, :, [0, 2]] for part in spectra), AREA[[0, 2]], EDGE
    )
    # neighbours weigh as with all cells: bands are resolved and keep their ratio to 1 %
    of_two = sums.impedance(cells=np.array([1.0, 0.0, 1.0])).value
    assert of_two == pytest.approx(two.impedance().value, rel=0.01)
    assert np.abs(of_two / sums.impedance().value - 1).max() > 0.01


def test_runs_are_joined_with_cells_of_their_own():
    first, second = (ImpedanceSums.from_spectra(*loop(seed), AREA, EDGE) for seed in (4, 5))
    joined = ImpedanceSums.joined([first, second])
    assert joined.force.shape == (20, 6, 2)
    assert not joined.force[:10, 3:].any()
    assert not joined.velocity[10:, :3].any()
    total = first.force.sum(axis=(0, 1)) + second.force.sum(axis=(0, 1))
    assert joined.force.sum(axis=(0, 1)) == pytest.approx(total, rel=1e-12)
    alone = ImpedanceSums(*(values[10:] for values in vars(joined).values()))
    assert alone.impedance().value == pytest.approx(second.impedance().value, rel=1e-9)


def test_unresolved_bands_follow_their_neighbours_by_the_scatter_of_the_sums(monkeypatch):
    # the variance that is handed to `smoothed` is that of many records: 200 of them know it to 10 %
    ratios, variances = [], []

    def kept(ratio, variance, counted):
        ratios.append(ratio)
        variances.append(variance)
        return ratio, np.diag(variance)

    monkeypatch.setattr("pidpanel.coupled.impedance.smoothed", kept)
    for seed in range(200):
        ImpedanceSums.from_spectra(*loop(seed, lines=60, segments=4), AREA, EDGE).impedance()
    # lines here are independent, those of a Hann window are not
    stated = np.mean(variances, axis=0) / LINES_PER_FREEDOM
    assert stated == pytest.approx(np.var(ratios, axis=0), rel=0.3)


def test_bands_that_are_known_stay_and_others_follow_their_neighbours():
    ratio = np.array([400.0, 420.0, 430.0, -5000.0, 460.0, 470.0]) + 0j
    variance = np.array([1.0, 1.0, 1.0, 1e8, 1.0, 1.0])
    found, covariance = smoothed(ratio, variance, variance)
    assert np.delete(found, 3) == pytest.approx(np.delete(ratio, 3), rel=1e-3)
    assert 400 < found[3].real < 480
    # as unsure as two steps of 30 % at once, one from each side: 0.3·445/√2
    assert np.sqrt(covariance[3, 3]) == pytest.approx(0.3 * 445 / np.sqrt(2), rel=0.05)


def test_cells_count_with_their_area_and_their_motion():
    # Z = Σ a |v|² Z_c / Σ a |v|²
    rng = np.random.default_rng(1)
    frequency = np.linspace(50, 199.9, 40)
    velocity = np.exp(2j * np.pi * rng.random((5, 40, 1))) * np.array([1.0, 0.5, 2.0])
    z = np.array([100.0, 400.0, 900.0])
    sums = ImpedanceSums.from_spectra(frequency, z * velocity, velocity, velocity, AREA, EDGE)
    weight = AREA * np.array([1.0, 0.25, 4.0])
    wanted = weight @ z / weight.sum()
    found = sums.impedance()
    assert found.value == pytest.approx(np.full(2, wanted), rel=1e-4)
    # cells differ, which is left to the jackknife: lines do not
    assert np.abs(found.deviation).max() < 1e-4 * wanted


def test_lines_of_hann_windows_depend_on_their_neighbours():
    # Σ ρ² over lines of the segment and of the two that overlap it by half, by Parseval's theorem
    length = 1000
    window = np.hanning(length + 1)[:-1]
    norm = length / (window @ window) ** 2
    alike = norm * (window**4).sum()
    beside = norm * ((window[: length // 2] * window[length // 2 :]) ** 2).sum()
    assert alike == pytest.approx(1.944, abs=1e-3)
    assert pytest.approx(alike + 2 * beside, rel=0.01) == LINES_PER_FREEDOM


def one_motion(seed, shared, turned=1.0):
    """f, σ, v and r of twelve cells that move as one, with a force of each or of all."""
    rng = np.random.default_rng(seed)
    linear = noise(rng, 4, 60, 1) * np.ones(12)
    force = 100.0 * noise(rng, 4, 60, 1 if shared else 12) * np.ones(12)
    return np.linspace(50, 199.9, 60), DAMPING * linear + force, linear, turned * linear


@pytest.mark.parametrize("shared", [False, True])
def test_deviations_and_the_jackknife_share_the_scatter_of_many_records(monkeypatch, shared):
    # deviations have a force that all twelve cells share, but for a twelfth that cells would have
    # by chance, and the jackknife that of each; a variance is known to √(2/records)
    monkeypatch.setattr(
        "pidpanel.coupled.impedance.LINES_PER_FREEDOM", 1.0
    )  # lines are independent
    values, stated = [], []
    for seed in range(300 if shared else 60):
        sums = ImpedanceSums.from_spectra(*one_motion(seed, shared), np.ones(12), EDGE)
        whole = sums.impedance()
        values.append(whole.value.real)
        stated.append((whole.deviation.real**2).sum(axis=1))
        if not shared:
            fewer = [sums.impedance(cells=1 - unit).value.real for unit in np.eye(12)]
            stated[-1] += 11 * np.var(fewer, axis=0)
    wanted = np.var(values, axis=0) * (11 / 12 if shared else 1)
    assert np.mean(stated, axis=0) == pytest.approx(wanted, rel=0.2 if shared else 0.5)


@pytest.mark.parametrize("turned", [np.exp(0.7j), 1e-4])
def test_an_instrument_that_is_late_or_weak_changes_neither_value_nor_error(turned):
    found = [
        ImpedanceSums.from_spectra(*one_motion(1, True, factor), np.ones(12), EDGE).impedance()
        for factor in (1.0, turned)
    ]
    assert found[1].value == pytest.approx(found[0].value, rel=1e-9)
    sizes = [(np.abs(one.deviation) ** 2).sum(axis=1) for one in found]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-6)


@pytest.mark.parametrize("bands", [1, 2, 3, 7])
def test_of_any_number_of_bands_those_above_and_below_count_alike(bands):
    rng = np.random.default_rng(bands)
    ratio = np.geomspace(100, 900, bands) + noise(rng, bands) * 50
    variance = 1e4 * (1 + rng.random(bands))
    found, _ = smoothed(ratio, variance, variance)
    turned, _ = smoothed(ratio[::-1], variance[::-1], variance)
    assert turned[::-1] == pytest.approx(found, rel=1e-9)


def test_a_mass_is_not_smoothed_away():
    # Im Z = ω m grows by 26 % from band to band, with errors of 10 %
    centre = 10 ** (np.arange(20, 31) / 10)
    mass = 2j * np.pi * centre * 6.0
    found, _ = smoothed(mass, (0.1 * np.abs(mass)) ** 2, np.abs(mass))
    assert found[1:-1] == pytest.approx(mass[1:-1], rel=0.05)


def test_between_bands_damping_and_mass_are_linear_over_the_logarithm():
    # and held beyond them
    nodes = np.array([100.0, 400.0])
    value = np.array([300.0, 500.0]) + 2j * np.pi * nodes * np.array([2.0, 1.0])
    asked = np.array([0.0, 50.0, 200.0, 800.0])
    found = BandImpedance(nodes, value, np.zeros((2, 0)))(asked)
    assert found.real == pytest.approx([300, 300, 400, 500])
    assert found.imag == pytest.approx(2 * np.pi * asked * np.array([2.0, 2.0, 1.5, 1.0]))
