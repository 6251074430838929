"""The margin on the page: numbers of the tables of the stage, for the answer that governs."""

import pandas as pd
import pytest

from pidpanel.report.html import Page, render
from pidpanel.report.inputs import SpreadResults
from pidpanel.report.margin_section import (
    margin_first,
    margin_headline,
    margin_section,
    update_lines,
)

PLACE = {"scenario": "A", "point": "326", "panel": "damped", "inputs": "stated"}


def results(level="median"):
    row = {
        "nominal_g": 15.1, "p05_g": 11.9, "p50_g": 15.6, "p95_g": 19.4, "limit_g": 25.0,
        "probability_exceeding": 0.012, "samples": 16384, "margin_of_safety_p50": 0.28,
        "margin_of_safety_p95": 0.03, "q2": 0.99,
    }  # fmt: skip
    bare = {**row, **PLACE, "panel": "bare", "p05_g": 13.5, "p95_g": 21.5}
    other = {**row, **PLACE, "point": "1", "p95_g": 99.0}
    shares = [
        {**PLACE, "input": name, "share_alone": share, "share": share, "source": "a survey"}
        for name, share in (("panel.damping_ratio", 0.55), ("sound.spectrum", 0.24))
    ]
    tests = [
        {**PLACE, "measurement": name, "tests": count, "share_left": left, "interval_width_g": 5.0}
        for name, count, left in (
            ("none", 0, 1.0), ("modal survey", 1, 0.4), ("microphones", 1, 0.8),
            ("modal survey and microphones", 2, 0.2),
        )
    ]  # fmt: skip
    tables = (pd.DataFrame([bare, {**row, **PLACE}, other]), pd.DataFrame(shares))
    return SpreadResults(*tables, pd.DataFrame(tests), 1.25, level)


def updated(**update):
    """`results` after a modal survey."""
    stated = results()
    states = {"inputs": "updated"}
    ranges, shares, tests = (
        pd.concat([table, table.assign(**states, **other)])
        for table, other in (
            (stated.ranges, {"p05_g": 13.1, "p95_g": 15.9, "probability_exceeding": 1e-9}),
            (stated.shares.iloc[::-1], {"share_alone": 0.77}),
            (stated.next_test[stated.next_test["measurement"] != "modal survey"], {}),
        )
    )
    rows = {"test": "modal survey", "quantity": "frequency of mode 3", "score": -7.5,
            "probability": 0.3, "probability_together": 0.3} | update  # fmt: skip
    inputs = {"input": "panel.damping_ratio", "stated_p05": 0.006, "stated_p50": 0.01,
              "stated_p95": 0.018, "updated_p05": 0.0091, "updated_p50": 0.01,
              "updated_p95": 0.0112}  # fmt: skip
    return stated._replace(
        ranges=ranges, shares=shares, next_test=tests, update=pd.DataFrame([rows]),
        inputs=pd.DataFrame([inputs]),
    )  # fmt: skip


def test_after_a_test_the_answer_is_the_updated_one_beside_what_it_was():
    text = margin_headline(updated(), {"A": "half full"})
    for part in ("After modal survey", "13.1", "15.9", "11.9 to 19.4 before", "below 0.018 %",
                 "before: 1.2 %", "sound.spectrum (0.77)", "Next test: microphones"):  # fmt: skip
        assert part in text, part
    first = margin_first(updated(), {"A": "half full"})
    page = render(Page(title="t", answer="a", facts=[], first=[first], sections=[]))
    for part in ("0.0091", "half full, after tests", "further test"):
        assert part in page, part


def test_a_test_that_contradicts_the_spreads_is_named_in_one_line():
    lines = update_lines(updated(probability=1e-7), {})
    assert len(lines) == 1
    for part in ("modal survey contradicts", "frequency of mode 3", "−7.5 σ", "not used"):
        assert part in lines[0], part
    assert len(update_lines(updated(probability_together=1e-7), {})) == 2
    assert update_lines(results(), {}) == []


def test_the_answer_is_what_to_sign_and_what_to_measure_next():
    text = margin_headline(results(), {"A": "half full"})
    for part in ("326", "half full", "11.9", "19.4", "13.5", "21.5", "+0.28", "+0.03", "1.2 %",
                 "panel.damping_ratio", "0.55", "modal survey"):  # fmt: skip
        assert part in text, part
    assert "99" not in text


def test_the_first_screen_has_bars_shares_and_what_tests_leave():
    page = Page(
        title="t", answer="a", facts=[], first=[margin_first(results(), {"A": "half full"})],
        sections=[margin_section(results(), {})],
    )  # fmt: skip
    text = render(page)
    for part in ('id="margin_ranges"', 'id="margin_shares"', "40 %", "a survey"):
        assert part in text, part
    assert "P95/50 and has no spread" not in text
    stated = Page(
        title="t", answer="a", facts=[], first=[margin_first(results("p95_50"), {})], sections=[]
    )
    assert "P95/50 and has no spread" in render(stated)


def test_bare_panels_at_several_levels_have_their_level():
    stated = results()
    louder = stated.ranges.assign(scenario="B", p50_g=30.0)
    names = {"A": "half full, acceptance (137 dB)", "B": "half full, qualification (143 dB)"}
    both = stated._replace(ranges=pd.concat([stated.ranges, louder]))
    page = Page(title="t", answer="a", facts=[], first=[margin_first(both, names)], sections=[])
    text = render(page)
    assert "bare, acceptance (137 dB)" in text and "bare, qualification (143 dB)" in text


@pytest.mark.parametrize(
    ("exceeding", "samples", "text"),
    [(0.0, 256, "below 1.2 %"), (0.004, 256, "below 1.2 %"), (0.02, 256, "2.0 %"),
     (0.0, 16384, "below 0.018 %")],
)  # fmt: skip
def test_few_samples_do_not_show_a_small_probability(exceeding, samples, text):
    """3/n is the upper end at 95 % of what n samples without an event show."""
    few = results()
    few.ranges["probability_exceeding"], few.ranges["samples"] = exceeding, samples
    assert f"P(exceeded) {text}" in margin_headline(few, {})
