"""The best linear approximation against stand-ins that are known exactly, and its errors, counted."""

import importlib.util

import numpy as np
import pytest
from scipy import signal

from pidpanel.damping.best_linear import PACKING, Leg, approximate
from pidpanel.third_octaves import edge_frequency

EDGES = np.r_[50.0, edge_frequency(np.arange(18, 30))[:, 0], 800.0]


def complex_noise(rng, psd, shape=()):
    """(…, n) whose mean square is the PSD (n,)."""
    size = (*shape, len(psd))
    return np.sqrt(psd / 2) * (rng.standard_normal(size) + 1j * rng.standard_normal(size))


def stand_in(
    rng, damping, mass, *, common=0.0, own=0.0, packings=2, spread=0.0, periods=(1.0, 2.0)
):
    """Legs of dashpots with mass: with a resonance in the motion, and forces of their own."""
    factor = 1 + spread * rng.standard_normal(packings)[:, None]
    legs = []
    for period in periods:
        f = np.arange(50 * period, 800 * period + 1) / period
        omega = 2 * np.pi * f
        size = 1e-3 * (1 + 5 / (1 + ((f - 120) / 5) ** 2)) * 100 / f
        v = size * np.exp(1j * rng.uniform(0, 2 * np.pi, f.size))
        linear = factor * (damping(f) + 1j * omega * mass(f)) * v
        every = np.ones(f.size)
        noise = complex_noise(rng, common * every) + complex_noise(rng, own * every, (packings,))
        legs.append(Leg(f, v, linear + noise))
    return legs


def test_a_dashpot_with_mass_comes_back_exactly():
    # red: `2j * np.pi` → `-2j * np.pi` in _linear
    legs = stand_in(np.random.default_rng(1), lambda f: 700 + 0 * f, lambda f: 2.0 + 0 * f)
    found = approximate(legs, EDGES)
    assert found.equivalent_damping == pytest.approx(700, rel=1e-12)
    assert found.apparent_mass == pytest.approx(2, rel=1e-12)
    assert found.coherence == pytest.approx(1, rel=1e-12)
    assert found.common_psd.max() < 1e-20
    assert found.own_psd.max() < 1e-20


def test_bands_cover_the_range_and_are_joined_where_they_are_not_resolved():
    # red: `bands[-1][0], top` → `bands[-1]` in _bands
    rng = np.random.default_rng(2)
    quiet = approximate(stand_in(rng, lambda f: 700 + 0 * f, lambda f: 0 * f, own=1e-4), EDGES)
    loud = approximate(stand_in(rng, lambda f: 700 + 0 * f, lambda f: 0 * f, own=3.0), EDGES)
    assert len(quiet.low) == len(EDGES) - 1 > len(loud.low) > 1
    for found in (quiet, loud):
        assert found.low[0] == 50
        assert found.high[-1] >= 800
        assert (found.low[1:] == found.high[:-1]).all()
        assert ((found.low < found.frequency) & (found.frequency < found.high)).all()


@pytest.mark.parametrize(("common", "own"), [(0.05, 0.02), (0.0, 0.5), (0.5, 0.5)])
def test_stated_errors_are_true(common, own):
    """C_e and m_a of 150 stand-ins miss their truth by as much as is stated."""
    # red: `damping**2 *` → `2 * damping**2 *` in _fit
    z, z_mass = [], []
    for seed in range(150):
        rng = np.random.default_rng(seed)
        legs = stand_in(rng, lambda f: 700 + 0 * f, lambda f: 0.5 + 0 * f, common=common, own=own)
        found = approximate(legs, EDGES)
        z += ((found.equivalent_damping - 700) / found.equivalent_damping_error).tolist()
        z_mass += ((found.apparent_mass - 0.5) / found.apparent_mass_error).tolist()
    # √(mean z²) of n values scatters by 1/√(2n) < 2 %; a resonance leaves as few as five
    # lines that count in a band, for which z is wider than normal by a tenth
    assert 0.95 < np.sqrt(np.mean(np.square(z))) < 1.12
    assert 0.95 < np.sqrt(np.mean(np.square(z_mass))) < 1.12
    # what is joined is chosen without looking at how it came out: no bias above its error
    assert abs(np.mean(z)) < 4 / np.sqrt(len(z))


