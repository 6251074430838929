"""Every scenario and point is in the table, and says what failed."""

import numpy as np

from pidpanel.report.summary_section import summary_section
from pidpanel.response.stretching import COLUMNS as STRETCHED
from tests.page_reader import blocks_of


def test_each_scenario_and_point_has_a_row(study, respond):
    summary, _ = respond({("A_r0.1_150dB", "corner"): 3.0}, read_at=312.0, inside=0.5)
    (table,) = blocks_of(summary_section(study, summary))
    assert len(table.rows) == 2 * len(study.all_scenarios())
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    (row,) = (
        row for row in rows if row["scenario"] == "A, r = 0.1, 150 dB" and row["point"] == "corner"
    )
    assert row["reduction, dB"] == "3.00"
    assert row["Γ of Cₑ"] == "312 ‡"
    summary.loc[summary.index[-1], "status"] = "unstable"
    (table,) = blocks_of(summary_section(study, summary))
    assert table.rows[-1][4:] == ["unstable", "–", "–", "–", "–"]


def test_a_displacement_beyond_linear_theory_is_marked(study, respond):
    summary, _ = respond({})
    summary.loc[0, "beyond_linear_plate"] = True
    (table,) = blocks_of(summary_section(study, summary))
    marked = [row[5] for row in table.rows if row[5] != "–"]
    assert marked.count("1.00 †") == 1 and set(marked) == {"1.00", "1.00 †"}


def test_a_point_on_a_support_does_not_move(study, respond):
    summary, _ = respond({})
    summary.loc[summary["point"] == "corner", "status"] = "held"
    (table,) = blocks_of(summary_section(study, summary))
    assert all(row[4] == "does not move" for row in table.rows if row[3] == "corner")


def test_stretching_has_its_columns_where_a_panel_stretches(study, respond):
    summary, _ = respond({})
    (table,) = blocks_of(summary_section(study, summary))
    assert not any("stretched" in head for head in table.columns)
    at = 0
    summary.loc[at, "beyond_linear_plate"] = True
    summary = summary.assign(**dict.fromkeys(STRETCHED, np.nan))
    summary.loc[at, list(STRETCHED)] = 12.34, 0.21, 0.912, 0.0123, 0.0, 5.43, 0.44
    _, table = blocks_of(summary_section(study, summary))
    heads = [head for head in table.columns if "stretched" in head or "shift" in head]
    first = table.columns.index(heads[0])
    (values,) = (row[first : first + len(heads)] for row in table.rows)
    assert [value.split(" ± ")[0] for value in values] == ["12.34", "0.912", "5.43"]
    assert "edges free in the plane" in " ".join(table.caption.split())
