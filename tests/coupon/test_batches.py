"""Cases that cost little share a process; which ones is a matter of their order alone."""

import json

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


def test_a_batch_fits_into_one_argument():
    accuracy = {"relative_error": 0.5, "seeds": 10, "min_cycles": 10, "max_cycles": 10}
    sweep = {"fill_fraction": [0.1], "frequency_hz": [2000], "acceleration_g": list(range(20, 60))}
    for batch in batches.batches_of(cases(sweep=sweep, accuracy=accuracy)):
        assert sum(len(case.runs) for case in batch.cases) <= batches.MOST_RUNS
        assert len(json.dumps(batch.as_list())) < 128 * 1024


def test_the_label_knows_the_target():
    accuracy = {"relative_error": 0.04, "seeds": 2, "min_time_s": 0.1, "max_cycles": 300}
    one, other = (
        batches.Batch(tuple(found)).label for found in (cases(), cases(accuracy=accuracy))
    )
    assert one.startswith("12_")
    assert one != other
