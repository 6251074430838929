"""Layouts and families, their dampers and damping models: what they mean, what is refused."""

import copy
import pickle
import tempfile
from pathlib import Path

import pytest
import yaml

from pidpanel.coupon.from_study import cases_by_coupon, distinct_cases
from pidpanel.study import StudyError, load_study
from pidpanel.study.scenarios import Family, Filling, Scenario
from pidpanel.study.stated_number import error_of

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
BED = SMOKE["dampers"]["acrylic"]
BASE = {key: SMOKE[key] for key in ("panel", "sound", "response")} | {
    "dampers": {
        "acrylic": BED,
        "pot": {"equivalent_damping_n_s_m3": 2000, "apparent_mass_kg_m2": 3},
        "law": {"law": "paper_corrected"},
    },
    "scenarios": {
        "both": {
            "layout": {
                "PID-1": {"damper": "acrylic", "fill_fraction": 0.5},
                "PID-2": {"damper": "pot"},
            }
        },
        "fill": {"patch": "PID-2", "damper": "acrylic", "fill_fraction": [0.4, 0.8]},
        "place": {"patch": ["PID-1", "PID-2"], "damper": "pot"},
    },
}
BASE["panel"] = copy.deepcopy(BASE["panel"])
BASE["panel"]["patches"]["PID-2"] = {"centre_m": [0.25, 0.5], "size_m": [0.3, 0.2]}
LAYOUT = "scenarios.both.layout"


def changed(*changes):
    """The values of the study with keys set, or taken away."""
    values = copy.deepcopy(BASE)
    for key, value in changes:
        *parents, last = key.split(".")
        section = values
        for parent in parents:
            section = section.setdefault(parent, {})
        if value is None:
            section.pop(last)
        else:
            section[last] = value
    return values


@pytest.fixture
def loaded(write):
    """The study with changes."""

    def load(*changes):
        with tempfile.TemporaryDirectory() as folder:
            return load_study(write(folder, changed(*changes)).path)

    return load


def test_a_layout_is_one_scenario_of_all_its_patches_named_by_its_key(loaded):
    (both,) = loaded().family_scenarios("both")
    assert both.label == "both"
    assert [(p, f.damper, f.fill_fraction) for p, f in both.fillings.items()] == [
        ("PID-1", "acrylic", 0.5),
        ("PID-2", "pot", None),
    ]
    assert both.patch == "PID-1+PID-2" and not both.is_bare
    assert both.bare.label == "bare_150dB" and both.bare.is_bare


def test_scenarios_of_several_dampers_have_them_in_their_names(loaded):
    labels = [scenario.label for scenario in loaded().all_scenarios()]
    assert labels == [
        "bare_150dB", "both", "PID-2_acrylic_r0.4_150dB", "PID-2_acrylic_r0.8_150dB",
        "PID-1_pot_150dB", "PID-2_pot_150dB",
    ]  # fmt: skip


LEVELS = ("sound.levels", {"acceptance": 0, "qualification": 6})


def test_named_levels_are_scenarios_of_what_states_neither_a_level_nor_a_list(loaded):
    alone = ("scenarios.alone", {"patch": "PID-1", "damper": "pot"})
    labels = [scenario.label for scenario in loaded(LEVELS, alone).all_scenarios()]
    assert labels == [
        "bare_150dB", "bare_156dB", "both_150dB", "both_156dB", "PID-2_acrylic_r0.4_150dB",
        "PID-2_acrylic_r0.8_150dB", "PID-1_pot_150dB", "PID-2_pot_150dB", "PID-1_pot_156dB",
    ]  # fmt: skip
    stated = loaded(LEVELS, ("scenarios.both.oaspl_db", 153)).family_scenarios("both")
    assert [scenario.label for scenario in stated] == ["both"]
    bare = loaded(LEVELS, ("scenarios", {})).all_scenarios()
    assert [scenario.oaspl_db for scenario in bare] == [150, 156]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("sound.oaspl_db", None), "sound.oaspl_db: missing; required with levels"),
        (("sound.levels.flight", 6), "sound.levels = .*: two names have the same level"),
        (("sound.levels.loud", 55), "sound.levels.loud = 55: gives 205 dB; must be"),
    ],
)
def test_levels_without_their_zero_twice_or_beyond_all_sound_are_refused(loaded, change, message):
    with pytest.raises(StudyError, match=message):
        loaded(LEVELS, change)


def test_the_only_damper_needs_no_name_and_is_in_no_label(loaded):
    values = [("dampers.pot", None), ("dampers.law", None), ("scenarios", {})]
    study = loaded(*values, ("scenarios.fill", {"patch": "PID-1", "fill_fraction": [0.5]}))
    (scenario,) = study.family_scenarios("fill")
    assert scenario.label == "PID-1_r0.5_150dB"
    assert scenario.fillings["PID-1"].damper == "acrylic"