def test_the_force_is_split_into_what_packings_share_and_what_is_their_own():
    # red: `max(of, 0.0)` → `0.0` in approximate
    rng = np.random.default_rng(5)
    legs = stand_in(
        rng, lambda f: 700 + 0 * f, lambda f: 0 * f, common=0.2, own=0.6, periods=(20.0,)
    )
    found = approximate(legs, EDGES)
    # a band of n lines knows a PSD to 1/√n: 240 lines in the narrowest
    assert found.common_psd == pytest.approx(0.2, rel=0.5)
    assert found.own_psd == pytest.approx(0.6, rel=0.3)
    assert np.mean(found.common_psd) == pytest.approx(0.2, rel=0.1)
    assert np.mean(found.own_psd) == pytest.approx(0.6, rel=0.1)


def test_coherence_is_the_share_of_the_linear_part():
    # red: `np.abs(linear) ** 2` → `np.abs(linear) * 2` in _coherence; `power + float` → `power - float`
    f = np.arange(100.0, 200.0, 0.1)
    rng = np.random.default_rng(7)
    v = 1e-3 * np.exp(1j * rng.uniform(0, 2 * np.pi, f.size))
    noise = complex_noise(rng, 0.3 * np.ones(f.size), (2,))
    found = approximate([Leg(f, v, 700 * v + noise)], np.array([100.0, 200.0]))
    # 0.7² of 0.7² + 0.3, known to 3 % from a thousand lines
    assert found.coherence == pytest.approx(0.49 / 0.79, rel=0.05)


def test_two_lines_make_a_band_and_one_joins_the_next():
    # red: `part.frequency.size < 2` → `part.frequency.size < 3` in _bands, or `< 1`
    f = np.array([100.0, 110.0, 140.0, 160.0, 170.0])
    v = np.array([1.0, 1j, -1.0, 1.0, 1j])
    found = approximate([Leg(f, v, 5 * v[None])], np.array([100.0, 130.0, 150.0, 200.0]))
    assert found.low.tolist() == [100, 130]
    assert found.high == pytest.approx([130, 200])
    with pytest.raises(ValueError, match="no band with two lines between 300 and 400 Hz"):
        approximate([Leg(f, v, 5 * v[None])], np.array([300.0, 400.0]))
    (band,) = approximate([Leg(f[:2], v[:2], 5 * v[None, :2])], np.array([100.0, 110.0])).high
    assert band == pytest.approx(110, rel=1e-6)  # its highest line belongs to it


def test_of_one_packing_all_that_is_not_linear_counts_as_its_own():
    # red: `return 0.0` → `return 1.0` under `if count < 2`
    legs = stand_in(
        np.random.default_rng(6), lambda f: 700 + 0 * f, lambda f: 0 * f, own=0.5, packings=1
    )
    found = approximate(legs, EDGES)
    assert (found.common_psd == 0).all()
    assert found.own_psd.mean() == pytest.approx(0.5, rel=0.2)
    # the mean of a variance that is known as well as by four differences
    assert found.packing_error == pytest.approx(np.sqrt(2) * PACKING, rel=1e-12)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.07])
