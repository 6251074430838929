"""Ranges, probabilities and margins of answers with known distributions."""

import numpy as np
import pytest
from scipy.stats import norm

from pidpanel.margin.assessment import PointAnswer, governing, range_row, share_rows
from pidpanel.margin.chaos import Chaos, fitted

SCORES = np.random.default_rng(4).standard_normal((128, 2)).clip(-3, 3)  # where spreads end


def answer(mean, deviation, panel="damped", scenario="A", point="1", limit=25.0):
    values = mean + deviation * SCORES[:, 0]
    chaos = fitted(SCORES, values)
    return PointAnswer(scenario, point, panel, mean, values, limit, chaos)


def test_a_normal_answer_has_the_quantiles_and_the_probability_of_the_normal_distribution():
    normal = answer(20.0, 3.0)
    row = range_row(normal, normal.drawn(2), 1.25)
    assert [row["p05_g"], row["p50_g"], row["p95_g"]] == pytest.approx(
        norm(20, 3).ppf([0.05, 0.5, 0.95]), abs=0.15
    )  # of 16384 samples
    assert row["probability_exceeding"] == pytest.approx(norm(20, 3).sf(25), abs=0.006)
    assert row["margin_of_safety_p50"] == pytest.approx(25 / (1.25 * row["p50_g"]) - 1)
    assert row["margin_of_safety_p95"] == pytest.approx(25 / (1.25 * row["p95_g"]) - 1)


def test_a_surrogate_that_explains_too_little_is_not_sampled():
    poor = answer(20.0, 3.0)
    poor = poor._replace(chaos=Chaos(poor.chaos.degrees, 0 * poor.chaos.coefficient, 0.5))
    assert range_row(poor, poor.drawn(2), 1.0)["p95_g"] == np.quantile(poor.values, 0.95)


def test_the_worst_point_and_level_of_the_best_layout_govern_by_the_limit():
    answers = [
        answer(30.0, 1.0, panel="bare"),
        answer(20.0, 1.0, point="1"),
        answer(10.0, 1.0, point="2"),
        answer(15.0, 1.0, scenario="B", point="1"),
        answer(9.0, 1.0, scenario="B", point="2", limit=11.0),
        answer(90.0, 1.0, scenario="B", point="3", limit=np.nan),
    ]
    chosen = governing(answers, 2, {"A": "A", "B": "B", "C": "A"})
    assert (chosen.scenario, chosen.point) == ("A", "1")
    louder = answer(25.0, 1.0, scenario="C", point="2")  # A at a higher level
    chosen = governing([*answers[1:3], louder], 2, {"A": "A", "C": "A"})
    assert (chosen.scenario, chosen.point) == ("C", "2")


def test_shares_come_with_their_source_the_largest_first():
    parts = [slice(0, 1), slice(1, 2)]
    rows = list(share_rows(answer(20.0, 1.0), ["zeta", "level"], ["a", "b"], parts))
    assert [(row["input"], row["source"]) for row in rows] == [("zeta", "a"), ("level", "b")]
    assert rows[0]["share"] == pytest.approx(1.0, abs=0.01)  # of 4096 samples
