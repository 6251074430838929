"""What the page says of layouts, of dead weight, and of points on a support."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pidpanel.report import (
    claims,
    layouts_section,
    response_figures,
    summary_section,
    warnings,
)
from pidpanel.report.from_study import reported_study
from pidpanel.report.outcome import outcome
from pidpanel.report.rms import moving_points
from pidpanel.study import load_study

MORE = """  two: {layout: {A: {fill_fraction: 0.5}, B: {fill_fraction: 0.3}}}
  one: {layout: {A: {fill_fraction: 0.7}}, oaspl_db: 140}
"""


@pytest.fixture(scope="module")
def with_layouts(tmp_path_factory, study_text):
    path = tmp_path_factory.mktemp("layouts") / "trial.yaml"
    path.write_text(study_text.replace("paper_corrected, paper_printed", "paper_corrected") + MORE)
    return load_study(path)


@pytest.fixture
def told(inputs, with_layouts, respond_to):
    """Inputs of a study with two layouts; ``two`` weighs 0.4 kg and its mean hides a factor 3."""
    summary, psd = respond_to(with_layouts, {("two", "middle"): 4.5, ("two", "corner"): 2.5})
    of = summary["scenario"] == "two"
    summary.loc[of, "added_mass_kg"] = 0.4
    summary.loc[of, "added_mass_percent"] = 6.7
    summary.loc[of, "dead_weight_reduction_db"] = 1.25
    summary["acceleration_rms_error_g"] = np.nan
    summary["reduction_error_db"] = np.where(of, 0.5, np.nan)
    rows = [
        {
            "reading": "paper_corrected", "scenario": "two", "patch": patch, "damper": "coupon",
            "fill_fraction": fill, "area_m2": 0.04, "mass_kg": 0.2, "damping_read_at_g": gamma,
            "patch_motion_g": gamma, "bare_patch_motion_g": 40.0,
            "lowest_element_motion_g": gamma / 2, "highest_element_motion_g": 1.5 * gamma,
            "outside_run_points_share": share,
        }
        for patch, fill, gamma, share in (("A", 0.5, 20.0, 0.0), ("B", 0.3, 8.0, 0.25))
    ]  # fmt: skip
    return dataclasses.replace(
        inputs,
        study=reported_study(with_layouts),
        summary=summary,
        psd=psd,
        layouts=pd.DataFrame(rows),
    )


def held(inputs, point):
    """The same with a point on a support."""
    summary = inputs.summary.copy()
    of = (summary["point"] == point) & (summary["status"] == "ok")
    summary.loc[of, "status"] = "held"
    summary.loc[of, ["acceleration_rms_g", "reduction_db"]] = 0.0
    return dataclasses.replace(inputs, summary=summary)


def test_the_table_of_layouts_has_mass_reduction_dead_weight_and_what_is_left(told):
    # red: the difference with its sign turned; mass_table of the families
    table = layouts_section.layouts_section(told).blocks[0]
    assert table.columns[-3:] == ["reduction, dB", "dead weight: reduction, dB", "difference, dB"]
    first, second, *_ = table.rows
    assert first[:2] == ["two", "A: r = 0.5; B: r = 0.3"]
    assert first[2:5] == ["0.400", "6.7", "middle"]
    assert first[-3:] == ["4.50 ± 0.50", "1.25", "3.25"]
    assert second[:4] == ["", "", "", ""]
    assert second[-3:] == ["2.50 ± 0.50", "1.25", "1.25"]


def test_a_mass_that_is_not_known_is_a_dash(told):
    # red: f"{value:.2f}" of a NaN
    table = layouts_section.layouts_section(told).blocks[0]
    one = next(row for row in table.rows if row[0] == "one")
    assert one[2:4] == ["–", "–"] and one[-2:] == ["–", "–"]


def test_what_the_mean_of_a_patch_hides_is_shown_patch_by_patch(told):
    # red: the range of the whole layout in every row
    table = layouts_section.layouts_section(told).blocks[-1]
    assert [row[9] for row in table.rows] == ["10.0 to 30.0", "4.00 to 12.0"]
    assert "damping.level.by: element" in table.caption


def test_the_figure_of_a_layout_has_its_dead_weight_dotted(told, monkeypatch):
    # red: `dotted` left out of the dead weight's Curve; `dotted` left out of _draw
    psd, drawn = told.psd.copy(), []

    def seen(*given):
        drawn.append(given[1][0].curves)
        return psd_figure(*given)

    psd_figure = response_figures.psd_figure
    monkeypatch.setattr(response_figures, "psd_figure", seen)
    psd["dead_weight_acceleration_psd"] = psd["acceleration_psd"] / 2
    pictures = layouts_section.layouts_section(dataclasses.replace(told, psd=psd)).pictures
    assert [p.name for p in pictures] == [
        f"psd_layouts_paper_corrected_1_{point}" for point in ("middle", "corner")
    ]
    frequency = psd["frequency"].to_numpy()
    (axes,) = psd_figure(frequency, [response_figures.FigurePanel("", "", drawn[0])]).axes
    styles = [line.get_linestyle() for line in axes.get_lines()]
    labels = [curve.label for curve in drawn[0]]
    assert styles[labels.index("two: dead weight")] == ":"
    assert styles[labels.index("two")] == "-"


def test_a_damper_beyond_its_data_and_dead_weight_do_not_look_alike_on_the_screen(told):
    # red: one `dashed` for both
    psd = told.psd.assign(dead_weight_acceleration_psd=told.psd["acceleration_psd"] / 2)
    psd["inside"] = 0 * psd["inside"]
    picture = layouts_section.layouts_section(dataclasses.replace(told, psd=psd)).pictures[0]
    lines = {curve.label: curve.line for curve in picture.charts[0].curves}
    assert lines["two"] == "dashed" and lines["two: dead weight"] == "dotted"


def test_all_rows_of_a_table_have_the_same_decimals(told):
    # 66.545 ± 0.054 beside 38.6 ± 1.9; red: value_text without decimals
    summary = told.summary.copy()
    first = summary["point"] == "middle"
    summary["acceleration_rms_error_g"] = np.where(first, 0.054, 1.9)
    table = layouts_section.layouts_section(dataclasses.replace(told, summary=summary)).blocks[0]
    rms = [row[table.columns.index("g rms")] for row in table.rows]
    assert {text.split(" ± ")[1] for text in rms} == {"0.1", "1.9"}
    assert {len(text.split(" ± ")[0].partition(".")[2]) for text in rms} == {1}


def test_the_best_layout_is_told_with_the_same_mass_as_dead_weight(told):
    # red: layouts left out of outcome; a comparison with an error that is not known
    first = told.summary.assign(reduction_error_db=0.5)
    said = [text for text in outcome(told.study, first) if "Layouts" in text]
    assert len(said) == 1
    assert "at middle most with two (4.50 ± 0.50 dB with 0.40 kg; 1.2 dB as dead weight" in said[0]
    (said,) = (text for text in outcome(told.study, told.summary) if "Layouts" in text)
    assert "at middle reductions of 0.00 to 4.50 dB, without a stated error" in said


def test_damping_outside_the_simulated_range_is_told_of_the_patch_that_is_there(told):
    # red: Γ of all patches, or NaN, in the warning
    summary, psd = told.summary.copy(), told.psd.copy(deep=True)
    summary.loc[summary["scenario"] == "two", "outside_run_points_share"] = 0.25
    at = {"reading": "paper_corrected", "scenario": "two", "patch": "B"}
    psd["inside"].loc[at] = np.where(psd["frequency"] < 150, 0.0, 1.0)
    said = warnings.response_warnings(told.study, summary, psd, told.layouts)
    (outside,) = (text for text in said if "extrapolated" in text)
    assert "two, Γ = 8 (B), 25 % of the lines (100–150 Hz)" in outside


def test_a_motion_that_is_not_converged_and_a_basis_that_is_not_right_are_told(told):
    # red: the thresholds taken for percent
    summary = told.summary.assign(basis_error=1e-4)
    assert not any(
        "converged" in text or "all elements" in text
        for text in warnings.response_warnings(told.study, summary, told.psd, told.layouts)
    )
    of = summary["scenario"] == "two"
    summary.loc[of, ["motion_residual", "basis_error"]] = 0.02, 0.011
    said = warnings.response_warnings(told.study, summary, told.psd, told.layouts)
    assert any("not converged in two" in text and "2.0 %" in text for text in said)
    assert any("PSDs of two" in text and "1.1 %" in text for text in said)


def test_of_a_point_on_a_support_nothing_is_claimed_and_nothing_drawn(told):
    # red: moving_points that returns all points
    on_support = held(told, "corner")
    summary, study = on_support.summary, on_support.study
    assert moving_points(summary, ["middle", "corner"]) == ["middle"]
    distance = claims.patch_distance(on_support.basis)
    evidence = [
        verdict.finding.evidence
        for verdict in claims.verdicts(study, summary, on_support.psd, distance)
        if verdict.finding
    ]
    assert evidence and not any("corner" in text for text in evidence)
    assert not any("corner" in text for text in outcome(study, summary))
    section = layouts_section.layouts_section(on_support)
    assert not any("corner" in picture.name for picture in section.pictures)
    assert any(getattr(b, "text", "").startswith("Point corner does not") for b in section.blocks)
    labels = [scenario.label for scenario in study.scenarios]
    rows = summary_section.response_table(summary, labels, ["middle", "corner"]).rows
    assert all("does not move" in row for row in rows if row[1] == "corner")
    said = warnings.response_warnings(study, summary, on_support.psd, on_support.layouts)
    assert not any("no steady response" in text for text in said)
