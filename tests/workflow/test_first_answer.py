"""The first answer of `make run`: which studies have one, and what it depends on."""

import pytest

from pidpanel.study import load_study
from pidpanel.workflow import first_answer

ROOT = first_answer.Path(__file__).parents[2]
STUDIES = ROOT / "workflow" / "studies"


def test_a_simulated_study_is_answered_from_the_atlas_first(tmp_path):
    path = first_answer.first_study(STUDIES / "paper.yaml", tmp_path)
    study, whole = load_study(path), load_study(STUDIES / "paper.yaml")
    assert not study.coupons and not study.is_coupled
    assert study.name == "paper_first" and set(study.scenario_dampers) == {"atlas"}
    of_atlas = {s.label for s in whole.all_scenarios() if s.dampers in ("", "atlas")}
    assert {s.label for s in study.all_scenarios()} == of_atlas


@pytest.mark.parametrize("name", ["l_panel.yaml", "smoke.yaml", "coupon_size.yaml"])
def test_a_study_without_the_atlas_or_without_simulation_has_no_first_answer(tmp_path, name):
    assert first_answer.first_study(STUDIES / name, tmp_path) is None


def test_mistakes_are_left_to_the_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert first_answer.main("nosuch.yaml", "1") == 0
