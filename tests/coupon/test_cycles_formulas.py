"""Rules of the statistics term by term: transients, blocks, drifts and what a bed stores."""

import numpy as np
import pytest

from pidpanel.coupon import cycles


@pytest.mark.parametrize("count", [3, 9, 20, 37, 49, 50, 64, 203])
def test_the_transient_ends_where_the_marginal_standard_error_is_least(count):
    # White (1997) as it stands: Σ_{i≥d}(x_i − x̄_d)²/(n − d)² of each d up to half the series,
    # on batches of five, or of a tenth of a series shorter than fifty
    # red: / kept twice → once in `transient_end`; n // 2 + 1 → n; min(5, …) → max
    rng = np.random.default_rng(count)
    for start in (0.0, 0.5, 4.0):
        series = rng.normal(size=count) + start * np.exp(-np.arange(count) / (count / 8))
        size = 5 if count >= 50 else max(1, count // 10)
        batches = np.array([series[i : i + size].mean() for i in range(0, count - size + 1, size)])
        n = len(batches)
        marginal = [np.var(batches[d:]) / (n - d) for d in range(n // 2 + 1)]
        assert cycles.transient_end(series) == size * int(np.argmin(marginal))


def test_the_block_error_is_the_largest_of_the_levels():
    # 17 values: 17 single ones, then 8 means of pairs from the end, and no fewer than 8
    # red: MIN_BLOCKS = 9; ddof=1 → 2; blocks[len(blocks) - 2 * half :] → blocks[: 2 * half]
    series = np.array([9.0, 1, 2, 1, 2, 5, 6, 5, 6, 1, 2, 1, 2, 5, 6, 5, 6])
    pairs = series[1:].reshape(8, 2).mean(axis=1)
    levels = [np.std(series, ddof=1) / np.sqrt(17), np.std(pairs, ddof=1) / np.sqrt(8)]
    assert levels[1] > levels[0]
    assert cycles.block_error(series) == pytest.approx(levels[1])
    few = np.arange(8.0)
    assert cycles.block_error(few) == pytest.approx(np.std(few, ddof=1) / np.sqrt(8))
    assert cycles.block_error(few[:7]) == np.inf
    assert cycles.block_error(np.ones(20)) == np.inf


def test_a_drift_is_the_difference_of_the_halves_over_its_error():
    # red: halves[1].mean() - halves[0].mean() → +; math.hypot of one half alone
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
    # red: rise[:-1] → rise[1:] in `without_storage`; controls @ multiples with +
    _, stored = stored_series(80)
    rise, series = np.diff(stored), np.full(80, 2.0)
    series[1:-1] += 0.7 * rise[1:] - 0.4 * rise[:-1]
    found = cycles.without_storage(series, stored, 0)
    np.testing.assert_allclose(found[1:-1], 2.0, rtol=1e-12)
    assert (found[0], found[-1]) == (series[0], series[-1])


@pytest.mark.parametrize("start", [0, 1, 6])
def test_the_multiples_are_those_of_least_squares_from_the_start_on(start):
    # by numpy on the rows that are left; three constants are gone from the freedom of the error
    # red: slice(max(start - 1, 0), None) → start; len(steady) - freedom → + in `estimate`
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
    # red: ROWS_FOR_STORAGE = 61; >= → > in `estimate`
    series, stored = stored_series(60)
    alone = cycles.estimate(series, start=0)
    assert cycles.estimate(series, start=0, stored=stored).error < 0.5 * alone.error
    short = cycles.estimate(series[1:], start=0, stored=stored[1:])
    assert short == cycles.estimate(series[1:], start=0)


def test_where_the_transient_leaves_too_few_rows_the_series_stands_as_it_is():
    # a transient of 21 rows that only shows once the stored energy is taken off: 59 of 80 remain
    # red: len(series) - first < ROWS_FOR_STORAGE → >=; 1 + transient_end → 2 +
    series, stored = stored_series(80)
    series[:21] += 1.0
    found = cycles.estimate(series, stored=stored)
    quiet = cycles.without_storage(series, stored, cycles.transient_end(series))
    first = 1 + cycles.transient_end(quiet[1:-1])
    assert 80 - cycles.transient_end(series) >= 60 > 80 - first
    assert found.start == first
    assert found.mean == pytest.approx(series[first:].mean())
    assert found.used == 80 - first


def test_seeds_are_combined_by_the_larger_of_within_and_between():
    # red: / n → * n in `combine`; n > 1 → n > 2
    mean, error = cycles.combine(np.array([1.0, 2.0, 6.0]), np.array([0.3, 0.4, 1.2]))
    assert mean == pytest.approx(3.0)
    assert error == pytest.approx(np.sqrt(7) / np.sqrt(3))
    assert cycles.combine(np.array([1.0]), np.array([0.3])) == pytest.approx((1.0, 0.3))


def test_a_series_without_scatter_has_no_drift_to_speak_of():
    # red: else 0.0 → else 1.0 in `estimate`; and → or
    for series in (np.ones(40), np.repeat([1.0, 2.0], 20)):
        found = cycles.estimate(series, start=0)
        assert found.drift == 0.0
    assert cycles.estimate(np.ones(40), start=0).error == np.inf
