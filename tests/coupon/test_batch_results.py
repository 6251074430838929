"""What runs have left is looked at before anything is planned."""

import dataclasses
import itertools
import shutil
from pathlib import Path

import pytest

from pidpanel.coupon import attempts, batches, coding, rows, runs
from pidpanel.coupon.batches import Batch
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import failures
from pidpanel.coupon.records import LoosenOutcome, Shaken, ShakeOutcome, files_of
from pidpanel.study.coupon import Coupon

GOLDEN = Path(__file__).parent / "liggghts" / "golden" / "shake"


@pytest.fixture()
def left(tmp_path, monkeypatch):
    """results/coupon with the recorded run as that of a case, and its batch."""
    coupon = Coupon.model_validate(
        {
            "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 1},
            "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
            "sweep": {"fill_fraction": [0.5], "frequency_hz": [200], "acceleration_g": [10]},
            "accuracy": {"seeds": 1},
        }
    )
    (case,) = cases_of(coupon)
    (file,) = case.outcomes(tmp_path)
    file.parent.mkdir(parents=True)
    last = file.parent / runs.last_file(12)
    shutil.copy(GOLDEN / "cycles_1.txt", file.parent)
    shutil.copy(GOLDEN / "last.dump", last)
    digest = rows.digest(case.point, file.parent, (12,), 12)
    kept = files_of(file.parent, [last.name])[last.name]
    found = Shaken(12, (12,), 8, 1e-4, "accuracy", None, digest, kept)
    outcome = ShakeOutcome("ok", "", 1, "3.8.0", 1.0, case.point, case.target, found)
    monkeypatch.setattr(attempts, "shake_case", lambda case, folder: [outcome])
    batch = Batch((case,))
    (tmp_path / "batch").mkdir()
    attempts.shake_cases([case], tmp_path, tmp_path / "batch" / f"{batch.label}.json")
    return tmp_path, batch, file, outcome


def test_a_batch_that_is_as_it_was_left_is_not_shaken_again(left):
    # red: `!=` for `==` anywhere
    folder, batch, _, _ = left
    assert batches.compare_results(batch, folder) == (False, [])


def test_another_version_of_the_judging_judges_every_run_again(left, monkeypatch):
    # red: the version not compared
    folder, batch, _, _ = left
    monkeypatch.setattr(batches, "JUDGING_VERSION", 0)
    assert batches.compare_results(batch, folder) == (True, [])


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *itertools.product(
            ("outcome", "cycles_1.txt", "at_12.dump"), ("flipped", "empty", "missing")
        ),
        ("batch", "empty"),
    ],
)
def test_a_damaged_file_of_a_finished_run_is_named(left, name, kind):
    # red: only `exists` of the outcomes asked; the dump left out
    folder, batch, file, _ = left
    path = {"outcome": file, "batch": folder / "batch" / f"{batch.label}.json"}.get(
        name, file.parent / name
    )
    data = path.read_text()
    place = data.index("1", len(data) // 2)
    path.write_text("" if kind == "empty" else f"{data[:place]}7{data[place + 1 :]}")
    if kind == "missing":
        path.unlink()
    incomplete, faults = batches.compare_results(batch, folder)
    assert incomplete
    assert len(faults) == 1 and str(file.parent if name != "batch" else path) in faults[0]


@pytest.mark.parametrize(("status", "again"), [("RunStopped", True), ("UnderFilled", False)])
def test_a_failure_of_the_machine_is_tried_again_and_one_of_the_inputs_is_not(left, status, again):
    # red: `BY_INPUTS` empty, or holding RunStopped
    folder, batch, file, outcome = left
    coding.write(file, dataclasses.replace(outcome, status=status, found=None))
    incomplete, faults = batches.compare_results(batch, folder)
    assert incomplete == again
    assert any(f"{file.parent}: {status} in the last call" in fault for fault in faults) == again


def test_a_bed_is_as_it_was_left_or_named(left):
    # red: the bed not looked at; one that was deleted called damaged
    folder, batch, _, outcome = left
    bed = outcome.run.bed
    home = folder / "bed" / bed.label
    home.mkdir(parents=True)
    (home / "bed.csv").write_text("x_m,y_m,z_m,diameter_m\n")
    files = {"bed.csv": "0" * 64}
    coding.write(home / "bed.json", LoosenOutcome("ok", "", 1, "3.8.0", 0.0, bed, None, files))
    batches._fault_of_bed.cache_clear()
    assert "bed.csv: damaged or changed" in batches.compare_results(batch, folder)[1][0]
    shutil.rmtree(home)
    batches._fault_of_bed.cache_clear()
    assert batches.compare_results(batch, folder) == (False, [])


def test_a_solver_that_dies_before_its_first_line_is_no_wrong_version(tmp_path, monkeypatch):
    # red: `next(…, "")` and the comparison with the version
    from pidpanel.coupon.liggghts import process

    program = tmp_path / "liggghts"
    program.write_text("#!/bin/sh\nkill -9 $$\n")
    program.chmod(0o755)
    monkeypatch.setattr(process, "check_installed", lambda: str(program))
    with pytest.raises(failures.RunStopped, match=r"exit status (-9|137): no message"):
        process.Liggghts(tmp_path, "fill")
    program.write_text("#!/bin/sh\necho LIGGGHTS 3.7.0\ncat >/dev/null\n")
    with pytest.raises(failures.SolverMissing, match=r"version 3\.8\.0 is required"):
        process.Liggghts(tmp_path, "fill")


def test_an_outcome_of_another_target_in_its_place_is_named(left):
    # red: the target not looked at in `_faults_of_case`
    folder, batch, file, outcome = left
    shorter = dataclasses.replace(outcome.target, max_cycles=outcome.target.max_cycles // 2)
    coding.write(file, dataclasses.replace(outcome, target=shorter, seeds=1))
    assert batches.compare_results(batch, folder) == (True, [f"{file}: belongs to another target"])


def test_the_time_of_a_run_is_that_of_all_calls(left):
    # red: `_spent` left out; that of the second call alone
    folder, batch, file, _ = left
    assert coding.read(ShakeOutcome, file).solver_cpu_s == 1.0
    again = folder / "batch" / f"{batch.label}.json"
    attempts.shake_cases(list(batch.cases), folder, again)
    assert coding.read(ShakeOutcome, file).solver_cpu_s == 2.0
