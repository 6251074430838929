"""Scenarios have one name on the whole page."""

import pandas as pd

from pidpanel.report.names import names_of, with_names
from pidpanel.study import Scenario


def test_a_name_has_the_level_where_the_study_has_several(study):
    # red: `several` always true, or always false
    names = names_of(study)
    assert names["A_r0.1_150dB"] == "A, r = 0.1, 150 dB"
    assert names["bare_150dB"] == "bare panel, 150 dB"
    assert list(names) == [one.label for one in study.all_scenarios()]
    sole = study.model_copy(update={"scenarios": {"fill": study.scenarios["fill"]}})
    assert set(names_of(sole).values()) >= {"A, r = 0.1", "bare panel"}


def test_no_two_scenarios_have_one_name(study, monkeypatch):
    # red: the last line of names_of left out
    monkeypatch.setattr(Scenario, "name", "one")
    names = names_of(study)
    assert len(set(names.values())) == len(names)


def test_labels_of_a_table_become_names():
    # red: with_names that returns what it is given
    frame = pd.DataFrame({"scenario": ["a", "b"], "value": [1, 2]})
    assert with_names(frame, {"a": "bare panel"})["scenario"].tolist() == ["bare panel", "b"]
    assert frame["scenario"].tolist() == ["a", "b"]
