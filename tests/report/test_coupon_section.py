"""The coupon on the page: its figures, its table, its picture."""

import numpy as np
import pytest

from pidpanel.paths import STUDIES
from pidpanel.report import coupon_figures, coupon_section
from pidpanel.report.inputs import CouponResults
from pidpanel.report.study_page import coupon_page
from pidpanel.study import load_any_study
from tests.page_reader import blocks_of

STUDY = load_any_study(STUDIES / "coupon_friction.yaml")
STAMP = {"pidpanel_version": "1", "liggghts_version": "3.8", "study": "s", "study_hash": "0"}


@pytest.fixture
def coupon(cases):
    cases.loc[2, "status"] = "NotSteady"
    return CouponResults(cases)


def pictures(section):
    return section.pictures


def test_a_coupon_page_shows_the_loss_factor_over_frequency_and_acceleration_first(coupon):
    cases = coupon.cases
    cases["loss_factor"] = cases["fill_fraction"] + cases["frequency_hz"] / 1e4
    page = coupon_page(STUDY, STAMP, coupon, [])
    maps = page.first[0].values["maps"]
    good = cases  # NotSteady counts
    assert [table.title for table in maps] == [
        f"r = {fill:g}" for fill in sorted(good["fill_fraction"].unique())
    ]
    texts = [text for table in maps for row in table.cells for text, _, _ in row]
    assert sorted(float(text) for text in texts if text != "–") == pytest.approx(
        sorted(good["loss_factor"]), abs=0.0005
    )


def test_a_case_that_failed_is_listed_with_its_status(cases):
    cases.loc[3, "status"] = "ParticlesLost"
    cases.loc[3, "equivalent_damping_n_s_m3"] = np.nan
    table = blocks_of(coupon_section.coupon_section(CouponResults(cases)))[-1]
    assert len(table.rows) == len(cases)
    assert table.rows[3][-1] == "ParticlesLost"
    assert table.rows[3][table.columns.index("Cₑ, N s/m³")] == "–"
    assert "11 of them ok" in table.caption


def test_a_case_of_several_states_has_them_in_its_row_and_is_counted(cases):
    section = coupon_section.coupon_section(CouponResults(cases))
    assert blocks_of(section)[0].kind == "picture"
    cases.loc[2, ["states", "state_damping_n_s_m3", "state_share"]] = [
        2,
        "216.6 671.2",
        "0.25 0.75",
    ]
    section = coupon_section.coupon_section(CouponResults(cases))
    paragraph, *_, table = blocks_of(section)
    assert "In 1 case the cells end in different states" in paragraph.text
    column = table.columns.index("states: Cₑ (share of the cells)")
    found = [row[column] for row in table.rows]
    assert found[2] == "217 (25 %); 671 (75 %)"
    assert set(found[:2] + found[3:]) == {""}


def test_a_table_of_cases_is_a_point_for_each_case_over_each_quantity(coupon):
    count = len(coupon.cases)
    cases = coupon.cases.assign(
        **{"particles.friction": np.linspace(0.1, 0.8, count), "gravity_direction": "0 0 -1"}
    )
    varied = ["particles.friction", "gravity_direction"]
    design = CouponResults(cases, varied=varied, is_design=True)
    figure = coupon_figures.design_figure(cases, varied)
    drawn = [axes for axes in figure.axes if axes.get_visible()]
    assert [axes.get_xlabel() for axes in drawn][-1] == "particles.friction"
    assert [len(axes.lines[0].get_xdata()) for axes in drawn] == [count] * 4
    page = coupon_page(STUDY, STAMP, design, [])
    assert page.pictures[0].name == "loss_factor_design"
    assert [section.name for section in page.sections] == ["coupon"]


def test_errors_of_the_energy_balance_are_said(cases):
    said = [b.text for b in blocks_of(coupon_section.coupon_section(CouponResults(cases)))
            if b.kind == "paragraph"]  # fmt: skip
    assert any("error 1.00 % in the median, 1.00 % at most" in text for text in said)
    unknown = CouponResults(cases.assign(closure=np.nan))
    blocks = blocks_of(coupon_section.coupon_section(unknown))
    assert not any("Energy balance" in b.text for b in blocks if b.kind == "paragraph")
