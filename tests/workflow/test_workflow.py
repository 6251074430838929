"""The workflow through Snakemake, as a user runs it; real LIGGGHTS."""

import html
import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
import yaml
from reference_pages import untold

from tests.commands import jobs, pidpanel, said, snakemake

ROOT = Path(__file__).parents[2]
STUDIES = ROOT / "workflow" / "studies"
SNAKEMAKE = Path(sys.executable).with_name("snakemake")


ODD = 'it\'s $(touch hacked) & größe; {0/90}s "q"'.replace("/", "-")
"""A name that is none of a shell's, Snakemake's or LIGGGHTS' business."""


TITLE = "Fill of a {0/90}s layup, <b>$C_e$ & $x_{2}$</b>"
"""Neither a format, nor HTML, nor TeX."""


@pytest.fixture(scope="module")
def smoke(tmp_path_factory):
    """Folder with an odd name, in which the smoke study was run from the command line."""
    folder = tmp_path_factory.mktemp("smoke") / ODD
    folder.mkdir()
    text = (STUDIES / "smoke.yaml").read_text()
    assert "fill: {patch" in text
    text = text.replace("fill: {patch", f"fill: {{title: '{TITLE}', patch")
    (folder / "smoke.yaml").write_text(text)
    result = pidpanel(folder, "run", "smoke.yaml")
    assert result.returncode == 0, said(result)
    assert result.stdout == f"{folder / 'results' / 'smoke' / 'report.html'}\n"
    return folder


@pytest.mark.liggghts
def test_paths_and_texts_of_a_study_are_data(smoke):
    assert not list(smoke.parent.rglob("hacked*"))
    page = (smoke / "results" / "smoke" / "report.html").read_text()
    assert html.escape(TITLE) in page
    command = html.unescape(page.split("<pre>")[-1].split("</pre>")[0])
    assert shlex.split(command) == ["pidpanel", "run", str(smoke / "smoke.yaml")]


@pytest.mark.liggghts
def test_the_commands_after_a_run_know_its_results(smoke, tmp_path):
    result = pidpanel(smoke, "status", "smoke.yaml")
    assert result.returncode == 0, said(result)
    lines = result.stdout.splitlines()
    assert lines[0].startswith("smoke: complete") and lines[1] == "cases: 8 of 8 done, 0 left"
    assert all(line.endswith(" done") for line in lines[2:])
    result = pidpanel(smoke, "report", "smoke.yaml")
    assert result.stdout == f"{smoke / 'results' / 'smoke' / 'report.html'}\n"
    result = pidpanel(smoke, "export", "smoke.yaml", "--to", tmp_path / "out")
    assert "tabrnd1.bdf" in result.stdout and (tmp_path / "out" / "psd.uff").is_file()
    result = pidpanel(
        smoke, "compare", "smoke.yaml", "results/smoke", "--page", tmp_path / "c.html"
    )
    assert result.returncode == 0, said(result)
    values = result.stdout.splitlines()[1:-2]
    assert values and all("  the same" in line for line in values)
    page = (tmp_path / "c.html").read_text()
    assert page.count("<figure") >= 3 and "http" not in page.split("<body>")[1].split("<script>")[0]


@pytest.mark.parametrize(
    "name",
    ["paper", "launch", "shaker", "design_launch", "coupon_friction"],
)
def test_a_dry_run_of_every_shipped_study_passes(tmp_path, name):
    result = snakemake(tmp_path, STUDIES / f"{name}.yaml", "-n", "--quiet", "all")
    assert result.returncode == 0, said(result)


@pytest.mark.liggghts
def test_the_smoke_study_goes_from_liggghts_to_the_report(smoke):
    results = smoke / "results" / "smoke"
    cases = pd.read_csv(results / "coupon" / "acrylic" / "cases.csv")
    assert len(cases) == 8
    assert (cases["status"] == "ok").mean() >= 0.8
    good = cases[cases["status"] == "ok"]
    assert (good["equivalent_damping_n_s_m3"] > 0).all()
    assert (good["equivalent_damping_error_n_s_m3"] > 0).all()
    with xr.open_dataset(results / "response" / "psd.nc", engine="scipy") as psd:
        assert psd["acceleration_psd"].attrs["units"] == "m2 s-4 Hz-1"
        assert psd.attrs["study"] == "smoke"
        assert psd.attrs["liggghts_version"] == "3.8.0"
    summary = pd.read_csv(results / "response" / "summary.csv")
    # a damper of two cells' worth of data still damps; the balance of power closes to the
    # eigenvalues of D that were dropped
    assert (summary["power_balance_error"] < 1e-6).all()
    assert (results / "report.html").stat().st_size > 50_000


@pytest.mark.liggghts
def test_a_second_run_has_nothing_to_do(smoke):
    result = snakemake(smoke, smoke / "smoke.yaml")
    assert "Nothing to be done" in said(result)


@pytest.mark.liggghts
def test_another_study_with_the_same_coupon_shares_its_runs(smoke, tmp_path):
    values = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
    values["sound"]["oaspl_db"] = 140
    path = tmp_path / "quieter.yaml"
    path.write_text(yaml.safe_dump(values))
    result = snakemake(smoke, path, "-n")
    assert "cases" in said(result)
    assert "shake" not in said(result).split("Job stats")[-1]


