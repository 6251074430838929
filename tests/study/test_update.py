"""Results of tests in a study, and those that are refused."""

import copy

import numpy as np
import pandas as pd
import pytest
import yaml

from pidpanel import StudyError
from pidpanel.check import checked_study
from pidpanel.study.uncertain import judged_scenarios

STUDY = {
    "panel": {
        "outline_m": [1.0, 0.8],
        "section": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.0},
        "damping_ratio": 0.01,
        "mesh": {"kind": "quadrilaterals", "elements": [10, 8]},
        "patches": {"A": {"centre_m": [0.45, 0.4], "size_m": [0.2, 0.2]}},
        "points": {"P": [0.5, 0.4]},
    },
    "dampers": {"blanket": {"equivalent_damping_n_s_m3": 400}},
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv", "level": "median"},
    "response": {"frequency_hz": [60, 300]},
    "scenarios": {
        "A": {"layout": {"A": {"damper": "blanket"}}},
        "test": {"layout": {"A": {"damper": "blanket"}}, "oaspl_db": 130},
        "louder": {"layout": {"A": {"damper": "blanket"}}, "oaspl_db": 133},
    },
    "uncertain": {"panel.damping_ratio": {"normal": [0.008, 0.012], "source": "assumed"}},
    "measurements": {
        "narrow": {"file": "narrow.csv", "point": "P"},
        "bare": {"file": "psd.csv", "point": "P", "scenario": "bare_130dB"},
        "damped": {"file": "psd.csv", "point": "P", "scenario": "test"},
        "loud": {"file": "psd.csv", "point": "P", "scenario": "louder"},
    },
}  # fmt: skip
HALL = {"measurements": ["bare", "damped"], "error_db": 0.5, "common_db": 0.3}
SURVEY = {"frequency_hz": {1: 60.2}, "frequency_error": 0.005}
SPECTRUM = {"normal": [-3, 3], "correlation_octaves": 1, "source": "assumed"}


def study_with(folder, update, **changes):
    values = copy.deepcopy(STUDY) | {"update": update} | changes
    lines = {"frequency_hz": np.linspace(60, 300, 50), "acceleration_psd_g2_hz": 0.01}
    pd.DataFrame(lines).to_csv(folder / "psd.csv", index=False)
    pd.DataFrame(lines).query("90 < frequency_hz < 130").to_csv(folder / "narrow.csv", index=False)
    tones = {"frequency_hz": [100.0], "acceleration_g": [5.0], "equivalent_damping_n_s_m3": [400.0]}
    pd.DataFrame(tones).to_csv(folder / "coupon.csv", index=False)
    pd.DataFrame({**tones, "frequency_hz": [0.1]}).to_csv(folder / "khz.csv", index=False)
    quiet = {"center_hz": [63.0, 125.0, 250.0], "spl_db": 60.0}
    pd.DataFrame(quiet).to_csv(folder / "quiet.csv", index=False)
    file = folder / "study.yaml"
    file.write_text(yaml.safe_dump(values, sort_keys=False))
    return checked_study(file)


@pytest.mark.parametrize(
    ("update", "place", "parts"),
    [
        ({}, "update", ["modal_survey"]),
        ({"modal_survey": {"frequency_hz": {1: 60.2}}}, "frequency_error", ["required"]),
        ({"modal_survey": SURVEY | {"damping_ratio_error": 0.1}}, "damping_ratio_error", ["not"]),
        ({"modal_survey": SURVEY | {"frequency_hz": {9: 99.0}}}, "frequency_hz.9", ["1 to 6"]),
        ({"modal_survey": SURVEY | {"frequency_hz": {"A1": 99.0}}}, "A1", ["1 to 6"]),
        ({"modal_survey": SURVEY | {"frequency_hz": {1: 99.0, 2: 61.0}}}, "_hz", ["must rise"]),
        ({"modal_survey": SURVEY | {"frequency_hz": {2: 301.0}}}, "hz.2", ["at most 300"]),
        ({"impact_test": SURVEY | {"frequency_hz": {1: 0.06}}}, "frequency_hz.1", ["kHz", "60"]),
        ({"modal_survey": {"damping_ratio": {1: 1.2}, "damping_ratio_error": 0.1}},
         "damping_ratio.1", ["0.5", "0.012"]),
        ({"modal_survey": SURVEY | {"frequency_error": 5}}, "frequency_error", ["0.05"]),
        ({"coupon": {"file": "coupon.csv"}}, "coupon", ["relative_error"]),
        ({"coupon": {"file": "khz.csv", "relative_error": 0.1}}, "coupon.file", ["kHz"]),
        ({"coupon": {"file": "coupon.csv", "relative_error": 0.1, "patch": "B"}}, "patch", ["A"]),
        ({"coupon": {"file": "coupon.csv", "relative_error": 0.1, "patch": ""}}, "patch", ["A"]),
        ({"coupon": {"file": "missing.csv"}}, "coupon.file", ["missing.csv"]),
        ({"acoustic": {"hall": {**HALL, "measurements": ["other"]}}}, "[0]", ["bare, damped"]),
        ({"acoustic": {"hall": HALL, "room": {**HALL, "measurements": ["bare"]}}},
         "acoustic.room.measurements[0]", ["bare is in a test already"]),
        ({"acoustic": {"hall": {"measurements": ["bare"]}}}, "hall", ["error_db"]),
        ({"acoustic": {"hall": {**HALL, "measurements": ["damped", "loud"]}}}, "", ["one level"]),
        ({"acoustic": {"hall": {**HALL, "error_db": 50}}}, "error_db", ["10"]),
        ({"acoustic": {"hall": {**HALL, "spectrum": "quiet.csv"}}}, "spectrum", ["dB", "130"]),
        ({"acoustic": {"hall": {**HALL, "measurements": ["narrow"]}}}, "[0]", ["octave"]),
        ({"microphones": {"spectrum": "quiet.csv", "error_db": 1, "common_db": 0}}, "microphones",
         ["spread of sound.spectrum"]),
    ],
)  # fmt: skip
def test_a_result_that_cannot_be_is_refused_at_its_key_in_one_line(tmp_path, update, place, parts):
    with pytest.raises(StudyError) as refused:
        study_with(tmp_path, update)
    message = str(refused.value)
    lines = [line for line in message.splitlines() if "update" in line]
    assert any(place in line and all(part in line for part in parts) for line in lines), message


def test_tests_need_spreads_which_they_update(tmp_path):
    with pytest.raises(StudyError, match="only allowed with uncertain"):
        study_with(tmp_path, {"modal_survey": SURVEY}, uncertain={})


def test_the_scenario_of_a_test_is_not_judged_but_that_with_its_dampers(tmp_path):
    study = study_with(tmp_path, {"acoustic": {"hall": HALL}})
    assert [scenario.label for scenario in judged_scenarios(study)] == ["A", "louder"]
    first = dict(sorted(STUDY["scenarios"].items(), key=lambda item: item[0] != "test"))
    study = study_with(tmp_path, {"acoustic": {"hall": HALL}}, scenarios=first)
    assert [scenario.label for scenario in judged_scenarios(study)] == ["A", "louder"]
