"""From cycle rows to damping: known dampers must come back, and known errors."""

import numpy as np
import pytest

from pidpanel.coupon import cycles

W, F, AREA, MASS = 2e-4, 80.0, 3e-4, 5e-3
OMEGA = 2 * np.pi * F


def momentum_of(force_per_velocity, time):
    """Momentum in the coupon's frame of grains that push the wall by −Re(Z v e^{iωt}).

    Newton for the grains in the lab: M dv/dt = wall force; in the coupon's frame p = M (v − ẇ).
    """
    velocity = OMEGA * W * np.exp(1j * OMEGA * time)  # ẇ = ωW cos ωt
    wall_force = force_per_velocity * velocity
    lab_momentum = wall_force / (1j * OMEGA)
    return (lab_momentum - MASS * velocity).real


@pytest.mark.parametrize(("damping", "mass"), [(900.0, 6.4), (30.0, -0.4), (2e4, 0.0)])
def test_a_dashpot_with_mass_returns_its_own_damping_and_mass(damping, mass):
    time = np.arange(100) / 100 / F
    p = momentum_of((damping + 1j * OMEGA * mass) * AREA, time)
    c, m = cycles.first_harmonic(
        np.array([np.mean(p * np.sin(OMEGA * time))]),
        np.array([np.mean(p * np.cos(OMEGA * time))]),
        amplitude=W, frequency=F, mass=MASS, area=AREA,
    )  # fmt: skip
    # a hundred samples of a pure tone are summed exactly: only rounding is left, and m_a is a
    # difference with M/A = 17 kg/m²
    assert c[0] == pytest.approx(damping, rel=1e-10)
    assert m[0] == pytest.approx(mass, abs=1e-10)


def test_the_energy_of_a_dashpot_is_the_integral_of_its_power():
    time = np.linspace(0, 1 / F, 20001)
    velocity = OMEGA * W * np.cos(OMEGA * time)
    work = np.trapezoid(750.0 * velocity**2, time)
    # the trapezoidal rule over a whole period of a polynomial of sines is exact
    assert cycles.dissipated_energy(750.0, W, F) == pytest.approx(work, rel=1e-12)


def test_the_bound_is_four_times_the_peak_energy_of_an_inelastic_slug():
    # E_d = 4 m″ (ωW)² at a clear gap of πW, data/reference of the inelastic slug in a box
    bound = cycles.inelastic_bound(2.0, F)
    assert cycles.dissipated_energy(bound, W, F) == pytest.approx(4 * 2.0 * (OMEGA * W) ** 2)
    assert cycles.loss_factor(bound, 2.0, F) == pytest.approx(4 / np.pi)


def correlated(rng, n, memory):
    """AR(1) of unit variance: its mean has the variance (1 + φ)/(1 − φ)/n for large n."""
    noise = rng.standard_normal(n) * np.sqrt(1 - memory**2)
    series = np.empty(n)
    series[0] = rng.standard_normal()
    for i in range(1, n):
        series[i] = memory * series[i - 1] + noise[i]
    return series


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8])
def test_the_block_error_covers_the_error_of_a_correlated_mean(memory):
    rng = np.random.default_rng(7)
    n = 400
    truth = np.sqrt((1 + memory) / (1 - memory) / n)
    errors = [cycles.block_error(correlated(rng, n, memory)) for _ in range(200)]
    # the largest over the levels errs to the safe side: 1 to 1.5 times the truth on average
    assert 0.95 < np.mean(errors) / truth < 1.5


def test_a_plain_standard_error_would_be_too_small_for_a_correlated_series():
    rng = np.random.default_rng(8)
    series = correlated(rng, 400, 0.8)
    plain = np.std(series, ddof=1) / np.sqrt(len(series))
    # (1 + φ)/(1 − φ) = 9: three times; half of that is far from what one draw scatters by
    assert cycles.block_error(series) > 1.5 * plain


def test_the_transient_is_found_where_it_ends():
    rng = np.random.default_rng(3)
    found = []
    for _ in range(50):
        series = 1 + 0.05 * rng.standard_normal(200)
        series[:40] += 2 * np.exp(-np.arange(40) / 12)
        found.append(cycles.transient_end(series))
    # at 30 the surplus is 0.16, three times the noise; at 60 it is 0.01, a fifth of it
    assert 30 <= np.median(found) <= 60


def test_a_series_that_never_settles_is_cut_at_half():
    assert cycles.transient_end(np.linspace(2, 1, 200)) >= 90


def test_drift_is_flagged_and_steadiness_is_not():
    rng = np.random.default_rng(5)
    noise = 0.05 * rng.standard_normal(200)
    assert abs(cycles.estimate(1 + noise, start=0).drift) < 3
    assert cycles.estimate(1 + noise + np.linspace(0, 0.2, 200), start=0).drift > 3


def locked(rng, n):
    """A bed that lands every third cycle: what one cycle stores, the next ones give back."""
    phase = 2 * np.pi * np.arange(n + 1) / 3
    stored = 5 + 3 * np.sin(phase) + 0.2 * rng.standard_normal(n + 1)
    return 1 + np.diff(stored) + 0.05 * rng.standard_normal(n), stored[1:]


def test_what_a_bed_only_stores_takes_no_part_in_the_error():
    rng = np.random.default_rng(11)
    found = []
    for _ in range(100):
        series, stored = locked(rng, 100)
        found.append(cycles.estimate(series, stored=stored))
    means, errors = np.array([(one.mean, one.error) for one in found]).T
    # the loss is 1; a tenth of the scatter of the means is their own error, from 100 tries
    assert abs(means.mean() - 1) < 3 * means.std() / 10
    assert errors.mean() < 0.25 * cycles.block_error(locked(rng, 100)[0])
    # the error says what the means scatter by, from 100 tries known to 7 %
    assert 0.8 < errors.mean() / means.std() < 2


def test_storage_leaves_short_and_still_runs_alone():
    rng = np.random.default_rng(12)
    series, stored = locked(rng, 40)
    assert cycles.estimate(series, stored=stored) == cycles.estimate(series)
    series = 1 + 0.05 * rng.standard_normal(200)
    alone, still = cycles.estimate(series), cycles.estimate(series, stored=np.ones(200))
    assert still.mean == pytest.approx(alone.mean, abs=0.2 * alone.error)


def test_seeds_that_disagree_widen_the_error():
    mean, error = cycles.combine(np.array([10.0, 12.0]), np.array([0.1, 0.1]))
    assert mean == 11.0
    assert error == pytest.approx(1.0)  # s/√n = √2/√2


def test_seeds_that_agree_keep_their_own_error():
    _, error = cycles.combine(np.array([10.0, 10.0]), np.array([0.3, 0.4]))
    assert error == pytest.approx(0.25)  # √(0.3² + 0.4²)/2
