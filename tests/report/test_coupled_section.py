"""Coupled runs on the page: what they know, and C_e and m_a over frequency."""

import json
from dataclasses import replace

import numpy as np
import pytest
from coupled_study import coupled_results

from pidpanel.report import html
from pidpanel.report.coupled_section import (
    CURVES,
    coupled_section,
    damping_picture,
)
from pidpanel.report.study_page import study_page
from tests.page_reader import blocks_of

POINTS = ["middle", "corner"]


def coupled_table(results, names, points):
    """The table of the section."""
    return blocks_of(coupled_section(results, names, points))[1]


def test_a_row_has_runs_errors_residual_and_share_of_the_own_force(coupled):
    names = coupled.names
    table = coupled_table(coupled.coupled, names, POINTS)
    assert [row[0] for row in table.rows] == [
        name for label, name in names.items() if not label.startswith("bare")
    ]
    for row in table.rows:
        assert len(row) == len(table.columns)
        # 1 − (8/10)² = 36 %
        assert row[1:] == ["2", "1.0", "+0.00 to +0.20", "36.0", "200", "6.70"]


def test_a_point_at_rest_takes_no_part(coupled):
    summary = coupled.coupled.summary.copy()
    at_rest = summary["point"] == "corner"
    # rounding: none of it is known
    summary.loc[at_rest, ["g_rms", "g_rms_error", "linear_g_rms"]] = 1e-15
    told = coupled.coupled._replace(summary=summary)
    for row in coupled_table(told, coupled.names, ["middle"]).rows:
        assert row[1:] == ["2", "1.0", "+0.00", "36.0", "200", "6.70"]


def test_a_negative_damping_is_not_drawn_and_there_are_few_curves(coupled):
    impedance = coupled.coupled.impedance
    damping, mass = damping_picture("coupled", impedance, coupled.names).charts
    assert len(damping.curves) == len(mass.curves) == min(CURVES, 6)
    drawn = json.loads(damping.json)["curves"][0]
    assert drawn["values"][:2] == pytest.approx([300.0, 100.0]) and drawn["values"][2] is None
    high, low = np.array([band[:2] for band in drawn["band"]], float)
    error = impedance["equivalent_damping_error_n_s_m3"].iloc[0]
    assert high[0] - low[0] == pytest.approx(2 * error)


def test_a_study_of_coupled_runs_alone_has_a_whole_page(coupled, coupled_study):
    one_level = coupled_study.scenarios["level"].model_copy(update={"oaspl_db": (150.0,)})
    scenarios = {**coupled_study.scenarios, "level": one_level}
    study = coupled_study.model_copy(update={"scenarios": scenarios})
    page = study_page(replace(coupled, study=study, coupled=coupled_results(study)), [])
    named = [section.name for section in page.sections]
    assert "coupled" in named and "verdict" not in named
    text = html.render(page)
    assert "10 runs of 5 scenarios" in text
    assert "the motion of each patch in the coupled runs" in text
    assert "LIGGGHTS 3" in text


def test_the_section_states_the_error_by_the_air_where_there_is_some(coupled):
    sections = [
        coupled_section(coupled.coupled, coupled.names, POINTS, in_air=wet) for wet in (False, True)
    ]
    assert ["at most 1.2 %" in blocks_of(s)[0].text for s in sections] == [False, True]
