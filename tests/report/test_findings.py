"""Verdicts follow the numbers, both ways."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report import findings
from pidpanel.report.tables import READINGS

POINTS = ["middle", "corner"]
DISTANCE = pd.DataFrame([[0.0, 0.585], [0.585, 0.0]], ["A", "B"], POINTS)


def by_fill(*rows):
    return pd.DataFrame(rows, index=[0.1, 0.7, 0.9], columns=POINTS)


def flat(rms):
    """A band's reduction as that of the rms, in two bands."""
    return np.repeat(-20 * np.log10(rms.to_numpy())[:, None], 2, axis=1)


def test_a_fill_is_the_best_only_where_it_is_the_lowest_at_every_point():
    # red: `.any()` for `.all()` in fill_is_most_effective
    everywhere = by_fill([1.0, 1.0], [1.1, 1.2], [1.3, 1.1])
    in_part = by_fill([1.0, 1.3], [1.1, 1.2], [1.3, 1.4])
    assert findings.fill_is_most_effective(everywhere, 0.1, flat(everywhere)).holds
    found = findings.fill_is_most_effective(in_part, 0.1, flat(in_part))
    assert not found.holds
    assert "point corner: r = 0.7, 0.70 dB below r = 0.1" in found.evidence


def test_the_best_fill_by_bands_is_named_beside_the_one_by_rms():
    # red: `mean.argmin` for `mean.argmax`
    rms = by_fill([1.0, 1.0], [1.1, 1.2], [1.3, 1.1])
    gained = np.zeros((3, 2, 2))
    gained[2] = 5.0
    found = findings.fill_is_most_effective(rms, 0.1, gained)
    assert found.holds
    assert "third octaves best at point middle: r = 0.9, 5.00 dB" in found.evidence


def test_every_fill_must_lower_every_point():
    # red: `>= 0` for `> 0`
    bare = pd.Series([2.0, 1.2], index=POINTS)
    assert findings.every_fill_lowers(by_fill([1, 1], [1, 1.1], [1, 1]), bare).holds
    found = findings.every_fill_lowers(by_fill([1, 1], [1, 1.2], [1, 1]), bare)
    assert not found.holds
    assert found.evidence.startswith("5 of 6 lowered")


def test_fills_are_alike_within_a_decibel():
    # red: 10 % fill taken in too (`low` left out of the choice)
    assert findings.fills_are_alike(by_fill([9.0, 9.0], [1.0, 1.0], [1.1, 1.1])).holds
    assert not findings.fills_are_alike(by_fill([9.0, 9.0], [1.0, 1.0], [1.0, 1.13])).holds


def test_high_frequency_must_gain_more_in_every_response():
    # red: halves exchanged
    centre = np.array([100.0, 200.0, 400.0, 800.0])
    rising = np.array([0.0, 1.0, 2.0, 3.0])[None, :, None] * np.ones((2, 1, 2))
    assert findings.more_at_high_frequency(rising, centre).holds
    rising[1, :, 1] = [3.0, 2.0, 1.0, 0.0]
    found = findings.more_at_high_frequency(rising, centre)
    assert not found.holds
    assert found.evidence.startswith("in 3 of 4 responses")


DISTANCE = pd.DataFrame([[0.0, 1.0], [1.0, 0.0]], index=["A", "B"], columns=POINTS)


def test_the_nearest_damper_must_give_the_lowest_response_everywhere():
    # red: `idxmax` for the lowest response
    near = pd.DataFrame([[1.0, 2.0], [2.0, 1.0]], index=["A", "B"], columns=POINTS)
    far = pd.DataFrame([[1.0, 0.5], [2.0, 1.0]], index=["A", "B"], columns=POINTS)
    assert findings.nearest_damper_is_best(near, DISTANCE).holds
    assert not findings.nearest_damper_is_best(far, DISTANCE).holds


def test_each_damper_must_lower_its_own_point_most():
    # red: rows and columns exchanged
    own = pd.DataFrame([[3.0, 1.0], [5.0, 6.0]], index=["A", "B"], columns=POINTS)
    other = pd.DataFrame([[3.0, 1.0], [5.0, 4.0]], index=["A", "B"], columns=POINTS)
    assert findings.own_point_gains_most(own, DISTANCE).holds
    assert not findings.own_point_gains_most(other, DISTANCE).holds


def test_a_shift_is_linear_where_every_band_rises_with_the_sound():
    # red: 10 lg for 20 lg of the rms
    oaspl = np.array([162.0, 142.0, 152.0])
    rms = 10 ** (oaspl[:, None, None] / 20) * np.ones((1, 4, 2))
    assert findings.shifts_with_level(rms, oaspl).holds
    rms[0, 3, 1] *= 10 ** (1.5 / 20)
    found = findings.shifts_with_level(rms, oaspl)
    assert not found.holds
    assert "10.00 to 11.50 dB" in found.evidence


def verdict_of(study, summary, psd, reading, words):
    (found,) = (
        v
        for v in findings.verdicts(study, summary, psd, DISTANCE)
        if v.reading == reading and words in v.claim
    )
    return found.finding


FILL = {("A_r0.1_150dB", p): 4.0 for p in POINTS}
FILL |= {("A_r0.7_150dB", p): 2.0 for p in POINTS} | {("A_r0.9_150dB", p): 1.8 for p in POINTS}
PLACE = {("A_r0.5_150dB", "middle"): 3.0, ("A_r0.5_140dB", "middle"): 3.0}
PLACE |= {("B_r0.5_150dB", "corner"): 3.0}


