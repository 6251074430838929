"""Verdicts follow the numbers, both ways."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report import claims
from pidpanel.report.claims import verdict_table
from tests.page_reader import blocks_of

POINTS = ["middle", "corner"]


def by_fill(*rows):
    return pd.DataFrame(rows, index=[0.1, 0.7, 0.9], columns=POINTS)


def certain(rms, error=0.01):
    """Standard errors [dB] of rms values."""
    return pd.DataFrame(error, rms.index, rms.columns)


def flat(rms):
    """A band's reduction as that of the rms, in two bands."""
    return np.repeat(-20 * np.log10(rms.to_numpy())[:, None], 2, axis=1)


def test_a_fill_is_the_best_only_where_it_is_the_lowest_at_every_point():
    # red: `.any()` for `.all()` in fill_is_most_effective
    everywhere = by_fill([1.0, 1.0], [1.1, 1.2], [1.3, 1.1])
    in_part = by_fill([1.0, 1.3], [1.1, 1.2], [1.3, 1.4])
    assert claims.fill_is_most_effective(everywhere, certain(everywhere), flat(everywhere)).holds
    found = claims.fill_is_most_effective(in_part, certain(in_part), flat(in_part))
    assert not found.holds
    assert "point corner: r = 0.7, 0.695 ± 0.014 dB below r = 0.1" in found.evidence


def test_every_fill_must_lower_every_point():
    # red: `.any()` for `.all()` in decided; SIGNIFICANCE = 0
    bare = pd.Series([2.0, 1.2], index=POINTS)
    every, not_every = by_fill([1, 1], [1, 1.1], [1, 1]), by_fill([1, 1], [1, 1.3], [1, 1])
    assert claims.every_fill_lowers(every, certain(every), bare).holds is True
    found = claims.every_fill_lowers(not_every, certain(not_every), bare)
    assert found.holds is False
    assert found.evidence.startswith("5 of 6 lowered")
    # a reduction of 0.76 dB with an error of 0.5 dB decides nothing
    assert claims.every_fill_lowers(every, certain(every, 0.5), bare).holds is None


def test_fills_are_alike_within_a_decibel():
    # red: 10 % fill taken in too (`low` left out of the choice)
    alike = by_fill([9.0, 9.0], [1.0, 1.0], [1.1, 1.1])
    other = by_fill([9.0, 9.0], [1.0, 1.0], [1.0, 1.13])
    assert claims.fills_are_alike(alike, certain(alike)).holds is True
    assert claims.fills_are_alike(other, certain(other)).holds is False
    # 0.83 dB apart and alike below 1 dB: with errors of 0.1 dB each they may be more
    assert claims.fills_are_alike(alike, certain(alike, 0.1)).holds is None


def test_high_frequency_must_gain_more_in_every_response():
    # red: halves exchanged
    centre = np.array([100.0, 200.0, 400.0, 800.0])
    rising = np.array([0.0, 1.0, 2.0, 3.0])[None, :, None] * np.ones((2, 1, 2))
    error = np.full_like(rising, 0.1)
    assert claims.more_at_high_frequency(rising, error, centre).holds is True
    rising[1, :, 1] = [3.0, 2.0, 1.0, 0.0]
    found = claims.more_at_high_frequency(rising, error, centre)
    assert found.holds is False
    assert found.evidence.startswith("in 3 of 4 responses")


DISTANCE = pd.DataFrame([[0.0, 1.0], [1.0, 0.0]], index=["A", "B"], columns=POINTS)


def test_the_nearest_damper_must_give_the_lowest_response_everywhere():
    # red: `idxmax` for the lowest response
    near = pd.DataFrame([[1.0, 2.0], [2.0, 1.0]], index=["A", "B"], columns=POINTS)
    far = pd.DataFrame([[1.0, 0.5], [2.0, 1.0]], index=["A", "B"], columns=POINTS)
    assert claims.nearest_damper_is_best(near, certain(near), DISTANCE).holds is True
    assert claims.nearest_damper_is_best(far, certain(far), DISTANCE).holds is False


def test_each_damper_must_lower_its_own_point_most():
    # red: rows and columns exchanged
    own = pd.DataFrame([[3.0, 1.0], [5.0, 6.0]], index=["A", "B"], columns=POINTS)
    other = pd.DataFrame([[3.0, 1.0], [5.0, 4.0]], index=["A", "B"], columns=POINTS)
    assert claims.own_point_gains_most(own, certain(own), DISTANCE).holds is True
    assert claims.own_point_gains_most(other, certain(other), DISTANCE).holds is False


