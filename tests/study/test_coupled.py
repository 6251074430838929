"""When panel and particles are integrated together, and what that requires of a study."""

import copy
import tempfile

import pytest
import yaml

from pidpanel.coupled.from_study import coupled_scenarios
from pidpanel.paths import WORKFLOW
from pidpanel.study import load_study

SMOKE = yaml.safe_load((WORKFLOW / "studies" / "smoke.yaml").read_text())
POT = {"equivalent_damping_n_s_m3": 900}
LEFT = {"centre_m": [0.25, 0.5], "size_m": [0.3, 0.2]}
FILL = {"fill": {"patch": "PID-1", "damper": "acrylic", "fill_fraction": [0.4, 0.8]}}


def values(model="coupled", **coupled):
    found = copy.deepcopy(SMOKE) | {"scenarios": FILL}
    found["dampers"] = {"acrylic": {**found["dampers"]["acrylic"], "model": model}}
    if coupled:
        found["damping"] = {"coupled": coupled}
    return found


def with_pot(found, damper="pot"):
    """A damper without particles on a patch of its own, beside the bed."""
    found["dampers"]["pot"] = POT
    found["panel"]["patches"]["left"] = LEFT
    found["scenarios"] = {
        "both": {
            "layout": {
                "PID-1": {"damper": "acrylic", "fill_fraction": 0.5},
                "left": {"damper": damper},
            }
        },
        "pot": {"layout": {"left": {"damper": "pot"}}},
    }
    return found


@pytest.fixture
def loaded(write):
    def load(found):
        with tempfile.TemporaryDirectory() as folder:
            return load_study(write(folder, found).path)

    return load


def told(refusal, found):
    """Lines of the refusal, without the number of the line."""
    lines, _ = refusal(found)
    return [line.removeprefix("mine.yaml:").lstrip("0123456789: ") for line in lines]


def test_every_scenario_with_a_coupled_bed_is_run(loaded):
    study = loaded(values())
    assert study.is_coupled and dict(study.coupons) == {}
    assert [one.label for one in study.coupled_scenarios()] == [
        "PID-1_r0.4_150dB",
        "PID-1_r0.8_150dB",
    ]
    tones = loaded(values("tones"))
    assert not tones.is_coupled and tones.coupled_scenarios() == ()
    assert list(tones.coupons) == ["acrylic"]


@pytest.mark.parametrize("radiation", ["one_side", "two_sides"])
def test_a_panel_that_radiates_may_be_integrated_with_its_particles(loaded, radiation):
    found = values()
    found["response"]["radiation"] = radiation
    assert loaded(found).is_coupled


def test_only_the_patches_of_coupled_beds_are_integrated(loaded):
    study = loaded(with_pot(values()))
    (both,) = study.coupled_scenarios()
    assert both.label == "both"
    (scenario,) = coupled_scenarios(study).values()
    assert [patch.name for patch in scenario.patches] == ["PID-1"]
    assert list(scenario.dampers) == ["left"]
    assert {bed.fill_fraction for patch in scenario.patches for bed in patch.beds} == {0.5}


def test_simulated_tones_beside_a_coupled_bed_are_refused(refusal):
    found = with_pot(values())
    found["dampers"]["tones"] = {"like": "acrylic", "model": "tones"}
    found["scenarios"]["both"]["layout"]["left"] = {"damper": "tones", "fill_fraction": 0.5}
    (line,) = told(refusal, found)
    assert line.startswith(
        "scenarios.both.layout.left = {damper: tones, fill_fraction: 0.5}: must "
    )


def test_a_bare_panel_has_nothing_to_be_integrated_with(loaded):
    assert not loaded(values() | {"scenarios": {}}).is_coupled


def test_settings_of_coupled_runs_need_a_coupled_bed(loaded, refusal):
    assert loaded(values(runs=3)).damping.coupled.runs == 3
    message = "damping.coupled = {runs: 3}: only allowed with a damper with model: coupled in a "
    assert told(refusal, values("tones", runs=3)) == [f"{message}scenario"]
