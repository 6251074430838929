"""How long a sweep will take is a count of what it will run."""

import pytest

from pidpanel.coupon import estimate
from pidpanel.coupon.from_study import cases_of
from pidpanel.study.coupon import Coupon

COSTS = estimate.Costs(
    estimate.StepCost(fixed=1e-5, per_sphere=2e-7, per_travel=4e-5),
    poured_sphere=0.02,
    diameter=2e-3,
)


def coupon(**changes):
    values = {
        "sweep": {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [10]},
        "accuracy": {"relative_error": 0.05, "seeds": 2, "min_cycles": 20, "max_cycles": 300},
    }
    return Coupon.model_validate(values | changes)


def test_twice_the_seeds_take_twice_as_long(tmp_path):
    accuracy = {"relative_error": 0.5, "min_cycles": 20, "max_cycles": 300}
    two, four = (
        estimate.cpu_seconds(cases_of(coupon(accuracy={**accuracy, "seeds": n})), COSTS, tmp_path)
        for n in (2, 4)
    )
    assert four == pytest.approx(2 * two)


def test_what_is_there_already_costs_nothing(tmp_path):
    cases = cases_of(coupon())
    before = estimate.cpu_seconds(cases, COSTS, tmp_path)
    assert before > 0
    file = cases[0].outcome_file(tmp_path)
    file.parent.mkdir(parents=True)
    file.touch()
    assert estimate.cpu_seconds(cases, COSTS, tmp_path) == 0


def test_a_tighter_error_asks_for_more_cycles_until_the_most_that_are_allowed():
    def expected(error):
        (case,) = cases_of(
            coupon(accuracy={"relative_error": error, "min_cycles": 20, "max_cycles": 300})
        )
        return estimate.cycles_expected(case.point, case)

    assert expected(0.2) == pytest.approx(estimate.MISSED * 20)
    # 0.35² / (5 cells · 2 · 0.02²), a seventh of a per cent more or less
    assert expected(0.02) == pytest.approx(estimate.MISSED * 0.35**2 / (5 * 2 * 0.02**2))
    assert expected(0.001) == 300


def test_what_moves_far_in_a_step_costs_more():
    assert COSTS.step.seconds(100) == pytest.approx(1e-5 + 100 * 2e-7)
    assert COSTS.step.seconds(100, 0.005) == pytest.approx(1e-5 + 100 * (2e-7 + 0.005 * 4e-5))
