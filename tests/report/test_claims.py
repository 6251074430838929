"""Verdicts follow the numbers, both ways."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml

from pidpanel.report import claims
from pidpanel.report.claims import verdict_table
from pidpanel.report.from_study import partly_known
from pidpanel.study import load_study
from tests.page_reader import blocks_of

POINTS = ["middle", "corner"]
DISTANCE = pd.DataFrame([[0.0, 1.0], [1.0, 0.0]], index=["A", "B"], columns=POINTS)


def table(*rows, index=("0.1", "0.7", "0.9")):
    return pd.DataFrame(rows, index=list(index), columns=POINTS)


def certain(gained, error=0.01):
    """Standard errors [dB] of reductions."""
    return pd.DataFrame(error, gained.index, gained.columns)


def test_the_chosen_row_leads_only_where_it_is_the_highest_of_every_column():
    chosen = pd.Series("0.1", POINTS)
    everywhere = table([3.0, 3.0], [2.5, 2.0], [1.0, 2.5])
    in_part = table([3.0, 1.3], [2.5, 2.0], [1.0, 1.4])
    assert claims.leads(everywhere, certain(everywhere), chosen)[0] == "holds"
    verdict, evidence = claims.leads(in_part, certain(in_part), chosen)
    assert verdict == "does not hold"
    assert "corner: 2.00 dB, 0.7, 0.700 ± 0.014 dB more than 0.1 (claimed)" in evidence


def test_reductions_are_alike_within_the_limit():
    near, far = table([0.0, 0.0], [0.8, 0.3], [0.4, 0.1]), table([0.0, 0.0], [0.8, 1.1], [0.4, 0.1])
    assert claims.is_alike(near, certain(near), 1.0)[0] == "holds"
    assert claims.is_alike(far, certain(far), 1.0)[0] == "does not hold"
    # 0.8 dB apart and alike below 1 dB: with errors of 0.075 dB each they may be more
    assert claims.is_alike(near, certain(near, 0.075), 1.0)[0] == "within the errors"


def test_high_frequency_must_gain_more_in_every_response():
    centre = np.array([100.0, 200.0, 400.0, 800.0])
    rising = np.array([0.0, 1.0, 2.0, 3.0])[None, :, None] * np.ones((2, 1, 2))
    error = np.full_like(rising, 0.1)
    assert claims.gains_at_high_frequency(rising, error, centre)[0] == "holds"
    rising[1, :, 1] = [3.0, 2.0, 1.0, 0.0]
    verdict, evidence = claims.gains_at_high_frequency(rising, error, centre)
    assert verdict == "does not hold" and evidence.startswith("in 3 of 4 responses")


def test_a_shift_is_linear_where_every_band_rises_with_the_sound():
    oaspl = np.array([162.0, 142.0, 152.0])
    rms = 10 ** (oaspl[:, None, None] / 20) * np.ones((1, 4, 2))
    error, bare = np.full_like(rms, 0.1), rms.copy()
    assert claims.rises(oaspl, rms, bare, error, 1.0)[0] == "holds"
    rms[0, 3, 1] *= 10 ** (1.5 / 20)
    verdict, evidence = claims.rises(oaspl, rms, bare, error, 1.0)
    assert verdict == "does not hold"
    assert "from 152 to 162 dB: 10.00 to 11.50 dB, the bare panel 10.00 to 10.00 dB" in evidence
    assert claims.rises(oaspl, rms, bare, error, 2.0)[0] == "holds"


CLAIMED = """
dampers:
  law: {law: paper_corrected}
  printed: {law: paper_printed}
scenarios:
  fill: {patch: A, damper: [law, printed], fill_fraction: [0.1, 0.7, 0.9]}
  place: {patch: [A, B], damper: [law, printed], fill_fraction: 0.5}
  level: {patch: A, damper: [law, printed], fill_fraction: 0.5, oaspl_db: [140, 150]}
claims:
  - {text: A tenth is best, source: "3.1", scenarios: fill, comparison: most_effective, values: [0.1]}
  - {text: All fills help, scenarios: fill, comparison: lowered}
  - {text: More at high frequency, scenarios: fill, comparison: high_frequency}
  - {text: Full ones are alike, scenarios: fill, comparison: alike, values: [0.7, 0.9]}
  - {text: The nearest patch is best, scenarios: place, comparison: nearest_patch}
  - {text: The nearest point gains most, scenarios: place, comparison: nearest_point}
  - {text: It shifts linearly, scenarios: level, comparison: linear}
  - {text: It shifts linearly when stretched, scenarios: level, comparison: linear_stretched}
