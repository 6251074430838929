"""Tables hold what was computed, and say what failed."""

import doctest

import numpy as np
import pytest

from pidpanel.report import tables
from pidpanel.report.findings import Finding, Verdict


def test_table_1_comes_with_its_22_rows_and_the_17_modes_that_it_leaves_out(modes, printed):
    # red: `how="inner"` with a row of the CSV file lost; `~` left out
    assert tables.is_papers_panel(modes, printed)
    first, missing = tables.paper_mode_tables(modes, printed)
    assert len(first.rows) == 22
    assert first.rows[0][:4] == ["(1, 1)", "64.90", "64.90", "64.90"]
    expected = (
        "4,1 5,2 6,1 3,4 6,2 5,3 1,5 2,5 5,4 3,5 7,3 4,5 8,2 5,5 1,6 8,3 2,6".split()
    )  # by the closed form, whichever order
    assert {row[0] for row in missing.rows} == {f"({e[0]}, {e[2]})" for e in expected}


def test_another_panel_is_not_taken_for_the_papers(modes, printed):
    # red: a tolerance of 1
    stiffer = modes.assign(navier_hz=1.01 * modes["navier_hz"])
    assert not tables.is_papers_panel(stiffer, printed)
    assert not tables.is_papers_panel(modes[modes["mode"] < 30], printed)


def test_a_case_that_failed_is_listed_with_its_status(cases):
    # red: rows of status "ok" only
    cases.loc[3, "status"] = "ParticlesLost"
    cases.loc[3, "equivalent_damping_n_s_m3"] = np.nan
    table = tables.case_table(cases)
    assert len(table.rows) == len(cases)
    assert table.rows[3][-1] == "ParticlesLost"
    assert table.rows[3][table.columns.index("C_e, N s/m³")] == "–"
    assert "11 of them ok" in table.caption


def test_each_scenario_and_point_has_a_row_with_all_readings(study, respond):
    # red: readings written one under the other
    summary, _ = respond({("A_r0.1_150dB", "corner"): 3.0}, read_at=312.0, inside=0.5)
    labels = [s.label for s in study.all_scenarios()]
    table = tables.response_table(summary, labels, list(study.panel.points))
    assert len(table.rows) == 2 * len(labels)
    row = dict(
        zip(table.columns[:6], table.rows[labels.index("A_r0.1_150dB") * 2 + 1], strict=False)
    )
    assert row["point"] == "corner"
    assert row["reduction, dB"] == "3.00"
    assert row["C_e read at Γ, g"] == "312 ‡"
    assert table.rows[-1][6:] == ["unstable", "–", "–", "–"]


def test_a_displacement_beyond_linear_theory_is_marked(study, respond):
    # red: the mark left out
    summary, _ = respond({})
    summary.loc[0, "beyond_linear_plate"] = True
    table = tables.response_table(summary, ["bare_150dB"], ["middle"])
    assert table.rows[0][3] == "1.00 †"


def test_a_claim_stands_once_with_all_its_readings():
    # red: rows in the order of the readings
    yes, no = Finding(True, "by 3 dB"), Finding(False, "by 1 dB")
    verdicts = [
        Verdict("one", "dem", yes),
        Verdict("two", "dem", no),
        Verdict("one", "paper_corrected", no),
        Verdict("two", "paper_corrected", None, "no steady response"),
    ]
    table = tables.verdict_table(verdicts)
    law = tables.READINGS["paper_corrected"]
    assert table.rows == [
        ["one", "DEM", "holds", "by 3 dB"],
        ["", law, "does not hold", "by 1 dB"],
        ["two", "DEM", "does not hold", "by 1 dB"],
        ["", law, "cannot be said", "no steady response"],
    ]
    assert tables.verdict_table([]) is None


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0.00"), (99999.0, "99999"), (2.5e6, "2.50·10⁶"), (-0.05, "-0.0500")]
)
def test_numbers_keep_three_digits(value, text):
    # red: a fixed number of decimals
    assert tables.number(value) == text


def test_examples_in_docstrings_hold():
    # red: a changed figure in any example
    result = doctest.testmod(tables)
    assert result.attempted > 0
    assert result.failed == 0
