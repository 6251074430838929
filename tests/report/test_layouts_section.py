"""What the page says of layouts, of dead weight, and of points on a support."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pidpanel.report import (
    response_figures,
    response_section,
    summary_section,
)
from pidpanel.report.rms import moving_points
from pidpanel.study import load_study
from tests.page_reader import blocks_of

MORE = """  two: {layout: {A: {fill_fraction: 0.5}, B: {fill_fraction: 0.3}}}
  one: {layout: {A: {fill_fraction: 0.7}}, oaspl_db: 140}
"""


@pytest.fixture(scope="module")
def with_layouts(tmp_path_factory, study_text):
    path = tmp_path_factory.mktemp("layouts") / "trial.yaml"
    path.write_text(study_text + MORE)
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
            "scenario": "two", "patch": patch, "damper": "law",
            "fill_fraction": fill, "area_m2": 0.04, "mass_kg": 0.2, "damping_read_at_g": gamma,
            "patch_motion_g": gamma, "bare_patch_motion_g": 40.0,
            "lowest_element_motion_g": gamma / 2, "highest_element_motion_g": 1.5 * gamma,
            "outside_run_points_share": share,
        }
        for patch, fill, gamma, share in (("A", 0.5, 20.0, 0.0), ("B", 0.3, 8.0, 0.25))
    ]  # fmt: skip
    return dataclasses.replace(
        inputs,
        study=with_layouts,
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


def rows_of(told, layout):
    (table,) = blocks_of(summary_section.summary_section(told.study, told.summary))
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    return [row for row in rows if row["scenario"].startswith(layout)]


def test_a_layout_has_its_patches_mass_reduction_and_dead_weight_in_the_table(told):
    first, second = rows_of(told, "two")
    assert first["scenario"] == "two (A, r = 0.5; B, r = 0.3)"
    assert first["added, kg"] == "0.400" and first["of the panel, %"] == "6.7"
    assert first["reduction, dB"] == "4.50 ± 0.50" and second["reduction, dB"] == "2.50 ± 0.50"
    assert first["dead weight: reduction, dB"] == second["dead weight: reduction, dB"] == "1.25"


def test_the_figure_of_a_layout_has_its_dead_weight_dotted(told):
    psd = told.psd.copy()
    psd["dead_weight_acceleration_psd"] = psd["acceleration_psd"] / 2
    pictures = response_section.layouts_section(dataclasses.replace(told, psd=psd)).pictures
    assert [p.name for p in pictures] == [f"psd_layouts_{point}" for point in ("middle", "corner")]
    (axes,) = response_figures.charts_figure(pictures[0].charts).axes
    styles = [line.get_linestyle() for line in axes.get_lines()]
    curves = pictures[0].charts[0].curves
    labels = [curve.label for curve in curves]
    weight = psd["dead_weight_acceleration_psd"].sel(scenario="two", point="middle")
    drawn = curves[labels.index("two: dead weight")].values
    assert drawn * 9.80665**2 == pytest.approx(weight.to_numpy().ravel())
    assert styles[labels.index("two: dead weight")] == ":"
    assert styles[labels.index("two")] == "-"


def test_of_a_point_on_a_support_nothing_is_drawn(told):
    on_support = held(told, "corner")
    assert moving_points(on_support.summary, ["middle", "corner"]) == ["middle"]
    section = response_section.layouts_section(on_support)
    assert not any("corner" in picture.name for picture in section.pictures)