@pytest.mark.liggghts
def test_a_run_that_was_stopped_goes_on_with_what_is_missing(smoke, tmp_path):
    folder = tmp_path / "stopped"
    shutil.copytree(smoke, folder)
    coupon = folder / "results" / "coupon"
    (outcome, *_) = sorted(coupon.glob("r*/*pc_*.json"))
    outcome.unlink()  # cycles and logs are there, but the case did not come to its end
    rows = outcome.parent / "s1" / "cycles_1.txt"
    kept = rows.stat().st_mtime_ns
    shutil.rmtree(folder / "results" / "smoke")  # nothing had been made of the runs yet
    result = snakemake(folder, STUDIES / "smoke.yaml", "-n")
    assert jobs(result)["shake"] == 1
    assert "pour" not in jobs(result)
    result = snakemake(folder, STUDIES / "smoke.yaml", "results/smoke/coupon/acrylic/cases.csv")
    assert result.returncode == 0, said(result)
    assert [run["status"] for run in json.loads(outcome.read_text())["runs"]] == ["ok", "ok"]
    # what it had run already was not run again
    assert rows.stat().st_mtime_ns == kept


@pytest.mark.liggghts
def test_a_file_that_cannot_be_read_is_named_and_comes_back_once_it_is_deleted(smoke, tmp_path):
    folder = tmp_path / "cut"
    shutil.copytree(smoke, folder)
    outcome = next((folder / "results" / "coupon").glob("r*/*pc_*.json"))
    cases = folder / "results" / "smoke" / "coupon" / "acrylic" / "cases.csv"
    before, target = cases.read_bytes(), "results/smoke/coupon/acrylic/cases.csv"
    outcome.write_text(outcome.read_text()[:-40])
    result = snakemake(folder, smoke / "smoke.yaml", target)
    assert result.returncode != 0
    line = f"{outcome.relative_to(folder)}: "
    assert line in said(result) and "delete it and run again" in said(result)
    outcome.unlink()
    result = snakemake(folder, smoke / "smoke.yaml", target)
    assert result.returncode == 0, said(result)
    assert cases.read_bytes() == before


def only_line(result):
    """The one line in which a mistake is told."""
    assert result.returncode != 0
    return [line for line in said(result).splitlines() if ".yaml" in line and ": " in line]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (("fill_fraction: [0.4, 0.8]\n      frequency", "fill_fraction: [0.4, 1.4]\n      frequency"),
         "dampers.acrylic.sweep.fill_fraction[1] = 1.4: must be from 0.02 to 1"),
        (("speed_m_s: 343", "sped_m_s: 343"), "sound.sped_m_s = 343: unknown key; did you mean speed_m_s?"),
        (("[100, 400], damper_mass", "[10, 400], damper_mass"),
         "response.frequency_hz = [10, 400]: must be in the bands of smc_s_016_2014_min_third.csv, 28.184 to 11220 Hz"),
    ],
)  # fmt: skip
def test_a_mistake_in_the_study_stops_before_anything_runs(tmp_path, change, line):
    study = tmp_path / "mine.yaml"
    text = (STUDIES / "smoke.yaml").read_text()
    assert change[0] in text
    study.write_text(text.replace(*change))
    result = snakemake(tmp_path, study)
    assert any(line in one for one in only_line(result)), said(result)
    assert "Traceback" not in said(result)
    assert not list(tmp_path.glob("results/*"))


def spectrum_study(tmp_path, content):
    (tmp_path / "mine.csv").write_text(content)
    study = tmp_path / "mine.yaml"
    text = (STUDIES / "smoke.yaml").read_text()
    study.write_text(text.replace("smc_s_016_2014_min_third.csv", "mine.csv"))
    return study


def test_an_unsorted_spectrum_is_refused_with_its_line(tmp_path):
    content = "center_hz,spl_db\n100,120\n160,121\n125,122\n200,120\n"
    result = snakemake(tmp_path, spectrum_study(tmp_path, content))
    assert any("mine.csv" in line for line in only_line(result)), said(result)
    assert "Traceback" not in said(result)


def test_without_liggghts_the_run_stops_with_what_to_install(tmp_path):
    study = STUDIES / "smoke.yaml"
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in ("bash", "sh", "env", "uname", "which"):
        (tools / name).symlink_to(shutil.which(name))
    command = [SNAKEMAKE, "-s", ROOT / "Snakefile", "-d", tmp_path, "--configfile", study, "-j1"]
    result = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, "PATH": str(tools)}
    )
    assert result.returncode != 0
    assert "apt-get install liggghts" in said(result)


def test_a_results_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "results").write_text("a file where the folder should be")
    result = snakemake(tmp_path, STUDIES / "smoke.yaml")
    assert result.returncode != 0
    assert "results: must be a writable folder" in said(result)
    assert (tmp_path / "results").read_text() == "a file where the folder should be"


MEASURED = (
    "microphone_coupling", "microphone_coupling_odd", "microphone_coupling_wavenumber",
    "microphone_position", "microphone_wavenumber", "microphone_real", "microphone_imaginary",
)  # fmt: skip


@pytest.mark.liggghts
def test_every_column_and_variable_is_described_and_nothing_else(smoke):
    missing, stale = untold(smoke / "results" / "smoke")
    assert missing == []
    # of studies that vary a key, with a core, of waves with a direction, with free edges, and of
    # fields that microphones measured
    assert stale == [
        "coupon/acrylic/cases.csv: <key of vary>",
        "response/maps.nc: core_shear_xz_rms",
        "response/maps.nc: core_shear_yz_rms",
        "sound/modal_force.nc: modal_force_odd",
        "sound/modal_force.nc: modal_force_above",
        "sound/modal_force.nc: modal_force_above_wavenumber",
        *(f"sound/modal_force.nc: {name}" for name in MEASURED),
        "sound/modal_force.nc: load_error",
        "sound/modal_force.nc: load_error_wavenumber",
    ]
    assert untold(smoke / "results" / "coupon", "../coupon/")[0] == []
