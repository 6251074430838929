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
    # E_d = 4 m″ (ωW)² at a clear gap of πW, of the inelastic slug in a box (damping/inelastic.py)
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


@pytest.mark.parametrize("count", [3, 9, 20, 37, 49, 50, 64, 203])
def test_the_transient_ends_where_the_marginal_standard_error_is_least(count):
    # White (1997) as it stands: Σ_{i≥d}(x_i − x̄_d)²/(n − d)² of each d up to half the series,
    # on batches of five, or of a tenth of a series shorter than fifty
    rng = np.random.default_rng(count)
    for start in (0.0, 0.5, 4.0):
        series = rng.normal(size=count) + start * np.exp(-np.arange(count) / (count / 8))
        size = 5 if count >= 50 else max(1, count // 10)
        batches = np.array([series[i : i + size].mean() for i in range(0, count - size + 1, size)])
        n = len(batches)
        marginal = [np.var(batches[d:]) / (n - d) for d in range(n // 2 + 1)]
        assert cycles.transient_end(series) == size * int(np.argmin(marginal))


def test_a_drift_is_the_difference_of_the_halves_over_its_error():
    series = np.random.default_rng(4).normal(size=90) + np.linspace(0, 1, 90)
    found = cycles.estimate(series, start=10)
    first, second = series[10:50], series[50:]
    spread = np.hypot(cycles.block_error(first), cycles.block_error(second))
    assert found.drift == pytest.approx((second.mean() - first.mean()) / spread)
    assert (found.start, found.used) == (10, 80)
    assert found.mean == pytest.approx(series[10:].mean())
    assert found.error == pytest.approx(cycles.block_error(series[10:]))


def stored_series(count, seed=5):
    rng = np.random.default_rng(seed)
    stored = 5 + 3 * np.sin(2 * np.pi * np.arange(count) / 3.2) + rng.normal(size=count)
    rise = np.diff(stored)
    series = 2 + rng.normal(size=count) * 0.1
    series[1:-1] += 0.7 * rise[1:] - 0.4 * rise[:-1]
    return series, stored


def test_what_follows_the_stored_energy_alone_is_taken_off_to_the_last_digit():
    _, stored = stored_series(80)
    rise, series = np.diff(stored), np.full(80, 2.0)
    series[1:-1] += 0.7 * rise[1:] - 0.4 * rise[:-1]
    found = cycles.without_storage(series, stored, 0)
    np.testing.assert_allclose(found[1:-1], 2.0, rtol=1e-12)
    assert (found[0], found[-1]) == (series[0], series[-1])


@pytest.mark.parametrize("start", [0, 1, 6])
def test_the_multiples_are_those_of_least_squares_from_the_start_on(start):
    # by numpy on the rows that are left; three constants are gone from the freedom of the error
    series, stored = stored_series(90)
    rise, first = np.diff(stored), max(start, 1)
    controls = np.column_stack([rise[1:], rise[:-1]])[first - 1 :]
    rows = series[first:-1]
    design = np.column_stack([np.ones(len(rows)), controls])
    expected = rows - controls @ np.linalg.lstsq(design, rows)[0][1:]
    np.testing.assert_allclose(
        cycles.without_storage(series, stored, start)[first:-1], expected, rtol=1e-9
    )
    found = cycles.estimate(series, start=start, stored=stored)
    n = len(rows)
    assert found.mean == pytest.approx(expected.mean(), rel=1e-9)
    lost = np.sqrt((n - 1) / (n - 3))
    assert found.error == pytest.approx(lost * cycles.block_error(expected), rel=1e-9)
    a, b = np.array_split(expected, 2)
    spread = lost * np.hypot(cycles.block_error(a), cycles.block_error(b))
    assert found.drift == pytest.approx((b.mean() - a.mean()) / spread, rel=1e-6)


def test_sixty_rows_are_enough_for_the_stored_energy_and_fifty_nine_are_not():
    series, stored = stored_series(60)
    alone = cycles.estimate(series, start=0)
    assert cycles.estimate(series, start=0, stored=stored).error < 0.5 * alone.error
    short = cycles.estimate(series[1:], start=0, stored=stored[1:])
    assert short == cycles.estimate(series[1:], start=0)


def test_seeds_are_combined_by_the_larger_of_within_and_between():
    mean, error = cycles.combine(np.array([1.0, 2.0, 6.0]), np.array([0.3, 0.4, 1.2]))
    assert mean == pytest.approx(3.0)
    assert error == pytest.approx(np.sqrt(7) / np.sqrt(3))
    assert cycles.combine(np.array([1.0]), np.array([0.3])) == pytest.approx((1.0, 0.3))


def test_a_series_without_scatter_has_no_drift_to_speak_of():
    for series in (np.ones(40), np.repeat([1.0, 2.0], 20)):
        found = cycles.estimate(series, start=0)
        assert found.drift == 0.0
    assert cycles.estimate(np.ones(40), start=0).error == np.inf