def test_verdicts_turn_with_the_responses(study, respond):
    # red: a verdict written down instead of found
    told = {}
    opposite = {key: 5 - value for key, value in FILL.items()}
    opposite |= {("A_r0.5_150dB", "corner"): 6.0, ("A_r0.9_150dB", "middle"): 0.5}
    for name, scale in (("as claimed", FILL | PLACE), ("otherwise", opposite)):
        summary, psd = respond(scale)
        told[name] = {
            verdict.claim: verdict.finding.holds
            for verdict in findings.verdicts(study, summary, psd, DISTANCE)
            if verdict.reading == "paper_corrected"
        }
    flat_spectrum = told["as claimed"].pop("The effect is larger at high frequency")
    assert not flat_spectrum  # the same in every band
    assert all(told["as claimed"].values())
    for claim in ("most effective", "almost the same", "nearest to it gives", "shifts linearly"):
        (answer,) = (holds for words, holds in told["otherwise"].items() if claim in words)
        assert not answer, claim


def test_a_reading_without_response_has_no_verdict(study, respond):
    # red: `whole` always true
    summary, psd = respond(FILL)
    assert verdict_of(study, summary, psd, "paper_printed", "most effective") is None


def test_the_outcome_names_the_best_fill_of_each_point(study, respond):
    # red: `idxmin` of the reduction
    summary, _ = respond({**FILL, ("A_r0.9_150dB", "corner"): 9.0})
    said = " ".join(findings.outcome(study, summary, READINGS))
    assert "r = 0.1 at point middle (4.0 dB below" in said
    assert "r = 0.9 at point corner (9.0 dB below" in said
    assert "as printed" not in said


# --------------------------------------------------------------------------- warnings


def test_damping_read_past_the_run_points_is_told_with_level_and_frequencies(study, respond):
    # red: `inside` taken for `outside` in _where
    lowered = {(s.label, p): 1.0 for s in study.all_scenarios() if s.patch for p in POINTS}
    summary, psd = respond(lowered, read_at=312.0, inside=0.75)
    said = findings.response_warnings(study, summary, psd, READINGS)
    (outside,) = (text for text in said if "outside the run points" in text)
    assert "A_r0.1_150dB 25% of the lines at Γ = 312 (100–141 Hz)" in outside
    # flat spectra from 100 to 400 Hz: (141 − 100)/300
    assert "These lines make 14% to 14% of the change" in outside


def test_motion_beyond_a_tenth_of_the_thickness_is_told(study, respond):
    # red: the scenario with the smallest displacement named
    summary, psd = respond({})
    assert not any(
        "Linear plate" in t for t in findings.response_warnings(study, summary, psd, READINGS)
    )
    first = summary.index[0]
    summary.loc[first, "beyond_linear_plate"] = True
    summary.loc[first, "displacement_rms_mm"] = 25.5
    (said,) = (
        t for t in findings.response_warnings(study, summary, psd, READINGS) if "Linear" in t
    )
    assert "25.5 mm (bare_150dB, point middle)" in said


def test_scenarios_without_a_steady_response_are_told(study, respond):
    # red: the loop over unstable readings left out
    summary, psd = respond({})
    said = findings.response_warnings(study, summary, psd, READINGS)
    (unstable,) = (text for text in said if "no steady response" in text)
    assert unstable.startswith(READINGS["paper_printed"])
    assert "B_r0.5_150dB" in unstable


def test_power_that_is_lost_from_the_balance_is_told(study, respond):
    # red: POWER_BALANCE of 1
    summary, psd = respond({})
    summary.loc[0, "power_balance_error"] = 0.02
    assert any("2.0e-02" in t for t in findings.response_warnings(study, summary, psd, READINGS))


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("status", "NotSteady", "do not count (NotSteady)"),
        ("status", "ParticlesLost", "do not count (ParticlesLost)"),
        ("target_met", False, "without the accuracy asked for"),
        ("share_of_bound", 1.2, "exceed the bound"),
        ("equivalent_damping_n_s_m3", 5.0, "no more than their own error"),
    ],
)
def test_coupon_cases_that_count_less_are_told(cases, column, value, words):
    # red: each of the branches left out
    assert findings.coupon_warnings(cases) == []
    cases.loc[4, column] = value
    (said,) = findings.coupon_warnings(cases)
    assert words in said
    assert said.startswith("1 ")


def test_distances_are_from_the_centres_of_the_patches(basis):
    # red: patches and points swapped. 0.05 m: the cells of the trial mesh measure 0.1 m
    distance = findings.patch_distance(basis)
    assert distance.loc["A", "middle"] < 0.05 > distance.loc["B", "corner"]
    assert distance.loc["A", "corner"] == pytest.approx(np.hypot(0.55, 0.2), abs=0.05)


def test_a_target_reached_with_few_cases_is_said_not_to_be_worth_its_error():
    # red: nothing said of a target that is reached
    last = {"reached": True, "cases": ["a"], "relative_error": {"x": {"1": 0.02}}, "target": 0.03}
    assert findings.target_warnings([last]) == [findings.FEW_CASES]
    assert findings.target_warnings([]) == []
    missed = {**last, "reached": False, "relative_error": {"x": {"1": 0.042}, "y": {"1": 0.01}}}
    (said,) = findings.target_warnings([missed])
    assert "within a standard error of 3.00% these are not: x 4.20%." in said
