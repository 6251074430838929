"""The panel on the page: Table 1 of the paper beside what was computed."""

from pidpanel.report import panel_section


def test_table_1_comes_with_its_22_rows_and_the_17_modes_that_it_leaves_out(modes, printed):
    # red: `how="inner"` with a row of the CSV file lost; `~` left out
    assert panel_section.is_papers_panel(modes, printed)
    first, missing = panel_section.paper_mode_tables(modes, printed)
    assert len(first.rows) == 22
    assert first.rows[0][:4] == ["(1, 1)", "64.90", "64.90", "64.90"]
    expected = (
        "4,1 5,2 6,1 3,4 6,2 5,3 1,5 2,5 5,4 3,5 7,3 4,5 8,2 5,5 1,6 8,3 2,6".split()
    )  # by the closed form, whichever order
    assert {row[0] for row in missing.rows} == {f"({e[0]}, {e[2]})" for e in expected}


def test_another_panel_is_not_taken_for_the_papers(modes, printed):
    # red: a tolerance of 1
    stiffer = modes.assign(navier_hz=1.01 * modes["navier_hz"])
    assert not panel_section.is_papers_panel(stiffer, printed)
    assert not panel_section.is_papers_panel(modes[modes["mode"] < 30], printed)
