"""A deck of the user's own runs to its page, and the page says how to run it again."""

import html
import shlex
import shutil

import pandas as pd
import pytest

from tests.commands import pidpanel, said
from tests.workflow.test_workflow import ROOT

STUDY = """
title: "A deck of my own"
coupon:
  deck: mine.in.j2
  cell: {across_flats_mm: 6.35, depth_mm: 10, count: 1}
  particles: {diameter_mm: 2.5, youngs_modulus_mpa: 50}
  sweep: {fill_fraction: [0.6], frequency_hz: [200], acceleration_g: [10, 40]}
  accuracy: {relative_error: 0.5, seeds: 1, min_cycles: 10, max_cycles: 40, min_time_s: 0,
             coverage: 0.5}
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Folder in which a study with a copy of `shake_lab.in.j2` was run."""
    folder = tmp_path_factory.mktemp("own deck")
    (folder / "mine.yaml").write_text(STUDY)
    shutil.copy(ROOT / "templates" / "shake_lab.in.j2", folder / "mine.in.j2")
    refused = pidpanel(folder, "run", "mine.yaml")
    assert refused.returncode == 2 and "allow it with --trust-deck" in said(refused)
    assert not (folder / "results").exists()
    result = pidpanel(folder, "run", "mine.yaml", "--trust-deck")
    assert result.returncode == 0, said(result)
    return folder


@pytest.mark.liggghts
def test_a_deck_of_ones_own_runs_to_its_page(ran):
    cases = pd.read_csv(ran / "results" / "mine" / "coupon" / "cases.csv")
    assert len(cases) == 2 and (cases["equivalent_damping_n_s_m3"] > 0).all()
    page = (ran / "results" / "mine" / "report.html").read_text()
    assert "A deck of my own" in page and "largest loss factor" in page
    # no run of such a deck lists its contacts
    assert "No run listed its contacts" in page


@pytest.mark.liggghts
def test_the_page_says_how_its_deck_runs_again(ran):
    page = (ran / "results" / "mine" / "report.html").read_text()
    command = html.unescape(page.split("<pre>")[-1].split("</pre>")[0])
    assert shlex.split(command) == ["pidpanel", "run", str(ran / "mine.yaml"), "--trust-deck"]
    again = pidpanel(ran, *shlex.split(command)[1:])
    assert again.returncode == 0, said(again)


def test_the_deck_that_comes_with_pidpanel_needs_no_trust(tmp_path):
    (tmp_path / "lab.yaml").write_text(STUDY.replace("mine.in.j2", "shake_lab.in.j2"))
    result = pidpanel(tmp_path, "run", "-n", "lab.yaml")
    assert result.returncode == 0, said(result)
    (tmp_path / "own.yaml").write_text(STUDY)
    shutil.copy(ROOT / "templates" / "shake_lab.in.j2", tmp_path / "mine.in.j2")
    refused = pidpanel(tmp_path, "run", "-n", "own.yaml")
    assert refused.returncode == 2 and "--trust-deck" in said(refused)