def test_a_list_of_dampers_compares_them_in_every_scenario_of_a_family(loaded):
    more = {"patch": "PID-1", "damper": ["acrylic", "law"], "fill_fraction": [0.4, 0.8]}
    study = loaded(("scenarios", {}), ("scenarios.more", more))
    assert [scenario.label for scenario in study.family_scenarios("more")] == [
        "PID-1_acrylic_r0.4_150dB", "PID-1_acrylic_r0.8_150dB",
        "PID-1_law_r0.4_150dB", "PID-1_law_r0.8_150dB",
    ]  # fmt: skip
    assert study.families["more"].varied == "fill_fraction"
    alone = {**more, "fill_fraction": 0.5}
    assert loaded(("scenarios.fill", alone)).families["fill"].varied == "damper"


def test_scenarios_that_differ_in_the_damping_model_alone_are_known(loaded):
    fill = {"patch": "PID-1", "fill_fraction": 0.5}
    other = {**BED, "particles": {**BED["particles"], "friction": 0.7}}
    named = {
        "atlas": {"like": "acrylic", "model": "atlas"}, "other": other,
        "lab": {"table": "acrylic_2mm.csv"},
        "test": {"table": "acrylic_2mm.csv", "like": "acrylic"},
    }  # fmt: skip
    changes = [(f"dampers.{name}", value) for name, value in named.items()]
    dampers = ["acrylic", "law", *named]
    study = loaded(*changes, ("scenarios", {"one": {**fill, "damper": dampers}}))
    by_damper = {s.dampers: s for s in study.family_scenarios("one")}

    def others(name):
        return sorted(s.dampers for s in study.alternatives(by_damper[name]))

    assert others("acrylic") == ["atlas", "law", "test"]
    assert others("other") == ["law"] and others("lab") == ["law"]
    main = [name for name, scenario in by_damper.items() if study.is_main(scenario)]
    assert main == ["other", "lab", "test"]  # measured before simulated, and a law last
    levels = {**fill, "damper": ["acrylic", "law"], "oaspl_db": [140, 150]}
    study = loaded(("scenarios", {"one": levels}))
    first = study.family_scenarios("one")[0]
    assert [s.label for s in study.alternatives(first)] == ["PID-1_law_r0.5_140dB"]


def test_the_bare_panel_alone_needs_no_dampers_patches_and_scenarios(loaded):
    study = loaded(("scenarios", None), ("dampers", None), ("panel.patches", None))
    assert [s.label for s in study.all_scenarios()] == ["bare_150dB"]
    assert [s.label for s in study.mapped_scenarios()] == ["bare_150dB"]
    assert dict(study.coupons) == {}


def test_only_beds_that_a_scenario_names_are_simulated(loaded):
    study = loaded(("dampers.other", {"like": "acrylic", "gravity_g": 0}))
    assert list(study.coupons) == ["acrylic"]
    assert study.used_dampers == ("acrylic", "pot")
    assert list(loaded(("dampers.acrylic.model", "atlas")).coupons) == []


def test_coupons_share_their_cases_and_a_shared_one_is_as_accurate_as_both_ask(loaded):
    finer = copy.deepcopy(BED)
    finer["accuracy"] = {"relative_error": 0.1, "seeds": 2, "min_cycles": 10, "max_cycles": 30}
    finer["sweep"]["fill_fraction"] = [0.4, 0.6]
    study = loaded(
        ("dampers.finer", finer),
        ("scenarios.more", {"patch": ["PID-1"], "damper": "finer", "fill_fraction": 0.5}),
    )
    found = cases_by_coupon(study)
    shared = set(found["acrylic"]) & set(found["finer"])
    assert len(shared) == 4  # one fill of two at two frequencies and two accelerations
    for label in shared:
        assert found["acrylic"][label] == found["finer"][label]
        assert found["acrylic"][label].relative_error == 0.1
        assert found["acrylic"][label].target.max_cycles == 60
    left = [case for label, case in found["acrylic"].items() if label not in shared]
    assert {case.relative_error for case in left} == {0.25}
    assert len(distinct_cases(study)) == 12


def test_a_fill_fraction_with_an_error_is_a_number():
    family = Family(patch="A", fill_fraction=[0.3, {"value": 0.5, "error": 0.02}])
    assert family.fill_fraction == (0.3, 0.5)
    assert [error_of(fill) for fill in family.fill_fraction] == [0.0, 0.02]
    # as are copies, and labels
    filling = Filling(fill_fraction=family.fill_fraction[1])
    assert error_of(pickle.loads(pickle.dumps(filling)).fill_fraction) == 0.02
    scenario = Scenario.of_patch("A", filling, None, has_dampers=False)
    assert scenario.label == "A_r0.5" and error_of(scenario.fillings["A"].fill_fraction) == 0.02
