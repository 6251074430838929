"""Records come back as they were, or with a failure that names the file and the key."""

import dataclasses
import json
from typing import Literal

import pytest

from pidpanel.coupon import coding
from pidpanel.coupon.balance import EnergyBalance
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.liggghts.failures import FileDamaged, RecordUnreadable
from pidpanel.coupon.records import End, MeasuredBalance, RunState, check_files

BALANCE = MeasuredBalance(EnergyBalance(*(0.1 * i for i in range(1, 10))), -0.003, 2, 551)
ENDS = (End(12, BALANCE, "d" * 64), End(18, None, "e" * 64))
STATE = RunState("a" * 64, 144, 7.1e-4, (12, 6), "at_18.restart", ENDS, 2)


@pytest.mark.parametrize("state", [STATE, RunState("a", 1, 1e-6)])
def test_a_state_survives_its_way_through_a_file(tmp_path, state):
    # red: legs left a list; a balance left a dictionary
    state.write(tmp_path)
    assert RunState.read(tmp_path) == state
    assert not list(tmp_path.glob(".new*"))


@pytest.mark.parametrize(
    "restart", ["x\nshell touch hit", "../../victim", "at_17.restart", "/dev/zero"]
)
def test_a_state_of_somebody_else_puts_no_word_of_its_own_into_a_deck(tmp_path, restart):
    # red: any text taken for the restart; LIGGGHTS then runs its second line, and a film copies
    # the file that it names
    dataclasses.replace(STATE, restart=restart).write(tmp_path)
    with pytest.raises(RecordUnreadable, match=r"state\.json: restart = .*must be at_18\.restart"):
        RunState.read(tmp_path)


@pytest.mark.parametrize("name", ["../victim", "/etc/hostname", "s1/start.data"])
def test_a_record_of_somebody_else_names_no_file_outside_its_folder(tmp_path, name):
    # red: `folder / name` of any name
    with pytest.raises(FileDamaged, match="name of a file in it"):
        check_files(tmp_path, {name: "d" * 64})


def test_a_folder_without_a_state_has_none(tmp_path):
    assert RunState.read(tmp_path) is None


def values(**changes):
    return json.loads(json.dumps(coding.encode(STATE))) | changes


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (json.dumps(values(extra=1)), r"extra: "),
        (json.dumps({k: v for k, v in values().items() if k != "mass"}), r"mass: "),
        (json.dumps({k: v for k, v in values().items() if k != "legs"}), r"a key of RunState is missing"),
        (json.dumps(values(spheres="144")), r"spheres: "),
        (json.dumps(values(spheres=True)), r"spheres: "),
        (json.dumps(values(mass=None)), r"mass: "),
        (json.dumps(values(legs=[12, 6.5])), r"legs\.1: "),
        (json.dumps(values(legs=12)), r"legs: "),
        (json.dumps(values(ends=[{"cycles": 1, "last_digest": ""}])), r"ends\.0\.balance: "),
        (json.dumps([1]), r"State: "),
        (json.dumps(values())[:-9], r"Expecting|Unterminated|delimiter"),
        ("", r"Expecting value"),
    ],
)  # fmt: skip
def test_a_file_with_anything_else_in_it_is_refused_by_name(tmp_path, text, message):
    # red: unknown keys passed over; a missing one filled in by its default
    (tmp_path / "state.json").write_text(text)
    with pytest.raises(RecordUnreadable, match=r"state\.json: .*" + message):
        RunState.read(tmp_path)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RecordUnreadable, match=r"bed\.json"):
        coding.read(RunState, tmp_path / "bed.json")


def test_a_whole_number_will_do_for_a_number_but_not_the_other_way_round():
    # red: every number taken for a float
    assert type(coding.decode(RunState, values(mass=1)).mass) is float
    assert coding.decode(RunState, values()) == STATE
    assert dataclasses.asdict(STATE)["legs"] == (12, 6)


@dataclasses.dataclass(frozen=True)
class Chirp:
    """Another drive than a tone, with the same numbers."""

    frequency: float
    acceleration: float
    kind: Literal["chirp"] = "chirp"


@dataclasses.dataclass(frozen=True)
class Shaken:
    drive: Tone | Chirp
    other: Tone | Chirp | None = None


def test_of_several_drives_each_comes_back_as_what_it_was():
    # red: the first of the types taken
    for drive in (Tone(100.0, 20.0), Chirp(100.0, 20.0)):
        record = Shaken(drive, None)
        assert coding.decode(Shaken, coding.encode(record)) == record
    with pytest.raises(RecordUnreadable, match=r"drive\.Tone\."):
        coding.decode(Shaken, {"drive": {"frequency": 1.0, "kind": "saw"}, "other": None})
