"""Scenarios have one name on the whole page."""

from types import SimpleNamespace

from pidpanel.report.names import names_of
from pidpanel.study import Filling, Scenario


def test_a_name_has_the_level_where_the_study_has_several(study):
    names = names_of(study)
    assert names["A_r0.1_150dB"] == "A, r = 0.1, 150 dB"
    assert names["bare_150dB"] == "bare panel, 150 dB"
    assert list(names) == [one.label for one in study.all_scenarios()]
    sole = study.model_copy(update={"scenarios": {"fill": study.scenarios["fill"]}})
    assert set(names_of(sole).values()) >= {"A, r = 0.1", "bare panel"}


def test_no_two_scenarios_have_one_name(study, monkeypatch):
    monkeypatch.setattr(Scenario, "name", "one")
    names = names_of(study)
    assert len(set(names.values())) == len(names)


def test_a_damper_alone_has_the_same_name_as_a_layout_and_in_a_family():
    filling = Filling(damper="beads", fill_fraction=0.5)
    bare = Scenario(label="bare", fillings={}, oaspl_db=None)
    alone = Scenario(label="third", fillings={"A": filling}, oaspl_db=None)
    both = Scenario(label="both", fillings={"A": filling, "B": filling}, oaspl_db=None)
    study = SimpleNamespace(all_scenarios=lambda: [bare, alone, both], panel=None)
    assert list(names_of(study).values()) == ["bare panel", "A, r = 0.5", "both"]
