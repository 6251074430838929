"""Templates of the page: what they are filled with is shown as typed, and none of them is idle."""

import jinja2
import pytest

from pidpanel.report import templates
from pidpanel.report.html import Fragment, Page, PageSection, Picture, render
from tests.page_reader import blocks_of

NAME = """<b>box</b> "7" & 'co'"""


def test_names_in_templates_are_shown_as_typed():
    values = {"maps": Picture("maps", b""), "layers": [NAME], "exceeded_share": 0.01}
    section = PageSection("maps", "Maps", [Fragment("maps.html", values)])
    text = render(Page("Panel", [], [section]))
    assert "<b>box" not in text
    assert "&lt;b&gt;box&lt;/b&gt; &#34;7&#34; &amp; &#39;co&#39;" in text
    assert text.count('alt="') == 1 and 'box</b> "7"' not in text
    (picture,) = blocks_of(section)
    assert f"layers ({NAME})" in picture.caption


def test_a_missing_value_is_refused():
    with pytest.raises(jinja2.UndefinedError, match="exceeded_share"):
        templates.fill("maps.html", {"maps": Picture("maps", b""), "layers": []})
