"""The whole page of a small study: what is on it, and what its captions say."""

import dataclasses
import re

import numpy as np
import pytest

from pidpanel.report import html, response_section, style
from pidpanel.report.names import family_of
from pidpanel.report.study_page import study_page
from tests.page_reader import blocks_of


@pytest.fixture(scope="module")
def whole(inputs):
    with style.context():
        return study_page(inputs, [("Run", "make run")])


def test_every_family_and_point_has_its_figure(whole):
    names = {picture.name for picture in whole.pictures}
    for family in ("fill", "place", "level"):
        assert {f"psd_{family}_middle", f"psd_{family}_corner"} <= names
        assert f'<figure id="reduction_{family}"' in html.render(whole)
    assert {"mode_shapes", "spectrum"} <= names
    assert all(p.image.startswith(b"\x89PNG") for p in whole.pictures if p.is_image)
    assert all(p.is_image or p.charts for p in whole.pictures)


def test_the_page_holds_all_pictures_and_the_words_of_the_study(whole):
    text = html.render(whole)
    images = sum(picture.is_image for picture in whole.pictures)
    assert text.count("data:image/png;base64,") == images
    assert text.count('<script type="application/json">') == sum(
        len(picture.charts) for picture in whole.pictures
    )
    for words in ("A panel under test", "The spectrum is assumed.", "Place of the damper (Figure 6)",
                  "Table 1 of the paper", "σ_v, MPa", "make run"):  # fmt: skip
        assert words in text, words
    assert re.search(r"study trial, hash [0-9a-f]{16}", text)


def test_the_bare_panel_comes_first_and_the_scenarios_in_their_order(inputs):
    fill, level = (family_of(inputs.study, key) for key in ("fill", "level"))
    curves = response_section.psd_curves(inputs, fill, fill.scenarios, "middle")
    psd = inputs.psd["acceleration_psd"].sel(
        scenario=inputs.study.all_scenarios()[0].label, point="middle"
    )
    assert curves[0].values * 9.80665**2 == pytest.approx(psd.to_numpy())
    assert [c.label for c in curves] == ["bare panel", "r = 0.1", "r = 0.7", "r = 0.9"]
    assert curves[1].values[0] == pytest.approx(curves[0].values[0] / 10**0.3)
    levels = response_section.psd_curves(inputs, level, level.scenarios, "middle")
    assert [c.label for c in levels] == [
        "bare panel, 140 dB",
        "bare panel, 150 dB",
        "140 dB",
        "150 dB",
    ]
    assert levels[1].values == pytest.approx(10 * levels[0].values)
    assert [(c.colour, c.line) for c in levels[:2]] == [(c.colour, "dotted") for c in levels[2:]]


def test_a_family_without_any_response_says_so_in_words(inputs):
    psd = inputs.psd.copy(deep=True)
    psd["acceleration_psd"][1:] = np.nan
    section = response_section.response_section(
        dataclasses.replace(inputs, psd=psd), family_of(inputs.study, "fill")
    )
    (block,) = blocks_of(section)
    assert "No damping model gives a steady response" in block.text
