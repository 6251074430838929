"""A run that several jobs share out is the run of one; real LIGGGHTS."""

import json
import shutil

import pytest

from pidpanel.coupon import attempts, coding, runs, summary
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.records import RunState
from pidpanel.study.coupon import Coupon
from tests.jobs import call


def two_seeds(**accuracy):
    values = {
        "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 2},
        "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
        "sweep": {"fill_fraction": [0.6], "frequency_hz": [100], "acceleration_g": [10]},
        "accuracy": {"relative_error": 1e-6, "seeds": 2, "min_cycles": 10, "max_cycles": 25}
        | {"min_time_s": 0, "state_cycles": 0}
        | accuracy,
    }
    (case,) = cases_of(Coupon.model_validate(values))
    return case


def prepared(case, folder, seeds=2):
    for run in case.runs[:seeds]:
        packing = folder / "packing" / run.packing.label / "packing.json"
        attempts.pour_packing(run.packing, packing)
        attempts.loosen_bed(run.bed, packing, folder / "bed" / run.bed.label / "bed.json")


def test_a_stretch_between_restarts_is_of_one_length_on_every_machine_and_a_cycle_at_least():
    run = two_seeds().point
    cost = run.steps_per_cycle * (runs.ORDINARY_STEP[0] + 50 * runs.ORDINARY_STEP[1])
    # red: CHECKPOINT over the cost of a step
    assert runs.cycles_between_restarts(run, 50) == int(runs.CHECKPOINT / cost)
    # red: max(1, …) left out
    assert runs.cycles_between_restarts(run, 10**12) == 1


def test_a_deadline_stops_what_would_pass_it_and_nothing_else():
    runs.check_time(1e9)  # without one nothing stops
    with runs.time_limit(100.0):
        runs.check_time(50.0)
        with pytest.raises(runs.Continues), runs.time_limit(1e6):  # red: no min in `time_limit`
            runs.check_time(150.0)
    runs.check_time(1e9)  # red: the end of before not restored


@pytest.mark.liggghts
def test_seeds_shaken_leg_by_leg_have_the_bits_of_a_case_shaken_in_one_go(tmp_path, monkeypatch):
    # red: the spheres read from the bed where a leg begins (`state.restart or None` → None);
    # `stop` without the cycles there are already
    case = two_seeds(max_cycles=15)
    # restarts every four cycles, so that those of a job are between those at which it is judged
    monkeypatch.setattr(runs, "cycles_between_restarts", lambda run, spheres: 4)
    whole, shared = tmp_path / "whole", tmp_path / "shared"
    prepared(case, whole)
    shutil.copytree(whole, shared)
    attempts.shake_cases([case], whole, tmp_path / "whole.json")
    for number in range(2):
        before, status, count = None, attempts.CONTINUES, 0
        request = tmp_path / "request.json"
        values = {"case": coding.encode(case), "runs": [number], "is_last": False}
        request.write_text(json.dumps(values))
        while status == attempts.CONTINUES:
            file = shared / f"{number}_{count}.json"
            # no time at all: one stretch a leg
            read = {"request": request, "before": before}
            call("shake_leg", "", read, {"leg": file}, seconds=0.0, coupon=shared)
            before, status, count = file, json.loads(file.read_text())["status"], count + 1
        # to cycles 4, 8, 10, 14, 15, the balance
        assert (status, count) == (attempts.DONE, 6)
    with runs.time_limit(0.0):  # nothing is left to be run
        attempts.shake_cases([case], shared, tmp_path / "shared.json")
    assert (tmp_path / "shared.json").read_text() == (tmp_path / "whole.json").read_text()
    rows = [
        summary.summarise(case, *summary.read_seeds(case, case.outcomes(folder)))
        for folder in (whole, shared)
    ]
    assert rows[0] == rows[1]
    assert rows[0]["cycles_run"] == 30


@pytest.mark.liggghts
def test_a_last_leg_that_is_not_done_is_to_be_tried_again(tmp_path, monkeypatch):
    case = two_seeds()
    monkeypatch.setattr(runs, "cycles_between_restarts", lambda run, spheres: 4)
    prepared(case, tmp_path, seeds=1)
    file, request = tmp_path / "leg.json", tmp_path / "request.json"
    values = {"case": coding.encode(case), "runs": [0], "is_last": True}
    request.write_text(json.dumps(values))
    with pytest.raises(runs.Continues):  # red: `is_last` not looked at
        attempts.shake_leg(request, None, tmp_path, file, seconds=0.0)
    assert not file.exists()
    state = coding.read(RunState, case.folders(tmp_path)[0] / "state.json")
    assert state.cycles == 4
    ended = tmp_path / "ended.json"
    ended.write_text(json.dumps({"status": attempts.DONE}))
    attempts.shake_leg(request, ended, tmp_path, file, seconds=0.0)
    # red: every status taken for one that goes on
    assert json.loads(file.read_text())["status"] == attempts.DONE
    assert coding.read(RunState, case.folders(tmp_path)[0] / "state.json") == state