def test_a_shift_is_linear_where_every_band_rises_with_the_sound():
    # red: 10 lg for 20 lg of the rms
    oaspl = np.array([162.0, 142.0, 152.0])
    rms = 10 ** (oaspl[:, None, None] / 20) * np.ones((1, 4, 2))
    error = np.full_like(rms, 0.1)
    assert claims.shifts_with_level(rms, error, oaspl).holds is True
    rms[0, 3, 1] *= 10 ** (1.5 / 20)
    found = claims.shifts_with_level(rms, error, oaspl)
    assert found.holds is False
    assert "10.00 to 11.50 dB" in found.evidence


def verdict_of(study, summary, psd, reading, words):
    (found,) = (
        v
        for v in claims.verdicts(study, summary, psd, DISTANCE)
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
        summary, psd = respond(scale, error_db=0.1)
        told[name] = {
            verdict.claim: verdict.finding.holds
            for verdict in claims.verdicts(study, summary, psd, DISTANCE)
            if verdict.reading == "paper_corrected"
        }
    flat_spectrum = told["as claimed"].pop("The effect is larger at high frequency")
    assert flat_spectrum is None  # the same in every band
    assert all(told["as claimed"].values())
    for claim in ("most effective", "almost the same", "nearest damper gives", "shifts linearly"):
        (answer,) = (holds for words, holds in told["otherwise"].items() if claim in words)
        assert answer is False, claim


def test_one_level_says_nothing_of_a_shift(study, respond):
    # red: `else` for `elif len(rms) > 1` in verdicts
    one = study.scenarios["level"].model_copy(update={"oaspl_db": (150.0,)})
    alone = study.model_copy(update={"scenarios": {"level": one}})
    summary, psd = respond(FILL | PLACE, error_db=0.1)
    assert not list(claims.verdicts(alone, summary, psd, DISTANCE))
    assert list(claims.verdicts(study, summary, psd, DISTANCE))


def test_a_panel_that_stretches_rises_by_less_than_the_sound():
    # 10 dB of sound, displacement by 10 and 7 dB; red: bare for rms; a rise without its step
    rms = 10 ** (np.array([[0.0, 0.0], [10.0, 10.0], [19.8, 17.0]])[:, :, None] / 20)
    error = np.full(rms.shape, 0.1)
    oaspl = np.array([142.0, 152.0, 162.0])
    found = claims.shifts_when_stretched(rms, rms, error, oaspl)
    assert found.holds is False
    assert "from 152 to 162 dB: 7.00 to 9.80 dB" in found.evidence
    assert claims.shifts_when_stretched(rms[:2], rms[:2], error[:2], oaspl[:2]).holds is True


def test_stretching_is_judged_where_there_is_some(study, respond):
    # red: the claim without `if`; fillna left out
    summary, psd = respond(FILL | PLACE, error_db=0.1)
    assert not any("stretch" in v.claim for v in claims.verdicts(study, summary, psd, DISTANCE))
    loud = summary["oaspl_db"] == 150.0
    for name in ("acceleration_rms_g", "displacement_rms_mm"):
        summary[f"stretched_{name}"] = np.where(loud, 0.6 * summary[name], np.nan)
    found = verdict_of(study, summary, psd, "paper_corrected", "stretching of the panel")
    assert found.holds is False


def test_numbers_without_errors_decide_nothing(study, respond):
    # red: `isfinite` left out of decided, where comparisons with NaN would say "holds"
    summary, psd = respond(FILL | PLACE)
    found = [v for v in claims.verdicts(study, summary, psd, DISTANCE) if v.finding is not None]
    assert found and {verdict.finding.holds for verdict in found} == {None}
    answers = {row[2] for row in blocks_of(verdict_table(found))[0].rows}
    assert answers == {"no error, not judged"}


def test_a_reading_without_response_has_no_verdict(study, respond):
    # red: `whole` always true
    summary, psd = respond(FILL)
    assert verdict_of(study, summary, psd, "paper_printed", "most effective") is None


def test_distances_are_from_the_centres_of_the_patches(basis):
    # red: patches and points swapped. 0.05 m: the cells of the trial mesh measure 0.1 m
    distance = claims.patch_distance(basis)
    assert distance.loc["A", "middle"] < 0.05 > distance.loc["B", "corner"]
    assert distance.loc["A", "corner"] == pytest.approx(np.hypot(0.55, 0.2), abs=0.05)
