"""Layouts, their dampers and the readings of a study: what they mean, and what is refused."""

import copy
import tempfile
from pathlib import Path

import pytest
import yaml

from pidpanel.coupon.from_study import cases_by_coupon, distinct_cases
from pidpanel.study import load_study

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
COUPON = SMOKE["coupon"]
BASE = {key: SMOKE[key] for key in ("panel", "sound", "response")} | {
    "dampers": {
        "acrylic": {"coupon": COUPON},
        "pot": {"equivalent_damping_n_s_m3": 2000, "apparent_mass_kg_m2": 3},
        "law": {"law": "paper_corrected"},
    },
    "damping": {"readings": ["stated"]},
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
    # red: family_scenarios that takes the first patch of a layout alone
    (both,) = loaded().family_scenarios("both")
    assert both.label == "both"
    assert [(f.patch, f.damper, f.fill_fraction) for f in both.fillings] == [
        ("PID-1", "acrylic", 0.5),
        ("PID-2", "pot", None),
    ]
    assert both.patch == "PID-1+PID-2" and not both.is_bare
    assert both.bare.label == "bare_150dB" and both.bare.is_bare


def test_scenarios_of_several_dampers_have_them_in_their_names(loaded):
    # red: the damper left out of Scenario.of_patch
    labels = [scenario.label for scenario in loaded().all_scenarios()]
    assert labels == [
        "bare_150dB", "both", "PID-2_acrylic_r0.4_150dB", "PID-2_acrylic_r0.8_150dB",
        "PID-1_pot_150dB", "PID-2_pot_150dB",
    ]  # fmt: skip


def test_the_only_damper_needs_no_name_and_is_in_no_label(loaded):
    # red: `len(self.all_dampers) > 0`
    values = [("dampers.pot", None), ("dampers.law", None), ("scenarios", {})]
    study = loaded(*values, ("scenarios.fill", {"patch": "PID-1", "fill_fraction": [0.5]}))
    (scenario,) = study.family_scenarios("fill")
    assert scenario.label == "PID-1_r0.5_150dB"
    assert scenario.fillings[0].damper == "acrylic"


def test_readings_follow_from_what_the_study_has(loaded):
    # red: ("dem",) always in Study.readings; `(COUPLED,)` whatever is filled
    default = ("damping", {})
    assert loaded(default).readings == ("coupled",)
    pots = (("scenarios.both", None), ("scenarios.fill", None))
    assert loaded(default, *pots).readings == ("stated",)
    stated = load_study(STUDIES / "l_panel.yaml")
    assert stated.readings == ("table",)
    assert loaded(("scenarios", None)).readings == ("bare",)
    assert load_study(STUDIES / "paper.yaml").readings == ("paper_corrected", "dem", "atlas")


OF_THE_SECTION = (("dampers", {}), ("coupon", COUPON), ("scenarios", {}))
FILLED = ("scenarios.fill", {"patch": "PID-1", "fill_fraction": [0.5]})


def test_a_law_leaves_the_sweep_of_the_section_coupon(loaded):
    # red: `self.is_coupled and` left out of Study.coupons
    law = ("damping.readings", ["paper_corrected"])
    assert list(loaded(law, *OF_THE_SECTION, FILLED).coupons) == ["coupon"]


@pytest.mark.parametrize(
    "key",
    [
        {"level": {"kind": "stated", "acceleration_g": 20}},
        {"level": {"by": "element"}},
    ],
    ids=["stated level", "level by element"],
)
def test_keys_of_single_tones_leave_them_the_reading(loaded, key):
    # red: `is_of_tones` with the kind of the level alone
    assert loaded(("damping", key), *OF_THE_SECTION, FILLED).readings == ("dem",)


def test_the_bare_panel_alone_needs_no_dampers_patches_and_scenarios(loaded):
    # red: min_length=1 for scenarios
    study = loaded(("scenarios", None), ("dampers", None), ("panel.patches", None))
    assert [s.label for s in study.all_scenarios()] == ["bare_150dB"]
    assert [s.label for s in study.mapped_scenarios()] == ["bare_150dB"]
    assert dict(study.coupons) == {} and study.surfaces == ()


def test_only_coupons_that_a_scenario_names_are_simulated(loaded):
    # red: used_dampers that returns all names
    other = copy.deepcopy(COUPON) | {"gravity_g": 0}
    study = loaded(("dampers.other", {"coupon": other}))
    assert list(study.coupons) == ["acrylic"] and study.surfaces == ("acrylic",)
    assert study.used_dampers == ("acrylic", "pot")
    assert list(loaded(("damping.readings", ["paper_corrected"]), ("scenarios.place", None),
                       (f"{LAYOUT}.PID-2.fill_fraction", 0.5)).coupons) == []  # fmt: skip


def test_the_section_coupon_is_a_damper_beside_the_others(loaded):
    # red: all_dampers without the section
    study = loaded(
        ("coupon", COUPON), ("damping.readings", ["dem", "stated"]), ("scenarios.place", None),
        (f"{LAYOUT}.PID-1.damper", "coupon"), (f"{LAYOUT}.PID-2.fill_fraction", 0.5),
    )  # fmt: skip
    assert list(study.coupons) == ["coupon", "acrylic"]
    assert study.surfaces == ("coupon", "acrylic")


def test_coupons_share_their_cases_and_a_shared_one_is_as_accurate_as_both_ask(loaded):
    # red: `strictest` left out of cases_by_coupon; distinct_cases that keeps both
    finer = copy.deepcopy(COUPON)
    finer["accuracy"] = {"relative_error": 0.1, "seeds": 2, "min_cycles": 10, "max_cycles": 30}
    finer["sweep"]["fill_fraction"] = [0.4, 0.6]
    study = loaded(
        ("dampers.finer", {"coupon": finer}),
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
    once = [case.label for cases in distinct_cases(study).values() for case in cases]
    assert len(once) == len(set(once)) == 12


STEEL = "must be one of dampers: acrylic, pot, law"
REFUSED = [
    (f"{LAYOUT}.PID-1.damper", "acrilic", f"{LAYOUT}.PID-1.damper = acrilic: {STEEL}; did you mean acrylic?"),
    (f"{LAYOUT}.PID-1.damper", None, f"{LAYOUT}.PID-1.damper: missing; {STEEL}"),
    ("scenarios.fill.damper", "gold", f"scenarios.fill.damper = gold: {STEEL}"),
    (f"{LAYOUT}.PID-3", {"damper": "pot"}, f"{LAYOUT}.PID-3 = {{damper: pot}}: must be one of panel.patches: PID-1, PID-2; did you mean PID-"),
    (f"{LAYOUT}.PID-1.fill_fraction", 0.9, f"{LAYOUT}.PID-1.fill_fraction = 0.9: must be in the range of dampers.acrylic.coupon.sweep, 0.4 to 0.8"),
    (f"{LAYOUT}.PID-1.fill_fraction", 1.2, f"{LAYOUT}.PID-1.fill_fraction = 1.2: must be from 0.02 to 1"),
    (f"{LAYOUT}.PID-1.fill_fraction", None, f"{LAYOUT}.PID-1.fill_fraction: missing; required for the coupon of acrylic"),
    (f"{LAYOUT}.PID-2.damper", "law", f"{LAYOUT}.PID-2.fill_fraction: missing; required for the law of law"),
    (f"{LAYOUT}.PID-1.filling", 0.5, f"{LAYOUT}.PID-1.filling = 0.5: unknown key; did you mean fill_fraction?"),
    ("scenarios.fill.fill_fraction", [0.1, 0.5], "scenarios.fill.fill_fraction[0] = 0.1: must be in the range of dampers.acrylic.coupon.sweep, 0.4 to 0.8"),
    ("scenarios.both.layout", {}, "scenarios.both.layout = {}: must have at least 1 value, not 0"),
    ("scenarios.both.patch", "PID-1", "scenarios.both.patch = PID-1: unknown key; allowed are layout, oaspl_db, title"),
    ("scenarios.bare_150dB", {"layout": {"PID-1": {"damper": "pot"}}}, "scenarios.bare_150dB = {layout: {PID-1: {damper: pot}}}: two scenarios would have the name bare_150dB; give the layout another name"),
    ("dampers.two kinds", {"law": "paper_corrected"}, "dampers.two kinds = {law: paper_corrected}: must have a name of up to 80 letters"),
    ("damping.readings", ["dem"], "coupon: missing; required for the damping model 'dem'"),
    ("damping.level", {"by": "element", "kind": "stated", "acceleration_g": 5}, "damping.level.by = element: only allowed for kind: patch; a stated acceleration holds for all elements"),
    ("dampers.acrylic.coupon.vary", {"gravity_g": [0, 1]}, "dampers.acrylic.coupon.vary = {gravity_g: [0, 1]}: only allowed in a study without a panel"),
    ("dampers", None, "there are no dampers"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value", "message"), REFUSED)
def test_a_mistake_in_dampers_and_layouts_is_told_in_one_line(refusal, key, value, message):
    # red: any of the yields of Study._mistakes_of_filling, _mistakes_of_dampers taken out
    lines, _ = refusal(changed((key, value)))
    assert any(message in line.removeprefix("mine.yaml:") for line in lines), lines
    assert key in ("dampers", "damping.readings") or len(lines) == 1, lines


def test_a_fill_beside_constants_is_for_the_readings_that_need_it(loaded, refusal):
    # red: `_needs_fill` without the readings of all patches alike
    law = ("damping.readings", ["stated", "paper_corrected"])
    lines, _ = refusal(changed(law))
    needed = "fill_fraction: missing; required for the damping model 'paper_corrected'"
    assert len(lines) == 2 and all(needed in line for line in lines)
    with_fill = (f"{LAYOUT}.PID-2.fill_fraction", 0.5), ("scenarios.place.fill_fraction", 0.5)
    assert loaded(law, *with_fill).readings == ("stated", "paper_corrected")
