"""Studies that cannot be meant are refused at their line, with key, kind and the likely unit."""

import copy
import json
import re
from pathlib import Path

import pytest
import yaml

from pidpanel.check import checked_study
from pidpanel.paths import DATA, STUDIES
from pidpanel.study import StudyError
from tests.study.conftest import written

CORPUS = yaml.safe_load(Path(__file__).with_name("wrong.yaml").read_text("utf-8"))
HINT = re.compile(r"(\S+) would be |did you mean ([^?]+)\?")


def shipped(name):
    return yaml.safe_load((STUDIES / f"{name}.yaml").read_text("utf-8"))


def smoke(**keys):
    """The smoke test with its bed of particles alone, changed."""
    study = shipped("smoke")
    study["dampers"]["acrylic"].update(keys)
    study["scenarios"]["fill"]["damper"] = "acrylic"
    return study


DERIVED = {
    "atlas": smoke(model="atlas"),
    "coupled": smoke(model="coupled") | {"damping": {"coupled": {"duration_s": 1}}},
    "coupon": {"coupon": {k: v for k, v in shipped("smoke")["dampers"]["acrylic"].items() if k != "model"}},
}  # fmt: skip


def changed(name, key, value):
    """A study with one value set."""
    study = copy.deepcopy(DERIVED.get(name) or shipped(name))
    study = json.loads(json.dumps(study))  # numbers as names of keys become text
    if name == "bdf_panel":
        study["panel"]["mesh"]["file"] = str(STUDIES / "bdf_panel.bdf")
    *around, last = key.split(".")
    section = study
    for entry in around:
        section = section.setdefault(entry, {})
    section[last] = json.loads(json.dumps(value).replace("data/", f"{DATA}/"))
    return study


def refused(folder, study):
    """The lines of a refusal, and the lines of the keys in the file."""
    path, line = written(folder, study)
    with pytest.raises(StudyError) as caught:
        checked_study(path)
    return str(caught.value).replace(f"{folder}/", "").split("\n"), line


def meaning(text):
    """What a message says after file and line: its key, and the kind with its hint."""
    key = re.split(" = |: ", text)[0]
    for start in (match.end() for match in re.finditer(": ", text)):
        for kind, pattern in CORPUS["kinds"].items():
            if re.match(pattern, text[start:]):
                hint = HINT.search(text, start)
                return key, f"{kind} ({hint[1] or hint[2]})" if hint else kind
    return key, "contradiction"


def line_of(key, line):
    """The line of a key, or of the last on the way to it that is there."""
    ways = {".".join(way): number for way, number in line.items()}
    while key and key not in ways:
        key = re.sub(r"\.?[^.]*$|\[\d+\]$", "", key) if "[" not in key else key[: key.index("[")]
    return ways.get(key, 0)


@pytest.mark.parametrize(
    ("name", "key", "value", "mistakes"),
    [
        pytest.param(name, key, value, mistakes, id=f"{name}: {key}: {str(value)[:40]}")
        for name, rows in CORPUS["studies"].items()
        for key, value, *mistakes in rows
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path, name, key, value, mistakes):
    told, line = refused(tmp_path, changed(name, key, value))
    expected = []
    for mistake in mistakes:
        where, _, kind = mistake.rpartition(": ")
        expected.append((where if where[:1].isalpha() else key + where, kind))
    assert [meaning(text.split(": ", 1)[1]) for text in told] == expected
    for text, (where, _) in zip(told, expected, strict=True):
        number = line_of(where.replace(".''", "."), line)
        assert text.startswith(f"mine.yaml:{number}: " if number else "mine.yaml: ")
        assert len(text.splitlines()) == 1


def test_a_file_that_is_not_there_is_told_with_those_that_are(tmp_path):
    for key, file in (
        ("sound.spectrum", "smc_s_016_2014_min_third.csv"),
        ("dampers.acrylic.deck", "shake_lab.in.j2"),
    ):
        (line,), _ = refused(tmp_path, changed("smoke", key, "mine"))
        assert "no such file" in line and file in line


def test_more_values_than_a_machine_computes_are_refused(tmp_path):
    fills = [0.1 + 1e-5 * k for k in range(60_000)]
    (line,), _ = refused(tmp_path, changed("coupon", "coupon.sweep.fill_fraction", fills))
    assert "coupon.sweep = " in line and "allowed are 200000 runs" in line
    families = {f"s{k}": {"patch": "PID-1", "fill_fraction": 0.4} for k in range(1001)}
    (line,), _ = refused(tmp_path, changed("atlas", "scenarios", families))
    assert line.endswith("has 1001 names; allowed are 1000")


def test_mistakes_between_sections_are_told_where_there_are_none_within(tmp_path):
    study = changed("smoke", "scenarios.fill.damper", "gold")
    study["scenarios"]["more"] = {
        "patch": ["B", "PID-1", "C"],
        "fill_fraction": 0.5,
        "damper": "paper",
    }
    told, _ = refused(tmp_path, study)
    assert [text.split(": ")[1] for text in told] == [
        "scenarios.fill.damper = gold", "scenarios.more.patch[0] = B", "scenarios.more.patch[2] = C",
    ]  # fmt: skip
    study["panel"]["points"]["far"] = [300, 3]
    study["dampers"]["acrylic"]["cell"]["depth"] = 3
    told, line = refused(tmp_path, study)
    keys = [("dampers", "acrylic", "cell", "depth"), ("panel", "points", "far")]
    assert [int(text.split(":")[1]) for text in told] == [line[key] for key in keys]


def test_a_cell_has_one_fill_and_may_lie_under_a_blanket(tmp_path):
    study = changed(
        "paper",
        "dampers",
        {"lab": {"table": "acrylic_2mm.csv"}, "foil": {"equivalent_damping_n_s_m3": 9}},
    )
    study["panel"]["patches"] = {
        "A": {"centre_m": [0.7, 0.5], "size_m": [0.2, 0.2]},
        "B": {"centre_m": [0.75, 0.55], "size_m": [0.2, 0.2]},
    }
    study = {key: study[key] for key in ("dampers", "panel", "sound")}
    study["response"] = {"frequency_hz": [30, 400]}
    filled = {"damper": "lab", "fill_fraction": 0.5}
    study["scenarios"] = {"both": {"layout": {"A": filled, "B": {"damper": "foil"}}}}
    checked_study(written(tmp_path, study).path)
    study["scenarios"]["both"]["layout"]["B"] = filled
    (told,), _ = refused(tmp_path, study)
    assert told.endswith("covers cells of A too; a cell has only one fill fraction")