def test_packings_that_differ_are_a_part_of_the_error(spread):
    """C_e of 200 sets of four packings about the mean of all: z of the mean over bands."""
    # red: `variance / count` → `variance / count**2` in _packing_error
    z, stated = [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        legs = stand_in(
            rng, lambda f: 700 + 0 * f, lambda f: 0 * f, own=0.02, spread=spread, packings=4
        )
        found = approximate(legs, EDGES)
        off = found.equivalent_damping / 700 - 1
        noise = found.equivalent_damping_error / 700
        weight = 1 / noise**2
        error = np.hypot(found.packing_error, 1 / np.sqrt(weight.sum()))
        z.append(np.sum(weight * off) / weight.sum() / error)
        stated.append(found.packing_error)
    # 200 values know their rms to 5 %; stated is what is known beforehand, 5 %, as much as what is
    # seen, so that none states nothing where there is none
    rms = np.sqrt(np.mean(np.square(z)))
    assert rms < 1.3
    assert rms > 0.85 or spread == 0
    assert spread / 2 < 1.4 * np.mean(stated) < 1.4 * max(spread, 0.07)


def test_legs_of_different_packings_are_refused():
    # red: `!= 1` → `< 1` in approximate
    one, two = (
        stand_in(np.random.default_rng(1), lambda f: 1 + f, lambda f: f, packings=n) for n in (1, 2)
    )
    with pytest.raises(ValueError, match="different numbers of packings"):
        approximate([one[0], two[0]], EDGES)


# ----------------------------------------------------------------------- second opinions

RATE, COUNT, REALISATIONS = 2000.0, 1000, 40


def shaken_box(rng):
    """Accelerations and forces (realisations, samples) of a mass in a box on a spring with a stop.

    A nonlinear element, integrated until its motion repeats; velocity is what drives it.
    """
    lines = np.arange(25, 400)
    spectrum = np.zeros((REALISATIONS, COUNT // 2 + 1), complex)
    spectrum[:, lines] = np.exp(1j * rng.uniform(0, 2 * np.pi, (REALISATIONS, lines.size)))
    v = np.fft.irfft(spectrum * COUNT / np.sqrt(lines.size), COUNT)
    force = np.zeros_like(v)
    state = np.zeros(REALISATIONS)
    for _ in range(4):  # periods; the memory is of 20 samples
        for i in range(COUNT):
            state += 0.05 * (v[:, i] - state)
            force[:, i] = 3 * v[:, i] + state + 0.8 * v[:, i] ** 3
    return lines, v, force


def as_legs(lines, v, force):
    period = COUNT / RATE
    scale = COUNT / np.sqrt(2 * period)
    return [
        Leg(lines / period, np.fft.rfft(a)[lines] / scale, np.fft.rfft(b)[None, lines] / scale)
        for a, b in zip(v, force, strict=True)
    ]


def test_it_agrees_with_the_cross_spectra_of_scipy():
    # red: `lines.velocity.conj()` → `lines.velocity` in _fit
    lines, v, force = shaken_box(np.random.default_rng(3))
    found = approximate(as_legs(lines, v, force), np.array([50.0, 100, 200, 400, 800]))
    once = {"fs": RATE, "nperseg": COUNT, "noverlap": 0, "window": "boxcar", "detrend": False}
    f, cross = signal.csd(v.ravel(), force.ravel(), **once)
    _, power = signal.welch(v.ravel(), **once)
    for low, high, damping in zip(found.low, found.high, found.equivalent_damping, strict=True):
        some = (f >= low) & (f < high) & (f < 799)
        assert damping == pytest.approx(cross[some].real.sum() / power[some].sum(), rel=1e-9)


@pytest.mark.skipif(
    importlib.util.find_spec("best_linear_approximation") is None,
    reason="best-linear-approximation needs Python 3.12",
)
def test_it_agrees_with_the_package_best_linear_approximation():
    """The robust method of Pintelon and Schoukens as M. Floren has it (MIT)."""
    # red: `damping * cross.real` → `2 * damping * cross.real` in _fit
    from best_linear_approximation import robust

    lines, v, force = shaken_box(np.random.default_rng(4))
    theirs = robust.known_input(
        v.T[:, None, :], force.T[:, None, :, None], RATE, excited_bins=lines, show_warnings=False
    )
    value = np.squeeze(theirs.G.value)
    ours = approximate(as_legs(lines, v, force), np.array([50.0, 100, 200, 400, 800]))
    f = lines * RATE / COUNT
    for low, high, damping in zip(ours.low, ours.high, ours.equivalent_damping, strict=True):
        some = (f >= low) & (f < high)
        assert damping == pytest.approx(np.mean(value[some].real), rel=1e-9)
