"""What a test would leave of the variance, against nested sampling and normal distributions."""

import numpy as np
import pytest

from pidpanel.margin.assessment import PointAnswer
from pidpanel.margin.chaos import fitted
from pidpanel.margin.next_test import Observable, joined, posterior, remaining
from pidpanel.margin.next_test import test_rows as rows_of
from pidpanel.margin.observations import measurements_of
from pidpanel.study.uncertain import Errors

RNG = np.random.default_rng(11)
SCORES = RNG.standard_normal((256, 3)).clip(-3, 3)  # where spreads end


def test_of_a_linear_answer_the_normal_distribution_is_left():
    chaos = fitted(SCORES, 5 + 3 * SCORES[:, 0] + 4 * SCORES[:, 1])
    test = Observable(SCORES[:, :1], np.array([0.5]))
    share, width = remaining(chaos, posterior(*joined(SCORES, [test])))
    left = (9 * 0.2 + 16) / 25  # 1/(1 + 1/0.5²) of the first score
    assert share == pytest.approx(left, abs=0.01)
    assert width == pytest.approx(2 * 1.6449 * 5 * np.sqrt(left), rel=0.02)


def test_of_a_curved_answer_nested_sampling_leaves_the_same():
    """Outer samples of the result, inner ones by importance: no linear algebra."""

    def answer(z):
        return np.exp(0.3 * z[:, 0] - 0.2 * z[:, 1]) + 0.1 * z[:, 1] * z[:, 2]

    chaos = fitted(SCORES, answer(SCORES))
    test = Observable(SCORES @ np.array([[1.0], [0.5], [0.0]]), np.array([0.4]))
    share, _ = remaining(chaos, posterior(*joined(SCORES, [test])))
    z = RNG.standard_normal((20000, 3))
    shown, values = z[:, 0] + 0.5 * z[:, 1], answer(z)
    variances = []
    for row in RNG.standard_normal((4000, 3)):
        result = row[0] + 0.5 * row[1] + 0.4 * RNG.standard_normal()
        weight = np.exp(-((result - shown) ** 2) / (2 * 0.4**2))
        weight /= weight.sum()
        variances.append(weight @ values**2 - (weight @ values) ** 2)
    assert share == pytest.approx(np.mean(variances) / np.var(values), abs=0.02)


def test_a_measurement_on_the_first_runs_only_shows_what_it_shows_on_all():
    """Noise of the runs counts as error, whatever the number of runs that fit it."""
    noise = 0.3 * RNG.standard_normal((256, 40))
    whole = Observable(SCORES[:, :1] + noise, np.full(40, 0.1))
    first = whole._replace(values=whole.values[:8])
    errors = [np.mean(np.diag(joined(SCORES, [test])[1])) for test in (whole, first)]
    assert errors == pytest.approx([0.1, 0.1], rel=0.2)  # 0.3² + 0.1²; 160 degrees of freedom


def test_scatter_of_few_runs_tells_nothing_of_inputs_that_no_channel_shows():
    """Forty channels of one score with scatter; without a limit of chance 0.3 would be left."""
    rng = np.random.default_rng(12)
    z = rng.standard_normal((96, 31))
    shown = z[:, :1] + 0.1 * rng.standard_normal((96, 40))
    C = posterior(*joined(z, [Observable(shown, np.full(40, 0.01))]))
    assert np.diag(C)[1:].mean() > 0.97
    assert C[0, 0] < 0.01


def test_two_runs_of_a_panel_are_no_independent_evidence_of_its_inputs():
    """Ten inputs of 48 panels, of two runs each, and scatter that a panel has in both."""
    rng = np.random.default_rng(13)
    z = rng.standard_normal((96, 12))
    z[1::2, :10] = z[::2, :10]
    shown = z[:, 10:11] + 0.1 * np.repeat(rng.standard_normal((48, 400)), 2, axis=0)
    B, _ = joined(z, [Observable(shown, np.full(400, 0.01))])
    assert np.mean(B[:, :10] != 0) < 0.01  # 0.003 beyond three standard errors
    assert np.all(B[:, 10] != 0)


def test_an_error_common_to_all_channels_does_not_average_out():
    channels = np.repeat(SCORES[:, :1], 50, axis=1)
    alone = Observable(channels, np.full(50, 0.5))
    common = alone._replace(common=0.5)
    left = [posterior(*joined(SCORES, [test]))[0, 0] for test in (alone, common)]
    assert left == pytest.approx([1 / (1 + 50 / 0.25), 1 / (1 + 1 / (0.25 + 0.25 / 50))], rel=1e-6)


def test_an_error_of_the_damping_that_is_another_at_the_test_tells_nothing_of_the_launch():
    test = Observable(SCORES[:, :1], np.array([1e-3]), common_damping=0.0)
    C = posterior(*joined(SCORES, [test], [slice(0, 1)]))
    assert C[0, 0] == pytest.approx(1.0)
    shared = posterior(*joined(SCORES, [test._replace(common_damping=1.0)], [slice(0, 1)]))
    assert shared[0, 0] < 1e-5


def test_the_most_useful_measurement_comes_first_and_two_leave_no_more_than_one():
    chaos = fitted(SCORES, 2 * SCORES[:, 0] + SCORES[:, 1])
    tests = {
        "weak": Observable(SCORES[:, 1:2], np.array([0.3])),
        "strong": Observable(SCORES[:, :1], np.array([0.3])),
    }
    answer = PointAnswer("A", "1", "damped", 0.0, chaos(SCORES), np.nan, chaos)
    rows = rows_of(answer, answer.drawn(3), SCORES, tests, [])
    names = [row["measurement"] for row in rows]
    assert names == ["none", "strong", "weak", "weak and strong"]
    assert rows[3]["share_left"] < rows[1]["share_left"]
    assert rows[0]["interval_width_g"] == pytest.approx(2 * 1.6449 * np.sqrt(5), rel=0.02)


def test_an_acoustic_test_tells_nothing_of_the_spectrum_of_the_launch():
    shown = SCORES[:, :1] + SCORES[:, 1:2]
    test = Observable(shown, np.array([1e-3]), unseen=[slice(0, 1)])
    C = posterior(*joined(SCORES, [test]))
    assert C[0, 0] == pytest.approx(1)
    assert C[1, 1] < 1e-3
    assert posterior(*joined(SCORES, [test._replace(unseen=())]))[0, 0] < 0.6


def test_modes_above_the_bands_are_not_surveyed():
    runs = {
        "frequency": np.array([[80.0, 110.0, 900.0], [82.0, 105.0, 800.0]]),
        "ratio": np.full((2, 3), 0.01),
        "level": np.zeros((2, 2)),
        "bare_bands": np.ones((2, 1, 2)),
        "damped_bands": np.ones((2, 1, 2)),
        "coupon": np.zeros((2, 0)),
    }
    edges = np.array([[71.0, 89.0], [89.0, 112.0]])
    found = measurements_of(runs, Errors(), edges)
    np.testing.assert_allclose(found["modal survey"].values[0], np.log([80, 110, 0.01, 0.01]))
    high = runs | {"frequency": 10 * runs["frequency"]}
    assert "modal survey" not in measurements_of(high, Errors(), edges)
