"""Records come back as they were, or with a failure that names the file and the key."""

import dataclasses
import json

import pytest

from pidpanel.coupon import records
from pidpanel.coupon.balance import EnergyBalance
from pidpanel.coupon.liggghts.failures import FileDamaged, RecordUnreadable
from pidpanel.coupon.records import End, MeasuredBalance, Outcome, Poured, RunState

BALANCE = MeasuredBalance(EnergyBalance(*(0.1 * i for i in range(1, 10))), -0.003, 2, 551)
ENDS = (End(12, BALANCE), End(18, None))
STATE = RunState("a" * 64, 144, 7.1e-4, (12, 6), ENDS, 2, {})
BEGUN = RunState("a", 1, 1e-6, (), (), 0, {})


@pytest.mark.parametrize("state", [STATE, BEGUN])
def test_a_state_survives_its_way_through_a_file(tmp_path, state):
    state.write(tmp_path)
    assert RunState.read(tmp_path) == state
    assert not list(tmp_path.glob(".new*"))


@pytest.mark.parametrize(
    "outcome", [Outcome("ok", "", Poured(9, 4, 0.5)), Outcome("Lost", "m", None)]
)
def test_an_outcome_survives_its_way_through_a_file(tmp_path, outcome):
    records.write(tmp_path / "packing.json", outcome)
    assert records.read(Outcome[Poured], tmp_path / "packing.json") == outcome


def test_a_state_of_somebody_else_puts_no_word_of_its_own_into_a_deck(tmp_path):
    values = json.loads(json.dumps(dataclasses.asdict(STATE)))
    files = {"../victim": "d" * 64, "x\nshell touch hit": ""}
    (tmp_path / "state.json").write_text(json.dumps(values | {"restart": "x\ny", "files": files}))
    state = RunState.read(tmp_path)
    assert state.start_files == ["start.data", "walls.stl", "at_18.restart"]
    assert set(state.with_files(tmp_path).files) == set(state.start_files)


@pytest.mark.parametrize("name", ["../victim", "/etc/hostname", "s1/start.data"])
def test_a_record_of_somebody_else_names_no_file_outside_its_folder(tmp_path, name):
    with pytest.raises(FileDamaged, match="name of a file in it"):
        records.check_files(tmp_path, {name: "d" * 64})


def test_a_file_that_changed_since_it_was_left_is_named(tmp_path):
    for name in BEGUN.start_files:
        (tmp_path / name).write_text(name)
    state = BEGUN.with_files(tmp_path)
    records.check_files(tmp_path, state.files)
    (tmp_path / "walls.stl").write_text("other")
    with pytest.raises(FileDamaged, match=r"walls\.stl: damaged or changed"):
        records.check_files(tmp_path, state.files)
    with pytest.raises(FileDamaged, match=r"walls\.stl: missing"):
        (tmp_path / "walls.stl").unlink()
        records.check_files(tmp_path, state.files)


def test_a_folder_without_a_state_has_none(tmp_path):
    assert RunState.read(tmp_path) is None


def values(**changes):
    return json.loads(json.dumps(dataclasses.asdict(STATE))) | changes


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (json.dumps({k: v for k, v in values().items() if k != "mass"}), r"mass: "),
        (json.dumps(values(spheres="144")), r"spheres: "),
        (json.dumps(values(legs=[12, 6.5])), r"legs\.1: "),
        (json.dumps(values(ends=[{"cycles": 1}])), r"ends\.0\.balance: "),
        (json.dumps([1]), r"record: "),
        (json.dumps(values())[:-9], r"record: Invalid JSON"),
        ("", r"record: Invalid JSON"),
    ],
)
def test_a_file_with_anything_else_in_it_is_refused_by_name(tmp_path, text, message):
    (tmp_path / "state.json").write_text(text)
    with pytest.raises(RecordUnreadable, match=r"state\.json: .*" + message):
        RunState.read(tmp_path)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RecordUnreadable, match=r"bed\.json: No such file"):
        records.read(RunState, tmp_path / "bed.json")


def test_a_whole_number_will_do_for_a_number(tmp_path):
    (tmp_path / "state.json").write_text(json.dumps(values(mass=1)))
    assert type(RunState.read(tmp_path).mass) is float
