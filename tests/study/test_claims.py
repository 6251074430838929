"""Claims of a study name families and values that are there."""

import copy

import pytest
import yaml

from pidpanel.paths import PROJECT

PAPER = yaml.safe_load((PROJECT / "workflow" / "studies" / "paper.yaml").read_text())


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"scenarios": "fil"}, "scenarios", ["scenarios = fil", "fill, location, level", "did you mean fill?"]),
        ({"values": [0.2]}, "values", ["values[0] = 0.2", "scenarios.fill.fill_fraction: 0.1, 0.3, 0.5, 0.7, 0.9"]),
        ({"values": []}, "values", ["must have 1 value, not 0"]),
        ({"comparison": "alike"}, "scenarios", ["must be a family of two scenarios or more"]),
        ({"comparison": "nearest_patch", "values": []}, "comparison", ["only allowed if scenarios.fill has a list patch"]),
        ({"comparison": "linear", "values": []}, "comparison", ["only allowed if scenarios.fill has a list oaspl_db"]),
        ({"comparison": "best"}, "comparison", ["must be 'most_effective', 'lowered'"]),
        ({"alike_db": 0}, "alike_db", ["must be from 0.01 to 40"]),
    ],
)  # fmt: skip
def test_a_claim_on_what_is_not_there_is_one_line(refusal, changes, key, words):
    values = copy.deepcopy(PAPER)
    values["claims"][0] |= changes
    lines, _ = refusal(values)
    file, line, message = lines[0].split(":", 2)
    assert len(lines) == 1 and file == "mine.yaml" and int(line) > 0, lines
    assert message.startswith(f" claims[0].{key}")
    assert all(word in message for word in words), message


def test_claims_need_sound(refusal):
    values = yaml.safe_load((PROJECT / "workflow" / "studies" / "shaker.yaml").read_text())
    values["claims"] = [{"text": "a", "scenarios": "fill", "comparison": "lowered"}]
    lines, _ = refusal(values)
    assert len(lines) == 1 and lines[0].endswith("only allowed with a section sound")


def test_a_switch_is_no_fill_fraction(refusal):
    values = copy.deepcopy(PAPER)
    values["scenarios"]["fill"] |= {"damper": "paper", "fill_fraction": [0.1, 1]}
    values["claims"] = [values["claims"][0] | {"values": [True]}]
    lines, _ = refusal(values)
    assert len(lines) == 1 and "must be one of scenarios.fill.fill_fraction: 0.1, 1.0" in lines[0]
