"""When panel and particles are integrated together, and what that requires of a study."""

import copy
import tempfile

import pytest
import yaml

from pidpanel.paths import WORKFLOW
from pidpanel.study import load_study

SMOKE = yaml.safe_load((WORKFLOW / "studies" / "smoke.yaml").read_text())
POT = {"pot": {"equivalent_damping_n_s_m3": 900}}
LEFT = {"centre_m": [0.25, 0.5], "size_m": [0.3, 0.2]}


def values(**damping):
    found = copy.deepcopy(SMOKE)
    found["damping"] = {"readings": ["coupled"], **damping}
    return found


def with_pot(found):
    """A damper without a coupon on a patch of its own, beside the coupon."""
    found["dampers"] = POT
    found["panel"]["patches"]["left"] = LEFT
    found["scenarios"] = {
        "both": {
            "layout": {
                "PID-1": {"damper": "coupon", "fill_fraction": 0.5},
                "left": {"damper": "pot"},
            }
        },
        "pot": {"layout": {"left": {"damper": "pot"}}},
    }
    return found


def pot_alone(found):
    found["dampers"] = POT
    found["scenarios"] = {"pot": {"layout": {"PID-1": {"damper": "pot"}}}}
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


def test_coupled_may_be_the_only_reading_and_runs_every_scenario_with_a_coupon(loaded):
    # red: a bare scenario left in `coupled_scenarios`; `("dem",)` for coupled alone
    study = loaded(values())
    assert study.readings == ("coupled",) and study.is_coupled
    assert [one.label for one in study.coupled_scenarios()] == [
        "PID-1_r0.4_150dB", "PID-1_r0.8_150dB",
    ]  # fmt: skip
    law = loaded(values(readings=["paper_corrected"]))
    assert not law.is_coupled and law.coupled_scenarios() == ()


def test_the_coupon_that_is_integrated_with_the_panel_needs_no_sweep(loaded):
    # red: `is_coupled` left out of Study.coupons; `"dem" not in` that is always True
    assert dict(loaded(values()).coupons) == {}
    for beside in ("dem", "stated"):
        assert list(loaded(values(readings=[beside, "coupled"])).coupons) == ["coupon"]


@pytest.mark.parametrize("radiation", ["one_side", "two_sides"])
def test_a_panel_that_radiates_may_be_integrated_with_its_particles(loaded, radiation):
    # red: the mistake of radiation that was in `_mistakes_of_coupled`
    found = values()
    found["response"]["radiation"] = radiation
    assert loaded(found).is_coupled


def test_a_patch_without_a_coupon_is_read_as_stated(loaded):
    # red: `stated_dampers` that returns all; `beds_of` of dampers without a coupon
    study = loaded(with_pot(values()))
    assert study.stated_dampers == ("pot",)
    (both,) = study.coupled_scenarios()
    assert both.label == "both"
    ((filling, coupon, fill),) = study.beds_of(both)
    assert (filling.patch, coupon, fill) == ("PID-1", study.coupon, 0.5)


def test_the_diagonal_form_is_not_coupled_by_default_and_refused_when_asked_for(loaded, refusal):
    # red: `is_full` left out of Study.readings; the check left out of `_mistakes_of_coupled`
    found = values()
    found["response"]["modal_damping"] = "diagonal"
    assert told(refusal, found) == [
        "damping.readings = [coupled]: the damping model 'coupled' is only allowed with "
        "modal_damping: full"
    ]
    del found["damping"]
    assert loaded(found).readings == ("dem",)


def test_a_study_without_a_coupon_in_a_scenario_cannot_be_coupled(refusal):
    # red: `_has_filled_coupon` that is always True
    message = "the damping model 'coupled' needs a scenario with a coupon; there is none"
    expected = [f"damping.readings = [coupled]: {message}"]
    assert told(refusal, pot_alone(values())) == expected
    without = {key: value for key, value in values().items() if key != "coupon"}
    assert told(refusal, without) == expected


def test_a_damper_that_is_not_there_is_told_as_without_coupled_runs(refusal):
    # red: `self.all_dampers[filling.damper]` of an unknown damper in `beds_of`
    found = with_pot(values())
    found["scenarios"]["pot"]["layout"]["left"]["damper"] = "gold"
    message = "scenarios.pot.layout.left.damper = gold: must be one of dampers: coupon, pot"
    assert told(refusal, found) == [message]


def test_a_bare_panel_has_nothing_to_be_integrated_with(loaded):
    # red: `is_coupled` read from the key rather than from `readings`
    found = values()
    del found["scenarios"]
    study = loaded(found)
    assert study.readings == ("bare",) and not study.is_coupled


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("seeds", 4, "damping.coupled.seeds = 4: unknown key"),
        ("relative_error", 0, "damping.coupled.relative_error = 0: must be above 0"),
        ("runs", 0, "damping.coupled.runs = 0: must be from 1 to 100"),
        ("cells", 1, "damping.coupled.cells = 1: must be from 2 to 200"),
        ("cells", 12, "damping.coupled.cells = 12: must be a multiple of stations = 8"),
        ("duration_s", 0.01, "damping.coupled.duration_s = 0.01: must be from 0.1 to 100"),
        ("scenarios", ["one"], "damping.coupled.scenarios = [one]: was removed; every scenario"),
    ],
)  # fmt: skip
def test_a_key_of_coupled_runs_that_does_not_fit_is_told(refusal, key, value, message):
    # red: a bound of a field of `Coupled`; `Coupled.mistakes` that yields nothing
    (line,) = told(refusal, values(coupled={key: value}))
    assert line.startswith(message)


def test_the_keys_need_no_reading_where_coupled_is_the_default(loaded, refusal):
    # red: the mistake of `coupled` told from Damping.readings
    found = values()
    found["damping"] = {"coupled": {"runs": 3}}
    study = loaded(found)
    assert study.readings == ("coupled",) and study.damping.coupled.runs == 3
    message = "damping.coupled = {runs: 3}: only allowed with the damping model 'coupled'"
    assert told(refusal, pot_alone(found)) == [message]
