"""The panel on the page: Table 1 of the paper beside what was computed."""

from pidpanel.report import panel_section
from tests.page_reader import blocks_of


def test_table_1_comes_with_its_22_rows_and_the_17_modes_that_it_leaves_out(basis, modes, printed):
    assert panel_section.is_papers_panel(modes, printed)
    _, table = blocks_of(panel_section.panel_section(basis, modes, printed))
    assert table.folded
    assert len(table.rows) == len(modes)
    assert table.rows[0][1:5] == ["1", "1", "64.90", "64.90"] and table.rows[0][-2] == "64.90"
    assert "has 22 of them" in table.caption and "leaves out 17 below 1700 Hz" in table.caption
    expected = (
        "4,1 5,2 6,1 3,4 6,2 5,3 1,5 2,5 5,4 3,5 7,3 4,5 8,2 5,5 1,6 8,3 2,6".split()
    )  # by the closed form, whichever order
    missing = [row for row in table.rows if row[-1] == "–" and float(row[3]) < 1700]
    assert {f"{row[1]},{row[2]}" for row in missing} == set(expected)


def test_modes_without_orders_and_closed_forms_have_no_columns_of_them(basis, modes, printed):
    plain = modes.drop(columns=["m", "n", "navier_hz"])
    _, table = blocks_of(panel_section.panel_section(basis, plain, printed))
    assert table.columns == ["mode", "computed, Hz", "modal mass, kg"]


def test_another_panel_is_not_taken_for_the_papers(modes, printed):
    stiffer = modes.assign(navier_hz=1.01 * modes["navier_hz"])
    assert not panel_section.is_papers_panel(stiffer, printed)
    assert not panel_section.is_papers_panel(modes[modes["mode"] < 30], printed)
