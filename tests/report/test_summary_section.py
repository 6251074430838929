"""Every scenario and point is in the table, and says what failed."""

from pidpanel.report.summary_section import response_table


def test_each_scenario_and_point_has_a_row_with_all_readings(study, respond):
    # red: readings written one under the other
    summary, _ = respond({("A_r0.1_150dB", "corner"): 3.0}, read_at=312.0, inside=0.5)
    labels = [s.label for s in study.all_scenarios()]
    table = response_table(summary, labels, list(study.panel.points))
    assert len(table.rows) == 2 * len(labels)
    row = dict(
        zip(table.columns[:6], table.rows[labels.index("A_r0.1_150dB") * 2 + 1], strict=False)
    )
    assert row["point"] == "corner"
    assert row["reduction, dB"] == "3.00"
    assert row["Γ of C_e"] == "312 ‡"
    assert table.rows[-1][6:] == ["unstable", "–", "–", "–"]


def test_a_displacement_beyond_linear_theory_is_marked(study, respond):
    # red: the mark left out
    summary, _ = respond({})
    summary.loc[0, "beyond_linear_plate"] = True
    table = response_table(summary, ["bare_150dB"], ["middle"])
    assert table.rows[0][3] == "1.00 †"
