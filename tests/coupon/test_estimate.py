"""How long a sweep will take is a count of what it will run."""

import numpy as np
import pytest

from pidpanel.coupon import estimate, probe
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
    assert COSTS.step.seconds(100) == pytest.approx(1e-5 + 100 * 2e-7)
    assert COSTS.step.seconds(100, 0.005) == pytest.approx(1e-5 + 100 * (2e-7 + 0.005 * 4e-5))


def test_no_share_of_a_step_is_negative():
    spheres, travel = np.array([30, 30, 150, 150.0]), np.array([1, 20, 1, 20]) / 3000

    def times(fixed, per_sphere, per_travel):
        return fixed + spheres * (per_sphere + per_travel * travel)

    fitted = estimate.StepCost.fitted(spheres, travel, times(1e-5, 2e-7, 4e-5))
    assert (fitted.fixed, fitted.per_sphere, fitted.per_travel) == pytest.approx((1e-5, 2e-7, 4e-5))
    # a machine whose noise makes fast spheres cheaper
    noisy = estimate.StepCost.fitted(spheres, travel, times(1e-5, 2e-7, -1e-5))
    assert noisy.per_travel == 0
    assert noisy.per_sphere > 0


def test_what_a_probe_measured_becomes_what_a_step_and_a_poured_sphere_cost():
    # red: the time of a pour taken for that of a sphere; times not per step
    spheres, travel = np.array([30, 30, 150, 150.0]), np.array([1, 20, 1, 20]) / 3000
    true = estimate.StepCost(1e-5, 2e-7, 4e-5)
    times = np.array([true.seconds(n, moved) for n, moved in zip(spheres, travel, strict=True)])
    costs = probe.Measured(spheres, travel, times, 200, 5.0, 2e-3).costs
    assert costs.poured_sphere == pytest.approx(5.0 / 200)
    assert costs.diameter == 2e-3
    assert costs.step.seconds(80, 0.002) == pytest.approx(true.seconds(80, 0.002), rel=1e-9)


@pytest.mark.liggghts
def test_the_probe_shakes_the_least_and_the_fullest_bed_as_gently_and_as_hard_as_the_sweep_will():
    # how long that takes is the machine's own affair; what was run is not
    # red: the same fill or the same drive twice; all cells of the sweep poured
    sweep = {
        "fill_fraction": [0.2, 0.4, 0.8],
        "frequency_hz": [100, 500],
        "acceleration_g": [10, 80],
    }
    cell = {"across_flats_mm": 6.35, "depth_mm": 10, "count": 9}
    cases = cases_of(coupon(sweep=sweep, cell=cell, particles={"diameter_mm": 2.5}))
    measured = probe.measure(cases)
    few, many = sorted(set(measured.spheres))
    # a fill is a whole number of spheres a cell, of about 13 when full
    assert many / few == pytest.approx(4, rel=0.25)
    assert measured.spheres.tolist() == [few, few, many, many]
    moved = [estimate.travel(case.point) for case in cases]
    assert measured.travel.tolist() == 2 * [min(moved), max(moved)]
    # about `PROBE_SPHERES` of a poured bed, which is higher than the cell
    assert probe.PROBE_SPHERES < measured.poured < 3 * probe.PROBE_SPHERES
    assert measured.diameter == 2.5e-3
    assert (measured.times > 0).all() and measured.pour_time > 0
