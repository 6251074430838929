"""How long a sweep will take is a count of what it will run."""

import numpy as np
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
    file = cases[0].outcomes(tmp_path)[0]
    file.parent.mkdir(parents=True)
    file.touch()
    assert estimate.cpu_seconds(cases, COSTS, tmp_path) == pytest.approx(before / 2)
    cases[0].outcomes(tmp_path)[1].parent.mkdir(parents=True)
    cases[0].outcomes(tmp_path)[1].touch()
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
    assert COSTS.step.of(100) == pytest.approx(1e-5 + 100 * 2e-7)
    assert COSTS.step.of(100, 0.005) == pytest.approx(1e-5 + 100 * (2e-7 + 0.005 * 4e-5))


def test_no_share_of_a_step_is_negative():
    rows = np.array([[1, 30, 0.01], [1, 30, 0.2], [1, 150, 0.05], [1, 150, 1.0]])
    fitted = estimate._fitted(rows, rows @ [1e-5, 2e-7, 4e-5])
    assert (fitted.fixed, fitted.per_sphere, fitted.per_travel) == pytest.approx((1e-5, 2e-7, 4e-5))
    # a machine whose noise makes fast spheres cheaper
    noisy = estimate._fitted(rows, rows @ [1e-5, 2e-7, -1e-5])
    assert noisy.per_travel == 0
    assert noisy.per_sphere > 0


@pytest.mark.liggghts
def test_the_probe_finds_what_a_pour_and_a_step_cost():
    sweep = {"fill_fraction": [0.5], "frequency_hz": [100, 500], "acceleration_g": [10, 80]}
    costs = estimate.probe(cases_of(coupon(sweep=sweep)))
    # 10 µs a step, 0.2 µs a sphere and 0.05 CPU-s a poured sphere were measured; a slow or a
    # busy machine is within ten
    assert 1e-5 < costs.step.of(144) < 4e-4
    assert 2e-3 < costs.poured_sphere < 0.5
    assert costs.step.of(144) > costs.step.of(10)
