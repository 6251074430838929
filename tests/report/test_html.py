"""The page needs no other file, and holds what it was given."""

import base64
import json
import re
from html.parser import HTMLParser

import jinja2
import numpy as np
import pytest

from pidpanel.report import html
from pidpanel.report.claims import verdict_table
from pidpanel.report.names import Claim
from pidpanel.report.response_figures import chart_picture

CLAIM = Claim(text="all is well", scenarios="fill", comparison="lowered")
PNG = b"\x89PNG\r\n\x1a\n made up"


def page(*blocks, **changes):
    values = {
        "title": "Panel <1>",
        "facts": [("Sound", "150 dB")],
        "assumptions": ["assumed"],
        "summary": ["r = 0.1 is best"],
        "warnings": ["beware"],
        "claims": verdict_table(
            [
                {
                    "claim": CLAIM,
                    "model": "single tones",
                    "verdict": "does not hold",
                    "evidence": "by 1 dB",
                }
            ]
        ),
        "sections": [html.PageSection("first", "First", blocks)],
        "steps": [("Run", "make run")],
    }
    return html.Page(**{**values, **changes})


class Addresses(HTMLParser):
    """Everything that a browser would go and fetch."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.images = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        if tag in ("link", "iframe", "object", "embed"):
            self.found.append(tag)
        for key in ("src", "href", "srcset", "data", "poster"):
            address = attributes.get(key)
            if address is None:
                continue
            if tag == "img":
                self.images.append(address)
            if not address.startswith(("data:", "#")):
                self.found.append(address)


def addresses(text):
    parser = Addresses(text)
    return parser.found + re.findall(r"url\([^)]*\)|@import[^;]*", text), parser.images


def test_the_page_fetches_nothing_and_holds_every_image():
    pictures = [html.Picture(name, PNG + name.encode(), f"About {name}") for name in ("one", "two")]
    fetched, images = addresses(html.render(page(*pictures)))
    assert fetched == []
    held = [base64.b64decode(image.removeprefix("data:image/png;base64,")) for image in images]
    assert held == [picture.image for picture in pictures]


def test_text_is_shown_as_it_is_written():
    text = html.render(page(html.Picture("one", PNG, "w < h/10 & <b>more</b>")))
    assert "Panel &lt;1&gt;" in text
    assert "w &lt; h/10 &amp; &lt;b&gt;more&lt;/b&gt;" in text


def test_all_that_the_page_is_given_is_on_it():
    text = html.render(page(html.Picture("one", PNG, "a picture")))
    for words in ("150 dB", "assumed", "r = 0.1 is best", "beware", "does not hold", "make run",
                  "all is well", "a picture"):  # fmt: skip
        assert words in text, words


def test_a_template_that_asks_for_what_is_not_there_is_refused(tmp_path):
    (tmp_path / "page.html").write_text("{{ page.nothing }}")
    with pytest.raises(jinja2.UndefinedError, match="nothing"):
        html.render(page(), tmp_path)


@pytest.mark.parametrize("name", ["<!--<script>", "</script><b>", "]]>", "a < b"])
def test_a_name_in_a_chart_cannot_end_or_keep_open_its_script(name):
    # a browser reads a script with `<!--<script` in it to the next `-->`: the rest of the page
    curve = html.PageCurve(name, np.ones(3), "#000000")
    chart = html.Chart("title", np.arange(1.0, 4.0), "unit", [curve])
    assert "<" not in chart.json
    assert json.loads(chart.json)["curves"][0]["label"] == name


def test_curves_in_the_page_are_those_of_all_lines_to_half_a_percent():
    frequency = np.geomspace(20, 2000, 3000)
    resonance = 1 / ((1 - (frequency / 300) ** 2) ** 2 + (0.02 * frequency / 300) ** 2)
    step = np.where(frequency < 700, 1.0, 4.0)
    gap = np.where((frequency > 100) & (frequency < 120), np.nan, frequency)
    curves = [html.PageCurve(name, v, "#000000") for name, v in
              (("resonance", resonance), ("step", step), ("gap", gap))]  # fmt: skip
    drawn = json.loads(html.Chart("", frequency, "unit", curves).json)
    assert len(drawn["x"]) < len(frequency) / 3
    for curve, values in zip(drawn["curves"], (resonance, step, gap), strict=True):
        kept = np.array([np.nan if v is None else v for v in curve["values"]])
        again = np.exp(np.interp(np.log(frequency), np.log(drawn["x"]), np.log(kept)))
        known = np.isfinite(values) & np.isfinite(again)
        # passes add up to at most four times the half percent of each
        np.testing.assert_allclose(again[known], values[known], rtol=0.02)
        assert known.sum() >= np.isfinite(values).sum() - 8
    assert min(drawn["x"]) == pytest.approx(20) and max(drawn["x"]) == pytest.approx(2000)


def test_the_range_of_the_data_has_the_same_ends_with_fewer_lines():
    frequency = np.geomspace(20, 2000, 1000)
    inside = (frequency > 90) & (frequency < 400)
    curve = html.PageCurve("one", np.ones(1000), "#000000", inside=inside)
    drawn = json.loads(html.Chart("", frequency, "unit", [curve]).json)
    first, *_ = drawn["curves"][0]["outside"]
    assert first == 0 and len(drawn["x"]) < 200
    ends = [drawn["x"][k] for k in drawn["curves"][0]["outside"][1:3]]
    assert ends == pytest.approx([frequency[inside][0], frequency[frequency >= 400][0]], rel=1e-5)


def test_readers_without_scripts_see_the_first_psd():
    chart = html.Chart(
        "", np.arange(1.0, 9.0), "unit", [html.PageCurve("a", np.ones(8), "#000000")]
    )
    pictures = [
        chart_picture(name, [chart], "PSD", has_svg=name == "one") for name in ("one", "two")
    ]
    text = html.render(page(*pictures))
    assert text.count("<svg") == 1
    inside = text[text.index("<noscript><div") : text.index("</svg>")]
    assert 'aria-label="PSD"' in inside and "frequency, Hz" in inside
