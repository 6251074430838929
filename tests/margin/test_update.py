"""The answer after tests that have been made, against linear algebra, and results that are wrong."""

import numpy as np
import pytest
from scipy.stats import norm

from pidpanel.margin.assessment import PointAnswer
from pidpanel.margin.chaos import fitted
from pidpanel.margin.next_test import Observable, joined, posterior
from pidpanel.margin.update.posterior import Emulator, Result
from pidpanel.margin.update.updated import Updated, input_rows

SCORES = np.random.default_rng(21).standard_normal((128, 3)).clip(-3, 3)


def result(columns, error, value, **options):
    errors = np.full(columns.shape[1], error)
    return Result(
        "test", Observable(columns, errors, **options), np.array(value), "ab"[: len(value)]
    )


def test_of_linear_tests_the_posterior_is_that_of_linear_algebra():
    B = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, -1.0]])
    test = result(SCORES @ B.T, 0.3, [0.6, -0.3], common=0.6)
    z, effective = Emulator(SCORES, [test]).posterior()
    C = posterior(*joined(SCORES, [test.observable]))
    R = 0.3**2 * np.eye(2) + 0.6**2
    assert effective == pytest.approx(1.0, abs=1e-3)  # less what lies beyond 3 σ
    assert z.mean(axis=0) == pytest.approx(C @ B.T @ np.linalg.solve(R, test.value), abs=0.03)
    assert np.cov(z, rowvar=False) == pytest.approx(C, abs=0.03)  # of 8192 samples


def test_of_a_curved_test_the_posterior_is_that_of_a_quadrature():
    """One score: Bayes' rule on a fine grid, no normal distribution."""
    curve = np.exp(0.5 * SCORES[:, :1])
    z, effective = Emulator(SCORES, [result(curve, 0.3, [0.7])]).posterior()
    grid = np.linspace(-6, 6, 20001)
    weight = norm.pdf(grid) * norm.pdf((np.exp(0.5 * grid.clip(-3, 3)) - 0.7) / 0.3)
    share = np.cumsum(weight) / weight.sum()
    exact = np.interp([0.05, 0.5, 0.95], share, grid)
    assert np.quantile(z[:, 0], [0.05, 0.5, 0.95]) == pytest.approx(exact, abs=0.05)
    assert effective > 0.25


def test_what_the_chaos_misses_counts_as_error():
    rough = SCORES[:, :1] + 0.5 * np.random.default_rng(22).standard_normal((128, 1))
    z, _ = Emulator(SCORES, [result(rough, 0.01, [1.0])]).posterior()
    # more than by the scatter alone, since the chaos of 128 runs is fitted to it too
    assert np.sqrt(0.25 / 1.25) < z[:, 0].std() < 1.5 * np.sqrt(0.25 / 1.25)


def test_an_error_of_the_damping_that_is_another_at_the_test_tells_nothing_of_the_launch():
    linear = SCORES[:, :1]
    for common, left in ((1.0, 0.01), (0.6, 1 - 0.36), (0.0, 1.0)):
        test = result(linear, 0.1, [1.0], common_damping=common)
        z, _ = Emulator(SCORES, [test], [slice(0, 1)]).posterior()
        assert z[:, 0].var() == pytest.approx(left, rel=0.06, abs=0.003)
        assert z.shape[1] == 3


def test_results_of_laboratories_within_the_spreads_are_seldom_improbable():
    B = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, -1.0]])
    emulator = Emulator(SCORES, [result(np.exp(0.3 * SCORES @ B.T), 0.8, [1.0, 1.0])])
    rng, found = np.random.default_rng(23), []
    for z in rng.standard_normal((100, 3)):
        emulator.value = np.exp(0.3 * B @ z) + 0.8 * rng.standard_normal(2)
        found.append(emulator.probability()[0])
    assert 0.01 <= np.mean(np.array(found) < 0.1) <= 0.2  # 0.05 to 0.1 of 100
    assert min(found) > 1e-3


def test_a_result_outside_the_stated_spreads_is_named_and_not_used():
    good, wrong = result(SCORES[:, :1], 0.1, [1.0]), result(SCORES[:, 1:], 0.1, [0.0, 9.0])
    updated = Updated.by(SCORES, [good, wrong._replace(name="survey")], [])
    rows = [(row["test"], row["quantity"], row["probability"] < 1e-3) for row in updated.tests]
    assert rows == [("test", "a", False), ("survey", "a", True), ("survey", "b", True)]
    assert updated.tests[2]["score"] == pytest.approx(9 / np.hypot(1, 0.1), rel=0.1)
    assert updated.scores[:, 0].std() < 0.2
    assert updated.scores[:, 1:].std(axis=0) == pytest.approx([1, 1], abs=0.05)


def test_tests_that_contradict_each_other_are_improbable_together():
    pair = [result(SCORES[:, :1], 0.1, [value]) for value in (1.5, -1.5)]
    updated = Updated.by(SCORES, pair, [])
    assert all(row["probability"] > 0.1 for row in updated.tests)
    assert updated.tests[0]["probability_together"] < 1e-3


def test_ranges_inputs_and_shares_after_a_test_are_those_of_what_is_left():
    g = 20 + 3 * SCORES[:, 0] + 4 * SCORES[:, 1]
    answer = PointAnswer("A", "1", "damped", 20.0, g, 25.0, fitted(SCORES, g, is_log=False))
    updated = Updated.by(SCORES, [result(SCORES[:, :1], 0.5, [1.0])], [])
    g_after = answer.chaos(updated.scores)
    assert [g_after.mean(), g_after.std()] == pytest.approx(
        [20 + 3 * 0.8, np.sqrt(9 * 0.2 + 16)], rel=0.02
    )
    parts = [slice(0, 1), slice(1, 2), slice(2, 3)]
    rows = updated.share_rows(answer, ["zeta", "level", "air"], ["", "", ""], parts)
    assert [row["input"] for row in rows][:2] == ["level", "zeta"]
    assert rows[0]["share_alone"] == pytest.approx(16 / 17.8, abs=0.02)
    assert rows[0]["share"] == pytest.approx(16 / 17.8, abs=0.02)
    row = input_rows(["zeta"], updated.stated[:, :1], updated.scores[:, :1])[0]
    assert row["stated_p95"] == pytest.approx(1.645, abs=0.06)
    assert row["updated_p50"] == pytest.approx(0.8, abs=0.03)
