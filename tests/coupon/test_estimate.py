"""How long a sweep will take is a count of what it will run."""

import pytest

from pidpanel.coupon import estimate
from pidpanel.coupon.from_study import cases_of
from pidpanel.study.coupon import Coupon

SWEEP = {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [10]}


def coupon(**changes):
    values = {
        "sweep": SWEEP,
        "accuracy": {"relative_error": 0.05, "seeds": 2, "min_cycles": 20, "max_cycles": 300},
    }
    return Coupon.model_validate(values | changes)


def test_twice_the_seeds_take_twice_as_long(tmp_path):
    accuracy = {"relative_error": 0.5, "min_cycles": 20, "max_cycles": 300}
    two, four = (
        estimate.cpu_seconds(cases_of(coupon(accuracy={**accuracy, "seeds": n})), tmp_path)
        for n in (2, 4)
    )
    assert four == pytest.approx(2 * two)


def test_what_is_there_already_costs_nothing(tmp_path):
    cases = cases_of(coupon())
    before = estimate.cpu_seconds(cases, tmp_path)
    bed = cases[0].point.bed
    for folder, made in (("bed", bed), ("packing", bed.packing)):
        file = tmp_path / folder / made.label / f"{folder}.json"
        file.parent.mkdir(parents=True)
        file.touch()
    after = estimate.cpu_seconds(cases, tmp_path)
    assert 0 < after < before
    assert estimate.cpu_seconds([], tmp_path) == 0


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
    (slow,), (fast,) = (cases_of(coupon(sweep={**SWEEP, "acceleration_g": [g]})) for g in (10, 20))
    step = slow.point.time_step / fast.point.time_step
    spheres = estimate.spheres_in(slow.point.packing, 0.5)
    still = estimate.STEP + spheres * estimate.PER_SPHERE
    moved = [estimate.steps_seconds(case.point, 1.0) - still for case in (slow, fast)]
    assert moved[1] * step == pytest.approx(2 * moved[0])
