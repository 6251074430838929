"""Cases that cost little share a process; which ones is a matter of their order alone."""

import json
import math

import pytest

from pidpanel.coupon import batches
from pidpanel.coupon.from_study import cases_of
from pidpanel.study.coupon import Coupon


def cases(**changes):
    values = {
        "sweep": {
            "fill_fraction": [0.1, 0.5],
            "frequency_hz": [50, 500],
            "acceleration_g": [5, 20, 80],
        },
        "accuracy": {"relative_error": 0.05, "seeds": 2, "min_time_s": 0.1, "max_cycles": 300},
    }
    return cases_of(Coupon.model_validate(values | changes))


def test_every_case_is_in_one_batch_and_in_its_order():
    swept = cases()
    found = list(batches.batches_of(swept))
    assert [case.label for batch in found for case in batch.cases] == [c.label for c in swept]
    assert 1 < len(found) < len(swept)


def test_a_batch_is_closed_when_it_is_worth_its_process():
    for batch in list(batches.batches_of(cases()))[:-1]:
        *before, _ = [batches.expected_cost(case) for case in batch.cases]
        assert sum(before) < batches.WORTH


def test_the_label_knows_the_target():
    accuracy = {"relative_error": 0.04, "seeds": 2, "min_time_s": 0.1, "max_cycles": 300}
    one, other = (
        batches.Batch(tuple(found)).label for found in (cases(), cases(accuracy=accuracy))
    )
    assert one.startswith("12_")
    assert one != other


def test_cases_come_back_from_the_file_of_their_batch(tmp_path):
    # red: a field left out of `content`
    batch = batches.Batch(cases())
    (tmp_path / "batch.json").write_text(json.dumps(batch.content))
    assert batches.read_cases(tmp_path / "batch.json") == list(batch.cases)


def test_where_jobs_have_a_time_limit_only_a_long_case_is_in_a_batch_longer_than_its_share():
    swept = cases()
    costs = sorted(batches.expected_cost(case) for case in swept)
    long = costs[-3]  # so that two cases are longer
    job = long / batches.LONG
    found = list(batches.batches_of(swept, job))
    assert [case.label for batch in found for case in batch.cases] == [c.label for c in swept]
    # red: `cost + own > LONG * job` left out
    longer = [batch for batch in found if batch.cost > 1.000001 * long]
    assert [len(batch.cases) for batch in longer] == [1, 1]
    # and these are the ones whose seeds are shaken apart, in legs that hold their cost
    for batch in found:
        for case in batch.cases:
            parts = batches.parts_of(case, job)
            assert bool(parts) == (batch in longer)
    assert not any(batches.parts_of(case, math.inf) for case in swept)


@pytest.mark.parametrize("share", [0.1, 0.4, 1.5, 4.5, 30])
def test_parts_of_a_long_case_hold_its_runs_once_in_short_jobs_or_legs(share):
    accuracy = {"relative_error": 0.05, "seeds": 5, "min_time_s": 0.1, "max_cycles": 300}
    case = cases(accuracy=accuracy)[0]
    one = batches.run_cost(case.point, case)
    job = one / share
    parts = batches.parts_of(case, job)
    assert bool(parts) == (5 * one > batches.LONG * job)  # red: LONG left out
    if parts:
        # red: `together = []` left out
        assert [number for part in parts for number in part.runs] == [0, 1, 2, 3, 4]
        # red: SHARE left out
        assert all(len(part.runs) == 1 or part.cost <= batches.SHARE * job for part in parts)
        # red: math.floor
        assert all((part.legs - 1) * job < part.cost <= part.legs * job for part in parts)
        assert sum(part.cost for part in parts) == pytest.approx(5 * one)


def test_a_run_costs_its_steps_on_an_ordinary_core():
    (case, *_) = cases()
    run = case.point
    step = batches.ORDINARY_STEP[0] + batches.ORDINARY_STEP[1] * batches.spheres_in(
        run.packing, run.fill_fraction
    )
    assert batches.run_cost(run, case) == pytest.approx(step * batches.run_steps(run, case))
    assert batches.expected_cost(case) == pytest.approx(2 * batches.run_cost(run, case))
