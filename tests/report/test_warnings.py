"""Limitations are stated where the numbers have them, and nowhere else."""

import dataclasses

import pandas as pd
import pytest

from pidpanel.report import warnings
from pidpanel.report.inputs import CouponResults
from pidpanel.report.text import READINGS

POINTS = ["middle", "corner"]
NO_LAYOUTS = pd.DataFrame(columns=["reading", "scenario"])


def test_damping_outside_the_simulated_range_is_named_with_its_acceleration_and_frequencies(
    study, reported, respond
):
    # red: `inside` taken for `outside` in _ranges_outside
    lowered = {(s.label, p): 1.0 for s in study.all_scenarios() if s.patch for p in POINTS}
    summary, psd = respond(lowered, read_at=312.0, inside=0.75)
    said = warnings.response_warnings(reported, summary, psd, NO_LAYOUTS)
    (outside,) = (text for text in said if "extrapolated" in text)
    assert "A, r = 0.1, 150 dB, Γ = 312, 25 % of the lines (100–141 Hz)" in outside
    # the worst are named, here the first of equals; red: NAMED = 9
    count = len({s.label for s in study.all_scenarios() if s.patch})
    assert outside.count("Γ = 312") == 3 and f"and {count - 3} more (All scenarios)" in outside
    assert "Up to 25 % of the change in mean square" in outside


def test_motion_beyond_a_tenth_of_the_thickness_is_told(reported, respond):
    # red: the scenario with the smallest displacement named
    summary, psd = respond({})
    assert not any(
        "Linear plate" in t for t in warnings.response_warnings(reported, summary, psd, NO_LAYOUTS)
    )
    first = summary.index[0]
    summary.loc[first, "beyond_linear_plate"] = True
    summary.loc[first, "displacement_rms_mm"] = 25.5
    (said,) = (
        t for t in warnings.response_warnings(reported, summary, psd, NO_LAYOUTS) if "Linear" in t
    )
    assert "25.5 mm (bare panel, 150 dB, point middle)" in said


def test_a_mesh_that_is_too_coarse_says_how_much_shorter_its_elements_must_be(reported, respond):
    # red: "Use shorter element edges."; the error of g rms left out; decibels of a ratio
    summary, psd = respond({})
    last = summary.index[summary["status"] == "ok"][-1]
    for column, value in (("mesh_error", 10 ** (16 * 0.65 / 10) - 1), ("mesh_error_rms", 0.405)):
        worse = summary.assign(**{column: summary[column].where(summary.index != last, value)})
        said = warnings.response_warnings(reported, worse, psd, NO_LAYOUTS)
        (mesh,) = (text for text in said if "mesh is too coarse" in text)
        # 16 and 81 times what is allowed, which falls with the fourth power
        factor = "2.0" if column == "mesh_error" else "3.0"
        assert mesh.endswith(f"Use element edges {factor} times shorter.")


def test_scenarios_without_a_steady_response_are_told(reported, respond):
    # red: the loop over unstable readings left out
    summary, psd = respond({})
    said = warnings.response_warnings(reported, summary, psd, NO_LAYOUTS)
    (unstable,) = (text for text in said if "no steady response" in text)
    assert unstable.startswith(READINGS["paper_printed"])
    assert "B, r = 0.5, 150 dB" in unstable


def test_power_that_is_lost_from_the_balance_is_told(reported, respond):
    # red: POWER_BALANCE of 1
    summary, psd = respond({})
    summary.loc[0, "power_balance_error"] = 0.02
    assert any(
        "0.020 of the power input" in t
        for t in warnings.response_warnings(reported, summary, psd, NO_LAYOUTS)
    )


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        (
            "status",
            "NotSteady",
            "did not reach steady state; included with enlarged errors: r0.3_f400Hz_a12g.",
        ),
        ("status", "ParticlesLost", "excluded (ParticlesLost): r0.3_f400Hz_a12g."),
        ("target_met", False, "before reaching the requested accuracy"),
        ("share_of_bound", 1.2, "inelastic bed (up to 1.20 times the bound): r0.3_f400Hz_a12g."),
        ("equivalent_damping_n_s_m3", 5.0, "no larger than its own standard error: r0.3"),
    ],
)
def test_coupon_cases_that_count_less_are_told(cases, column, value, words):
    # red: each of the calls of warn left out
    assert warnings.coupon_warnings(cases) == []
    cases.loc[4, column] = value
    (said,) = warnings.coupon_warnings(cases)
    assert words in said
    assert said.startswith("1 of 12 coupon cases ")


def test_the_accuracy_of_cases_stopped_at_max_cycles_is_the_largest_of_them(cases):
    # red: the largest relative error of all cases
    cases.loc[[4, 5], "target_met"] = False
    cases.loc[5, "equivalent_damping_error_n_s_m3"] = 300.0  # of 600
    cases.loc[0, "equivalent_damping_error_n_s_m3"] = 120.0  # of 150, and its target met
    (said,) = warnings.coupon_warnings(cases)
    assert said.startswith("2 of 12 coupon cases stopped at max_cycles")
    assert said.endswith("their relative standard errors reach 50 %.")


def test_damping_from_single_tones_comes_with_the_warning_that_it_is_overstated(inputs, respond):
    # red: the warning left out, or given for a law too
    summary, psd = respond({}, read_at=312.0)
    layouts = summary[["reading", "scenario", "damping_read_at_g", "outside_run_points_share"]]
    changed = dataclasses.replace(inputs, summary=summary, psd=psd, layouts=layouts)
    read = warnings.study_warnings(changed)
    # a table or a law was not shaken here
    assert warnings.EQUIVALENT_SINE in read and warnings.SINGLE_TONES not in read
    shaken = dataclasses.replace(inputs.study, surfaces=("coupon",))
    changed = dataclasses.replace(changed, study=shaken)
    assert warnings.SINGLE_TONES in warnings.study_warnings(changed)
    said = warnings.study_warnings(inputs)
    assert warnings.SINGLE_TONES not in said and warnings.EQUIVALENT_SINE not in said


def test_the_warnings_of_every_stage_are_on_the_page(inputs, cases, respond):
    # red: coupon_warnings or radiation_finding left out of study_warnings
    beside = inputs.summary[inputs.summary["status"] == "ok"]
    beside = beside[["reading", "scenario", "point", "acceleration_rms_g", "reduction_db"]]
    cases.loc[2, "status"] = "NotSteady"
    patch = inputs.summary["scenario"].str.startswith("bare").map({True: "none", False: "A"})
    read = dataclasses.replace(
        inputs,
        summary=inputs.summary.assign(patch=patch),
        radiation=beside.assign(radiation="one_side"),
        coupons={"coupon": CouponResults(cases, [], None)},
    )
    said = warnings.study_warnings(read)
    assert [
        sum(words in text for text in said) for words in ("With radiation", "steady state")
    ] == [
        1,
        1,
    ]
