"""Verdicts follow the numbers, both ways."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report import claims
from pidpanel.report.claims import verdict_table
from tests.page_reader import blocks_of

POINTS = ["middle", "corner"]
DISTANCE = pd.DataFrame([[0.0, 1.0], [1.0, 0.0]], index=["A", "B"], columns=POINTS)


def table(*rows, index=("0.1", "0.7", "0.9")):
    return pd.DataFrame(rows, index=list(index), columns=POINTS)


def certain(gained, error=0.01):
    """Standard errors [dB] of reductions."""
    return pd.DataFrame(error, gained.index, gained.columns)


def test_the_chosen_row_leads_only_where_it_is_the_highest_of_every_column():
    # red: `.any()` for `.all()` in decided; the second for the first in leads
    chosen = pd.Series("0.1", POINTS)
    everywhere = table([3.0, 3.0], [2.5, 2.0], [1.0, 2.5])
    in_part = table([3.0, 1.3], [2.5, 2.0], [1.0, 1.4])
    assert claims.leads(everywhere, certain(everywhere), chosen)[0] == "holds"
    verdict, evidence = claims.leads(in_part, certain(in_part), chosen)
    assert verdict == "does not hold"
    assert "corner: 2.00 dB, 0.7, 0.700 ± 0.014 dB more than 0.1 (claimed)" in evidence


def test_reductions_are_alike_within_the_limit():
    # red: one error for the two in math.hypot
    near, far = table([0.0, 0.0], [0.8, 0.3], [0.4, 0.1]), table([0.0, 0.0], [0.8, 1.1], [0.4, 0.1])
    assert claims.is_alike(near, certain(near), 1.0)[0] == "holds"
    assert claims.is_alike(far, certain(far), 1.0)[0] == "does not hold"
    # 0.8 dB apart and alike below 1 dB: with errors of 0.075 dB each they may be more
    assert claims.is_alike(near, certain(near, 0.075), 1.0)[0] == "within the errors"


def test_high_frequency_must_gain_more_in_every_response():
    # red: halves exchanged
    centre = np.array([100.0, 200.0, 400.0, 800.0])
    rising = np.array([0.0, 1.0, 2.0, 3.0])[None, :, None] * np.ones((2, 1, 2))
    error = np.full_like(rising, 0.1)
    assert claims.gains_at_high_frequency(rising, error, centre)[0] == "holds"
    rising[1, :, 1] = [3.0, 2.0, 1.0, 0.0]
    verdict, evidence = claims.gains_at_high_frequency(rising, error, centre)
    assert verdict == "does not hold" and evidence.startswith("in 3 of 4 responses")


def test_a_shift_is_linear_where_every_band_rises_with_the_sound():
    # red: 10 lg for 20 lg of the rms; levels not in order
    oaspl = np.array([162.0, 142.0, 152.0])
    rms = 10 ** (oaspl[:, None, None] / 20) * np.ones((1, 4, 2))
    error, bare = np.full_like(rms, 0.1), rms.copy()
    assert claims.rises(oaspl, rms, bare, error, 1.0)[0] == "holds"
    rms[0, 3, 1] *= 10 ** (1.5 / 20)
    verdict, evidence = claims.rises(oaspl, rms, bare, error, 1.0)
    assert verdict == "does not hold"
    assert "from 152 to 162 dB: 10.00 to 11.50 dB, the bare panel 10.00 to 10.00 dB" in evidence
    assert claims.rises(oaspl, rms, bare, error, 2.0)[0] == "holds"


FILL = {("A_r0.1_150dB", p): 4.0 for p in POINTS}
FILL |= {("A_r0.7_150dB", p): 2.0 for p in POINTS} | {("A_r0.9_150dB", p): 1.8 for p in POINTS}
PLACE = {("A_r0.5_150dB", "middle"): 3.0, ("A_r0.5_140dB", "middle"): 3.0}
PLACE |= {("B_r0.5_150dB", "corner"): 3.0}


def verdicts_of(study, responses):
    return {
        row["claim"].comparison: row["verdict"]
        for row in claims.verdicts(study, *responses, DISTANCE)
    }


def test_verdicts_turn_with_the_responses(study, respond):
    # red: another family in verdicts; bare panels of another level; rows and columns exchanged
    opposite = {key: 5 - value for key, value in FILL.items()}
    opposite |= {("A_r0.5_150dB", "corner"): 6.0, ("A_r0.9_150dB", "middle"): 0.5}
    claimed = verdicts_of(study, respond(FILL | PLACE, error_db=0.1))
    assert claimed.pop("high_frequency") == "within the errors"  # the same in every band
    claimed.pop("linear_stretched")  # displacements are made up
    assert list(claimed.values()) == ["holds"] * 6
    turned = verdicts_of(study, respond(opposite, error_db=0.1))
    kinds = ("most_effective", "alike", "nearest_patch", "linear")
    assert {turned[kind] for kind in kinds} == {"does not hold"}


def test_the_best_scenario_by_bands_is_named_beside_the_one_by_rms(study, respond):
    # red: idxmin for idxmax of the mean
    summary, psd = respond(FILL | PLACE, error_db=0.1)
    better = psd["scenario"] == "A_r0.9_150dB"
    psd["acceleration_psd"] = psd["acceleration_psd"].where(~better, 1e-6 * psd["acceleration_psd"])
    row = next(claims.verdicts(study, summary, psd, DISTANCE))
    assert row["verdict"] == "holds"
    assert "In the mean over third octaves middle: A, r = 0.9" in row["evidence"]


def test_stretching_is_judged_where_there_is_some(study, respond):
    # red: fillna left out; the bare panel for the scenario in motions
    summary, psd = respond(FILL | PLACE, error_db=0.1)
    loud = summary["oaspl_db"] == 150.0
    for name in ("acceleration_rms_g", "displacement_rms_mm"):
        summary[f"stretched_{name}"] = np.where(loud, 0.6 * summary[name], np.nan)
    found = verdicts_of(study, (summary, psd))
    assert found["linear_stretched"] == "does not hold" and found["linear"] == "holds"


def test_numbers_without_errors_decide_nothing(study, respond):
    # red: `isfinite` left out of decided, where comparisons with NaN would say "holds"
    found = verdicts_of(study, respond(FILL | PLACE))
    assert len(found) == 8 and set(found.values()) == {"no error, not judged"}


def test_a_model_without_response_and_a_single_point_have_no_verdict(study, respond):
    # red: `isfinite` left out of finding_of; `len(points) > 1` left out of verdicts
    summary, psd = respond(FILL | PLACE, error_db=0.1)
    lost = summary.assign(acceleration_rms_g=np.nan, reduction_db=np.nan)
    assert set(verdicts_of(study, (lost, psd)).values()) == {"cannot be tested"}
    corner = summary["point"] == "corner"
    alone = summary.assign(status=summary["status"].mask(corner, "held"))
    found = verdicts_of(study, (alone, psd))
    assert found["nearest_point"] == "cannot be tested" and found["nearest_patch"] == "holds"


def test_distances_are_from_the_centres_of_the_patches(basis):
    # red: patches and points swapped. 0.05 m: the cells of the trial mesh measure 0.1 m
    distance = claims.patch_distance(basis)
    assert distance.loc["A", "middle"] < 0.05 > distance.loc["B", "corner"]
    assert distance.loc["A", "corner"] == pytest.approx(np.hypot(0.55, 0.2), abs=0.05)


def test_a_claim_is_shown_once_with_its_source_and_all_models(study, respond):
    # red: source left out; the claim in every row
    rows = list(claims.verdicts(study, *respond(FILL | PLACE, error_db=0.1), DISTANCE))
    (shown,) = blocks_of(verdict_table(rows))
    assert shown.rows[0][:3] == [
        "A tenth is best (the paper, 3.1)",
        "The paper's law, corrected",
        "holds",
    ]
    assert shown.rows[1][0] == "All fills help"
    assert verdict_table([]) is None
