"""What another version left is found by its own records, and named in a line."""

import json

import pytest

from pidpanel import cli
from pidpanel.coupon import coding, older
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import process
from pidpanel.coupon.packing import POURING
from pidpanel.coupon.records import (
    Loosened,
    LoosenOutcome,
    Poured,
    PourOutcome,
    RunState,
    ShakeOutcome,
)
from pidpanel.provenance import durable, locks
from pidpanel.study.coupon import Coupon


@pytest.fixture()
def left(tmp_path):
    """results/coupon with the records of a packing, a bed and a run of this version."""
    coupon = Coupon.model_validate(
        {
            "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 1},
            "particles": {"diameter_mm": 2.5},
            "sweep": {"fill_fraction": [0.5], "frequency_hz": [200], "acceleration_g": [10]},
            "accuracy": {"seeds": 1},
        }
    )
    (case,) = cases_of(coupon)
    run, folder = case.point, tmp_path / "results" / "coupon"
    attempt = ("ok", "", 1, "3.8.0", 1.0)
    packing = folder / "packing" / run.packing.label
    bed = folder / "bed" / run.bed.label
    own = case.folders(folder)[0]
    for one in (packing, bed, own, folder / "leg" / case.label, folder / "batch"):
        one.mkdir(parents=True)
    coding.write(
        packing / "packing.json", PourOutcome(*attempt, run.packing, Poured(9, 8, 0.5), {})
    )
    coding.write(bed / "bed.json", LoosenOutcome(*attempt, run.bed, Loosened(4, 1e-9), {}))
    coding.write(own / f"{case.outcome}.json", ShakeOutcome(*attempt, run, case.target, None))
    RunState(run.identity, 4, 1e-4).write(own)
    return folder, case


def test_what_this_version_made_is_not_of_another(left):
    # red: `==` for `not in` in `_of_kind`; `identity` left out in `_is_older_case`
    folder, _ = left
    assert not older.older(folder)
    assert older.describe_older(folder) == ""
    assert not older.older(folder / "nothing")


def changed_solver(monkeypatch):
    monkeypatch.setattr(process, "VERSION", "3.9.0")


def changed_pour(monkeypatch):
    monkeypatch.setitem(vars(POURING), "restitution", 0.4)


@pytest.mark.parametrize("change", [changed_solver, changed_pour])
def test_all_that_another_version_made_is_named_with_its_size(left, monkeypatch, change):
    # red: any of the three kinds left out of `older`; `identity` of the run as it was decoded
    folder, case = left
    change(monkeypatch)
    found = older.older(folder)
    assert (len(found.packings), len(found.beds), len(found.cases)) == (1, 1, 1)
    assert folder / "leg" / case.label in found.folders
    said = older.describe_older(folder)
    assert said.startswith(f"{folder}: 1 case, 1 bed, 1 packing (") and "\n" not in said
    assert "pidpanel clean" in said
    # red: `wanted` not looked at
    assert not older.older(folder, {one.name for one in found.folders})


def test_a_record_of_other_keys_is_of_another_version_and_a_damaged_one_is_not(left):
    # red: "?" for a record that cannot be read at all
    folder, case = left
    (file,) = case.outcomes(folder)
    values = json.loads(file.read_text())
    values["run"]["speed"] = 1
    file.write_text(json.dumps(values))
    assert [one.name for one in older.older(folder).cases] == [case.label]
    file.write_text("{")
    assert not older.older(folder)


def test_clean_lists_it_and_removes_it_only_when_told_to(left, monkeypatch, capsys):
    # red: `given.yes` not asked; `.broken` left out; all cases removed
    folder, case = left
    results, own = folder.parent, case.folders(folder)[0]
    durable.write_text(results / "psd.nc.broken", "x")
    command = ["clean", "-d", str(results.parent)]
    assert cli.main(command) == 0
    assert "1 unused" in capsys.readouterr().out
    changed_solver(monkeypatch)
    assert cli.main(command) == 0
    said = capsys.readouterr().out
    assert said.count("of another version") == 4 and "psd.nc.broken: damaged" in said
    assert own.is_dir()
    with locks.hold(folder):
        assert cli.main([*command, "--yes"]) == 1  # red: `is_running` not asked
        assert own.is_dir()
    assert cli.main([*command, "--yes"]) == 0
    assert not own.exists() and not (results / "psd.nc.broken").exists()
    assert (folder / "batch").is_dir()
    capsys.readouterr()
    assert cli.main(command) == 0
    assert "nothing to remove" in capsys.readouterr().out
