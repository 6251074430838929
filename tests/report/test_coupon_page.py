"""What a study of the coupon alone says of its cases."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report import coupon_page, losses
from pidpanel.report.coupon_page import comparison, findings, varied_figure


@pytest.fixture
def varied(cases):
    """The cases at three frictions; C_e grows like the root of μ."""
    frames = []
    for friction in (0.1, 0.4, 0.9):
        frame = cases.copy()
        frame["particles.friction"] = friction
        frame["equivalent_damping_n_s_m3"] *= np.sqrt(friction / 0.1)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def test_a_case_is_compared_with_that_at_the_first_value_all_else_equal(varied):
    # red: the last value for the first; the errors added instead of squared
    found = comparison(varied, "particles.friction")
    assert len(found) == 2 * 12
    assert set(found["from"]) == {0.1}
    assert found["ratio"][found["to"] == 0.9].tolist() == pytest.approx([3.0] * 12)
    first = found.iloc[0]
    value = 500 * 0.3  # r = 0.3, 100 Hz
    assert first["deviation"] == pytest.approx(value / np.hypot(20, 20))
    assert first["ratio_error"] == pytest.approx(2 * np.hypot(20 / value, 20 / (2 * value)))


def test_the_bias_of_soft_contacts_counts_where_the_moduli_differ(varied):
    varied["equivalent_damping_error_n_s_m3"] = 30.0
    same = comparison(varied, "particles.friction")["deviation"]
    varied.loc[varied["particles.friction"] > 0.1, "youngs_modulus_mpa"] = 500.0
    other = comparison(varied, "particles.friction")["deviation"]
    assert (same / other).tolist() == pytest.approx([1.5] * 24)


def test_the_finding_names_the_largest_change_with_its_point(varied):
    (said,) = findings(varied, ["particles.friction"])
    assert said.startswith("friction coefficient μ: from 0.1 to 0.9 C_e changes by a factor of 3 ±")
    assert "Of 24 differences 24 are larger" in said


def test_what_does_not_matter_is_said_not_to(cases):
    twice = pd.concat([cases.assign(deck="a"), cases.assign(deck="b")], ignore_index=True)
    (said,) = findings(twice, ["deck"])
    assert "a factor of 1 ±" in said
    assert "Of 12 differences none is larger than two of their standard errors" in said


def test_every_point_is_drawn_at_its_value_and_words_in_their_order(varied, cases):
    figure = varied_figure(varied, "particles.friction")
    drawn = [
        bar[0].get_xydata()
        for axes in figure.axes
        for bar in axes.containers
        if len(bar[0].get_xydata())
    ]
    assert sum(len(points) for points in drawn) == len(varied)
    assert {x for points in drawn for x in points[:, 0]} == {0.1, 0.4, 0.9}
    words = pd.concat([cases.assign(deck="lab"), cases.assign(deck="cell")], ignore_index=True)
    axes = varied_figure(words, "deck").axes[0]
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["lab", "cell"]


def test_losses_are_shown_in_per_cent_of_what_they_are_a_share_of(cases):
    figure = losses.losses_figure(cases)
    left, right = figure.axes
    assert {y for line in left.lines for y in line.get_ydata()} == {45.0}
    assert {y for line in right.lines for y in line.get_ydata()} == {-1.0, 0.0}
    assert losses.losses_picture(cases.assign(closure=np.nan)) is None


def test_sizes_are_varied_only_where_there_are_several():
    from pidpanel.study import CouponStudy

    sweep = {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [5]}
    study = CouponStudy.model_validate({"name": "x", "coupon": {"sweep": sweep}})
    assert coupon_page.varied_keys(study) == []
    sweep["diameter_mm"] = [1, 2]
    study = CouponStudy.model_validate(
        {"name": "x", "coupon": {"sweep": sweep, "vary": {"particles.friction": [0.1]}}}
    )
    assert coupon_page.varied_keys(study) == ["particles.friction", "diameter_mm"]
