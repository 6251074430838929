"""Which rows of ``summary.csv`` are to be trusted."""

import math

import pandas as pd
import pytest

from pidpanel.paths import WORKFLOW
from pidpanel.response.from_study import scenarios_of
from pidpanel.response.trust import LARGEST_ERROR, doubts, doubts_in, judged
from pidpanel.study import load_study

GOOD = {
    "beyond_linear_plate": False, "extrapolated_share": 0.0, "data_missing": "steel to 61 g",
    "levels": 1,
    "motion_residual": 0.0, "basis_error": 1e-3, "reduction_error_db": 0.1,
    "displacement_rms_mm": 5.0, "acceleration_rms_g": 10.0, "acceleration_rms_error_g": 0.3, "status": "ok",
}  # fmt: skip


def stretched(acceleration, acceleration_error, displacement, displacement_error):
    return {
        "stretched_acceleration_rms_g": acceleration,
        "stretched_acceleration_rms_error_g": acceleration_error,
        "stretched_displacement_rms_mm": displacement,
        "stretched_displacement_rms_error_mm": displacement_error,
    }


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, []),
        ({"beyond_linear_plate": 1}, ["not linear"]),
        ({"beyond_linear_plate": 1, **stretched(10.3, 0.1, 4.9, 0.01)}, []),
        ({"beyond_linear_plate": 1, **stretched(10.3, 0.1, 4.4, 0.05)}, []),
        (
            {"beyond_linear_plate": 1, **stretched(9.4, 0.11, 4.4, 0.05)},
            ["not linear, stretching changes g rms by −6 ± 1 %"],
        ),
        (
            {"beyond_linear_plate": 1, **stretched(11.0, 0.33, 4.9, 0.05)},
            ["not linear, stretching changes g rms by +10 ± 3 %"],
        ),
        (
            {"beyond_linear_plate": 1, **stretched(math.nan, math.nan, math.nan, math.nan)},
            ["not linear"],
        ),
        ({"extrapolated_share": 0.04}, []),
        (
            {"extrapolated_share": 0.12},
            ["12 % of the change extrapolated, extend steel to 61 g"],
        ),
        ({"between_share": 0.9}, []),
        ({"levels": 2}, ["several solutions"]),
        ({"motion_residual": 2e-3}, ["motion not converged"]),
        ({"basis_error": 6e-3}, ["basis too small"]),
        ({"acceleration_rms_error_g": math.nan}, ["no stated error"]),
        ({"acceleration_rms_error_g": 2.4}, []),
        ({"acceleration_rms_error_g": 2.6}, ["known to ± 26 % only"]),
    ],
)
def test_each_doubt_has_its_limit(changed, said):
    assert doubts([{**GOOD, **changed}], LARGEST_ERROR) == said


def test_the_bare_panel_needs_no_error():
    assert doubts([{**GOOD, "acceleration_rms_error_g": math.nan}], math.inf) == []


def test_coupled_runs_are_doubted_beyond_twice_the_wanted_error():
    study = load_study(WORKFLOW / "studies" / "launch.yaml")
    row = {**GOOD, "scenario": "PID-1_r0.5_136.7dB", "point": "326"}
    for wanted, said in ((0.02, ""), (0.01, "known to ± 3 % only (more damping.coupled.runs)")):
        found = judged(scenarios_of(study), pd.DataFrame([row]), wanted)
        assert found["doubts"].tolist() == [said]


def test_a_large_error_of_the_atlas_has_a_remedy():
    labels = [f"PID-1_{damper}_r0.5_162dB" for damper in ("atlas", "acrylic", "paper")]
    row = {**GOOD, "point": "326", "between_share": 0.9, "acceleration_rms_error_g": 3.0}
    rows = [{**row, "scenario": label} for label in labels]
    scenarios = scenarios_of(load_study(WORKFLOW / "studies" / "paper.yaml"))
    assert judged(scenarios, pd.DataFrame(rows), 0.02)["doubts"].tolist() == [
        "known to ± 30 % only (model: coupled)",
        "known to ± 30 % only",
        "known to ± 30 % only",
    ]


def test_the_atlas_is_trusted_to_eight_percent():
    # the same error of measured or simulated tones is none to doubt
    scenarios = scenarios_of(load_study(WORKFLOW / "studies" / "paper.yaml"))
    labels = [f"PID-1_{damper}_r0.5_162dB" for damper in ("atlas", "acrylic")]
    for error, trusted in ((0.79, ["yes", "yes"]), (0.81, ["no", "yes"])):
        rows = [
            {**GOOD, "point": "326", "acceleration_rms_error_g": error, "scenario": label}
            for label in labels
        ]
        assert judged(scenarios, pd.DataFrame(rows), 0.02)["trusted"].tolist() == trusted


def test_a_sweep_without_a_case_between_others_is_not_trusted():
    # the smoke study: two frequencies and two amplitudes
    for name, label, said in (
        ("smoke", "PID-1_acrylic_r0.4_150dB", "coarse sweep"),
        ("smoke", "PID-1_paper_r0.4_150dB", ""),
        ("paper", "PID-1_acrylic_r0.5_162dB", ""),
    ):
        scenarios = scenarios_of(load_study(WORKFLOW / "studies" / f"{name}.yaml"))
        rows = [{**GOOD, "scenario": label, "point": "centre"}]
        assert judged(scenarios, pd.DataFrame(rows), 0.02)["doubts"].tolist() == [said]


def test_every_row_says_whether_to_trust_it_and_where_its_damping_comes_from():
    study = load_study(WORKFLOW / "studies" / "launch.yaml")
    accuracy = study.damping.coupled.relative_error
    labels = ["bare_136.7dB", "PID-1_r0.5_136.7dB", "PID-1_r0.9_136.7dB"]
    rows = [
        {**GOOD, "scenario": label, "point": point} for label in labels for point in ("326", "189")
    ]
    rows[4]["status"] = rows[5]["status"] = "unstable"
    found = judged(scenarios_of(study), pd.DataFrame(rows), accuracy)
    assert found["trusted"].tolist() == ["yes"] * 4 + ["no"] * 2
    assert found["doubts"].tolist()[2:] == [""] * 2 + ["unstable"] * 2
    assert set(found["damping_source"][:2]) == {"none"}
    assert set(found["damping_source"][2:]) == {"coupled runs of this study"}
    assert [doubts_in(row) for row in found.to_dict("records")][3:5] == [(), ("unstable",)]
