"""The scatter between packings: found in numbers that have one, none where there is none."""

import numpy as np
import pytest

from pidpanel.coupon import cycles


def drawn(scatter, error, seeds=2, cases=400, seed=1):
    """Seeds of cases with means over three decades."""
    rng = np.random.default_rng(seed)
    true = 10 ** rng.uniform(1, 4, cases)
    own = error * true[:, None] * rng.uniform(0.3, 1.7, (cases, seeds))
    beds = true[:, None] * (1 + scatter * rng.normal(size=(cases, seeds)))
    return list(beds + own * rng.normal(size=own.shape)), list(own)


@pytest.mark.parametrize("seeds", [2, 4])
@pytest.mark.parametrize(("scatter", "error"), [(0.05, 0.005), (0.05, 0.05), (0.02, 0.02)])
def test_the_scatter_that_was_drawn_is_found(scatter, error, seeds):
    # 400 pairs know a variance of their own to 7 %, where the errors are as large as the scatter
    # to twice that
    found = cycles.scatter_of_packings(*drawn(scatter, error, seeds))
    assert found == pytest.approx(scatter, rel=0.15)


def test_where_errors_explain_the_scatter_there_is_none():
    means, _ = drawn(0.0, 0.02)
    assert cycles.scatter_of_packings(means, [0.05 * c for c in means]) == 0.0
    assert cycles.scatter_of_packings([np.array([3.0])], [np.array([0.1])]) == 0.0
    assert cycles.scatter_of_packings([], []) == 0.0


@pytest.mark.parametrize(
    ("deviation", "error", "scatter"),
    [(0.1, 0.1 * np.sqrt(2 / 1.5), 0.1 * np.sqrt(2 / 3)), (0.5, 0.0, np.sqrt(0.5)), (0.9, 0.0, 1)],
)
def test_a_single_pair_has_the_scatter_that_its_deviation_leaves(deviation, error, scatter):
    # 2 d²/(e² + s²) = 1, with s at most 1
    pair = 3.0 * np.array([1 - deviation, 1 + deviation])
    found = cycles.scatter_of_packings([pair], [np.full(2, 3.0 * error)])
    assert found == pytest.approx(scatter, rel=1e-6)


def test_a_bed_with_few_cases_is_judged_by_all_and_states_apart_by_none():
    means, errors = drawn(0.05, 0.001, cases=60)
    other_means, other_errors = drawn(0.01, 0.001, cases=60, seed=9)
    groups = ["half"] * 60 + ["full"] * 57 + ["few"] * 3
    alike = np.ones(120, bool)
    alike[0] = False
    means[0] = means[0] * np.array([1.0, 9.0])
    both = means + other_means, errors + other_errors
    found = cycles.scatter_by_group(groups, *both, alike)
    assert found["half"] == pytest.approx(0.05, rel=0.25)
    assert found["full"] == pytest.approx(0.01, rel=0.25)
    assert found["few"] == cycles.scatter_of_packings(both[0][1:], both[1][1:])


def test_the_mean_of_seeds_is_as_uncertain_as_runs_and_packings_make_it():
    found = cycles.packed(np.array([90.0, 110.0]), np.array([3.0, 4.0]), 0.05)
    assert found == pytest.approx(np.sqrt(9 + 16 + 25 + 25) / 2)
