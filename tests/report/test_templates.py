"""Templates of the page: what they are filled with is shown as typed, and none of them is idle."""

from pathlib import Path

import jinja2
import pytest

from pidpanel.report import templates
from pidpanel.report.html import Fragment, Page, PageSection, Picture, render
from tests.page_reader import blocks_of

NAME = """<b>box</b> "7" & 'co'"""


def test_names_in_templates_are_shown_as_typed():
    # red: autoescape off; alt="{{ caption }}"
    values = {"maps": Picture("maps", b""), "layers": [NAME], "exceeded_share": 0.01}
    section = PageSection("maps", "Maps", [Fragment("maps.html", values)])
    text = render(Page("Panel", [], [section]))
    assert "<b>box" not in text
    assert "&lt;b&gt;box&lt;/b&gt; &#34;7&#34; &amp; &#39;co&#39;" in text
    assert text.count('alt="') == 1 and 'box</b> "7"' not in text
    (picture,) = blocks_of(section)
    assert f"layers ({NAME})" in picture.caption


def test_sentences_are_plain_text_for_a_page_that_escapes_them():
    # red: fill in place of striptags: escaped twice, or not at all
    values = {"name": NAME, "key": "dampers.x"}
    study = {"massless_dampers": {NAME: "dampers.x"}, "panel": {"single_points": ()},
             "differing_cells": ()}  # fmt: skip
    (massless, vacuum) = templates.lines(
        "shaker_warnings.html",
        {"study": study, "remarks": (), "outside": 0, "unstable": [], "panel_mesh": None,
         "has_tones": False, "coupons": [], "at_points": {"names": ()}},
    )  # fmt: skip
    assert massless.startswith(f"The particles of {values['name']} have no mass")
    assert vacuum == "The panel is in vacuum: radiation into the air is not included."


def test_columns_of_words_are_on_the_left_and_those_of_numbers_on_the_right():
    # red: a damping model on the right, of two lines in every row; `head` without a class
    row = {"measurement": "a", "reading": "dem", "center_hz": 158.489, "measured": 1.0,
           "computed": 1.0, "difference": "0"}  # fmt: skip
    text = templates.fill("measurement.html", {"measurements": [], "differences": [row]})
    assert '<th scope="col" class="words">damping model</th>' in text
    assert '<td class="words short">DEM</td>' in text
    assert '<th scope="col">measured</th>' in text and '<td class="short">1.00</td>' in text
    assert '<td class="short">160</td>' in text  # red: the exact centre, 158


def test_a_missing_value_is_refused():
    # red: jinja2's default undefined
    with pytest.raises(jinja2.UndefinedError, match="exceeded_share"):
        templates.fill("maps.html", {"maps": Picture("maps", b""), "layers": []})


def test_every_template_is_used():
    # red: a template that nothing names any more
    package = templates.PAGES.parents[1]
    sources = [*package.glob("report/*.py"), *package.glob("verification/*.py")]
    sources += templates.PAGES.glob("*.html")
    text = "".join(path.read_text("utf-8") for path in map(Path, sources))
    assert [p.name for p in templates.PAGES.glob("*.html") if f'"{p.name}"' not in text] == []


@pytest.mark.parametrize(("quantity", "tables"), [("at 2°", 3), ("restitution at 2.03°, " * 3, 1)])
def test_only_short_rows_stand_in_three_columns(quantity, tables):
    # red: any rows of five columns, the last of which left the page
    row = {
        "quantity": quantity, "reference": 0.79, "computed": 0.98, "unit": "1", "error": 0.24,
        "source": "a paper", "method": "a run",
    }  # fmt: skip
    values = {"rows": [row] * 31, "unknown": "", "percent": lambda *_: "+24 %"}
    assert templates.fill("validation.html", values).count("<table") == tables
