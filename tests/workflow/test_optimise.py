"""Layouts proposed through Snakemake, and their page in a browser."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from browser import CHROMIUM, Browser

from tests.commands import snakemake
from tests.jobs import call, within

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "workflow" / "studies" / "design_launch.yaml"


@pytest.fixture(scope="module")
def designed(tmp_path_factory):
    """Results of a smaller form of a study that comes with pidpanel."""
    folder = tmp_path_factory.mktemp("designed")
    values = yaml.safe_load(STUDY.read_text())
    values["response"]["frequency_hz"] = [30, 250]
    values["panel"]["mesh"]["elements"] = [15, 10]
    values["panel"]["points"] = {"326": [0.7, 0.5], "189": [0.1, 0.3]}
    values["optimise"] |= {"spacing_m": [0.4, 0.3], "patches_at_most": 2, "fill_fraction": [0.45]}
    study = folder / "design.yaml"
    study.write_text(yaml.safe_dump(values, sort_keys=False))
    done = snakemake(folder, study)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "results" / "design"


def test_snakemake_runs_the_search_before_the_page(designed):
    tables = {path.stem for path in (designed / "optimise").glob("*.csv")}
    assert tables == {"layouts", "front", "summary", "search", "psd"}
    front = pd.read_csv(designed / "optimise" / "front.csv")
    assert front["reduction_db"].iloc[0] > 1
    assert (front["search_reduction_db"] - front["reduction_db"]).abs().max() < 0.2
    layouts = pd.read_csv(designed / "optimise" / "layouts.csv")
    assert layouts.groupby("layout")["mass_kg"].sum().max() <= 0.5
    assert (designed / "benchmark" / "optimise.tsv").is_file()


@pytest.mark.parametrize("objective", ["panel", "stress", "oscillators"])
def test_other_objectives_are_made_small(designed, tmp_path, objective):
    values = yaml.safe_load((designed.parent.parent / "design.yaml").read_text())
    values["optimise"] |= {"objective": objective, "patches_at_most": 1}
    if objective == "oscillators":
        values["optimise"]["band_hz"] = [60, 200]
    study = tmp_path / "other.yaml"
    study.write_text(yaml.safe_dump(values))
    names = ("layouts", "front", "summary", "search", "psd")
    of_panel = {"modes": "modes.nc", "plate": "plate.nc", "section": "section.csv"}
    files = within(designed / "panel", of_panel)
    files |= within(designed / "sound", {"modal_force": "modal_force.nc", "air": "air.nc"})
    call("optimise", study, files, within(tmp_path, {name: f"{name}.csv" for name in names}))
    best = pd.read_csv(tmp_path / "front.csv").iloc[0]
    decibels = 20 * np.log10(best["bare_objective"] / best["objective"])
    assert best["reduction_db"] == pytest.approx(decibels, abs=1e-4) and decibels > 1
    assert best["search_reduction_db"] == pytest.approx(decibels, abs=0.2)
    response = designed / "response"
    rms = pd.read_csv(response / "summary.csv")["acceleration_rms_g"].max()
    if objective == "stress":
        stress = pd.read_csv(response / "stress.csv").query("quantity == 'von_mises'")
        # lines within 1e-3
        expected = stress["three_sigma"].max()
        assert best["bare_objective"] == pytest.approx(expected, rel=3e-3)
    elif objective == "panel":
        assert best["bare_objective"] >= 0.997 * rms
    else:
        assert rms < best["bare_objective"] < 10 * rms  # Q = 10
    assert best["objective_unit"] == ("MPa" if objective == "stress" else "g rms")


def test_no_number_of_the_page_is_missing(designed):
    page = (designed / "report.html").read_text()
    text = re.sub(r"<(style|script)[^>]*>.*?</\1>|data:[^\"]*|<[^>]+>", " ", page, flags=re.DOTALL)
    assert "Proposed layouts" in text
    assert not re.search(r"\b(nan|inf|None)\b", text)


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_click_on_the_front_shows_the_layout(designed):
    with Browser(1200) as browser:
        browser.open(designed / "report.html")
        shown = "[...document.querySelectorAll('.option')].filter(e => getComputedStyle(e).display != 'none').map(e => e.id)"
        assert browser.run(shown) == ["layout_1"]
        links = browser.run(
            "[...document.querySelectorAll('.choice svg a')].map(e => e.getAttribute('href'))"
        )
        assert links
        for href in links:
            place = browser.run(
                f"(() => {{ const c = document.querySelector('.choice svg a[href=\"{href}\"] circle');"
                "c.scrollIntoView({block: 'center'}); const b = c.getBoundingClientRect();"
                "return [b.left + b.width / 2, b.top + b.height / 2]; })()"
            )
            for kind in ("mousePressed", "mouseReleased"):
                browser.say(
                    "Input.dispatchMouseEvent", type=kind, x=place[0], y=place[1], button="left",
                    buttons=1, clickCount=1,
                )  # fmt: skip
            assert browser.run(shown) == [href[1:]]
            visible = "e => e.checkVisibility() && e.getBoundingClientRect().width > 100"
            count = f"[...document.querySelectorAll('{href} figure')].filter({visible}).length"
            assert browser.run(count) == 2
        assert browser.complaints() == [] and browser.requests() == []
        browser.screenshot(designed / "page.png")