"""
FILL = {("A_law_r0.1_150dB", p): 4.0 for p in POINTS}
FILL |= {("A_law_r0.7_150dB", p): 2.0 for p in POINTS}
FILL |= {("A_law_r0.9_150dB", p): 1.8 for p in POINTS}
PLACE = {("A_law_r0.5_150dB", "middle"): 3.0, ("A_law_r0.5_140dB", "middle"): 3.0}
PLACE |= {("B_law_r0.5_150dB", "corner"): 3.0}


@pytest.fixture(scope="session")
def study(study_text, tmp_path_factory):
    path = tmp_path_factory.mktemp("claims") / "trial.yaml"
    values = yaml.safe_load(study_text) | yaml.safe_load(CLAIMED)
    path.write_text(yaml.safe_dump(values, sort_keys=False))
    return load_study(path)


def respond(study, lowered, error_db=np.nan):
    """Summary and PSDs, flat, ``lowered`` [dB] by label and point; the printed law has none."""
    frequency, scenarios = np.geomspace(100, 400, 200), study.all_scenarios()
    gains = np.array([[lowered.get((s.label, p), 0.0) for p in POINTS] for s in scenarios])
    gains[[s.dampers == "printed" for s in scenarios]] = np.nan
    level = np.array([s.oaspl_db for s in scenarios])[:, None] - gains
    rms = 10 ** ((level - 150) / 20)
    index = pd.MultiIndex.from_product([[s.label for s in scenarios], POINTS])
    summary = pd.DataFrame({"acceleration_rms_g": rms.ravel()}, index=index)
    summary = summary.rename_axis(["scenario", "point"]).reset_index()
    summary = summary.assign(
        displacement_rms_mm=rms.ravel(), reduction_error_db=error_db, status="ok"
    )
    psd = np.repeat(rms[:, None] ** 2, len(frequency), axis=1)
    dims = ("scenario", "frequency", "point")
    error = np.full_like(psd, error_db * np.log(10) / 10)
    coordinates = {
        "scenario": [s.label for s in scenarios],
        "point": POINTS,
        "frequency": frequency,
    }
    values = {"acceleration_psd": (dims, psd), "acceleration_psd_log_error": (dims, error)}
    return summary, xr.Dataset(values, coordinates)


def verdicts_of(study, responses, model="law"):
    return {
        claim.comparison: row["verdict"]
        for claim, row in zip(
            np.repeat(study.claims, 2), claims.verdicts(study, *responses, DISTANCE), strict=True
        )
        if row["model"].startswith(model)
    }


def test_verdicts_turn_with_the_responses(study):
    opposite = {key: 5 - value for key, value in FILL.items()}
    opposite |= {("A_law_r0.5_150dB", "corner"): 6.0, ("A_law_r0.9_150dB", "middle"): 0.5}
    claimed = verdicts_of(study, respond(study, FILL | PLACE, error_db=0.1))
    assert claimed.pop("high_frequency") == "within the errors"  # the same in every band
    assert list(claimed.values()) == ["holds"] * 7
    turned = verdicts_of(study, respond(study, opposite, error_db=0.1))
    kinds = ("most_effective", "alike", "nearest_patch", "linear")
    assert {turned[kind] for kind in kinds} == {"does not hold"}


def test_the_best_scenario_by_bands_is_named_beside_the_one_by_rms(study):
    summary, psd = respond(study, FILL | PLACE, error_db=0.1)
    better = psd["scenario"] == "A_law_r0.9_150dB"
    psd["acceleration_psd"] = psd["acceleration_psd"].where(~better, 1e-6 * psd["acceleration_psd"])
    row = next(claims.verdicts(study, summary, psd, DISTANCE))
    assert row["verdict"] == "holds"
    assert "In the mean over third octaves middle: A, law, r = 0.9" in row["evidence"]


def test_stretching_is_judged_where_there_is_some(study):
    summary, psd = respond(study, FILL | PLACE, error_db=0.1)
    loud = summary["scenario"].str.endswith("_150dB")
    for name in ("acceleration_rms_g", "displacement_rms_mm"):
        summary[f"stretched_{name}"] = np.where(loud, 0.6 * summary[name], np.nan)
    found = verdicts_of(study, (summary, psd))
    assert found["linear_stretched"] == "does not hold" and found["linear"] == "holds"


def test_the_law_is_judged_by_its_error_against_coupled_runs(study):
    assert partly_known(study) == []


def test_numbers_without_errors_decide_nothing(study):
    found = verdicts_of(study, respond(study, FILL | PLACE))
    assert len(found) == 8 and set(found.values()) == {"no error, not judged"}


def test_a_model_without_response_and_a_single_point_have_no_verdict(study):
    summary, psd = respond(study, FILL | PLACE, error_db=0.1)
    assert set(verdicts_of(study, (summary, psd), "printed").values()) == {"cannot be tested"}
    corner = summary["point"] == "corner"
    alone = summary.assign(status=summary["status"].mask(corner, "held"))
    found = verdicts_of(study, (alone, psd))
    assert found["nearest_point"] == "cannot be tested" and found["nearest_patch"] == "holds"


def test_distances_are_from_the_centres_of_the_patches(basis):
    distance = claims.patch_distance(basis)
    assert distance.loc["A", "middle"] < 0.05 > distance.loc["B", "corner"]
    assert distance.loc["A", "corner"] == pytest.approx(np.hypot(0.55, 0.2), abs=0.05)


def test_of_a_point_on_a_support_nothing_is_claimed(study):
    summary, psd = respond(study, FILL | PLACE, error_db=0.1)
    summary["status"] = summary["status"].mask(summary["point"] == "corner", "held")
    evidence = [row["evidence"] for row in claims.verdicts(study, summary, psd, DISTANCE)]
    assert evidence and not any("corner" in text for text in evidence)


def test_a_claim_is_shown_once_with_its_source_and_all_models(study):
    rows = list(claims.verdicts(study, *respond(study, FILL | PLACE, error_db=0.1), DISTANCE))
    (shown,) = blocks_of(verdict_table(rows))
    assert [row[0] for row in shown.rows[:4]] == ["A tenth is best (3.1)", "", "All fills help", ""]
    assert [row[1].split(":")[0] for row in shown.rows[:2]] == ["law", "printed"]
    assert [row[2] for row in shown.rows[:2]] == ["holds", "cannot be tested"]
    assert verdict_table([]) is None
