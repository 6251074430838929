"""A script of the workflow takes paths, makes one call, and leaves files: nothing is decided in it."""

import ast
import importlib
import inspect
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.provenance.job import Job, arguments_of, run
from tests.jobs import PANEL, RESPONSE, SOUND, call, make_panel, make_sound, within

SCRIPTS = sorted((Path(__file__).parents[2] / "workflow" / "scripts").glob("[!_]*.py"))
MOST_LINES = 25


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_is_short_and_typed_and_decides_nothing(path):
    # red: an `if` in the main of any script
    text = path.read_text()
    assert len(text.splitlines()) <= MOST_LINES
    (main,) = (
        node
        for node in ast.parse(text).body
        if isinstance(node, ast.FunctionDef) and node.name == "main"
    )
    decisions = (ast.If, ast.IfExp, ast.While, ast.Try, ast.Compare)
    assert not [ast.unparse(node) for node in ast.walk(main) if isinstance(node, decisions)]
    signature = inspect.signature(importlib.import_module(f"scripts.{path.stem}").main)
    assert signature.return_annotation in (None, "None")
    assert all(p.annotation is not p.empty for p in signature.parameters.values())


class OfOurs(ValueError):
    pass


OfOurs.__module__ = "pidpanel.somewhere"


def test_a_failure_of_ours_is_one_line_and_any_other_keeps_its_traceback():
    # red: `except Exception as error: sys.exit(str(error))`
    def fails(error):
        def main(arguments):
            raise error

        return main

    with pytest.raises(SystemExit, match="what is allowed"):
        run(fails(OfOurs("what is allowed")))
    with pytest.raises(ValueError, match="ours neither"):
        run(fails(ValueError("ours neither")))


def test_files_and_texts_of_a_job_come_back_from_its_arguments(monkeypatch):
    # red: partition("=") → rpartition("="); the names of the inputs for the outputs
    monkeypatch.setenv("PIDPANEL_STUDY", "a b.yaml")
    read = {"modes": "a=b/m.nc", "surfaces": ["1.nc", "2.nc"], "air": []}
    job = Job.parse(arguments_of(input=read, output={"psd": "p.nc"}, params={"damper": "x=y"}))
    assert (job.study, job.params, job.seconds) == (Path("a b.yaml"), {"damper": "x=y"}, np.inf)
    assert (job.input.modes, job.input.get("air")) == (Path("a=b/m.nc"), None)
    assert job.input.several("surfaces") == [Path("1.nc"), Path("2.nc")]
    assert job.output.psd == Path("p.nc")
    with pytest.raises(AttributeError, match="no file of the name air"):
        _ = job.input.air
    with pytest.raises(ValueError, match="surfaces: 2 files"):
        _ = job.input.surfaces


def stages(folder, study):
    """Call the scripts from the mesh to the exports, as the rules do; the folder of each file."""
    make_panel(study, folder)
    make_sound(study, folder)
    files = within(folder, {**PANEL, **SOUND, **RESPONSE})
    response = within(folder, RESPONSE)
    call("response", study, files, response)
    call("maps", study, files, within(folder, {"maps": "maps.nc", "folder": "maps"}))
    call("export", study, files, {"folder": folder / "export"})
    return folder


@pytest.fixture(scope="module")
def law(tmp_path_factory, write_study, law_values):
    folder = tmp_path_factory.mktemp("law")
    return stages(folder, write_study(folder, "law", law_values()))


@pytest.fixture(scope="module")
def table(tmp_path_factory, write_study, table_values):
    folder = tmp_path_factory.mktemp("table")
    return stages(folder, write_study(folder, "table", table_values()))


def test_a_law_that_feeds_the_panel_has_rows_that_say_so_and_no_psd(law):
    # red: `found[key] = one` before the test for UnstableDamping
    summary = pd.read_csv(law / "summary.csv")
    printed = summary[(summary["reading"] == "paper_printed") & (summary["patch"] != "none")]
    assert (printed["status"] == "unstable").all() and printed["acceleration_rms_g"].isna().all()
    corrected = summary[summary["reading"] == "paper_corrected"]
    assert (corrected["status"] == "ok").all()
    with xr.open_dataset(law / "psd.nc", engine="scipy") as psd:
        values = psd["acceleration_psd"].sel(scenario="PID-1_r0.5_150dB")
        assert np.isnan(values.sel(reading="paper_printed")).all()
        assert np.isfinite(values.sel(reading="paper_corrected")).all()


def test_the_summary_is_the_integral_of_the_psds(law):
    summary = pd.read_csv(law / "summary.csv").set_index(["reading", "scenario", "point"])
    with xr.open_dataset(law / "psd.nc", engine="scipy") as psd:
        for (reading, scenario, point), row in summary[summary["status"] == "ok"].iterrows():
            one = psd["acceleration_psd"].sel(reading=reading, scenario=scenario, point=point)
            mean_square = np.trapezoid(one, psd["frequency"])
            # six digits in the table
            assert row["acceleration_rms_g"] * 9.80665 == pytest.approx(mean_square**0.5, rel=1e-5)


def test_ten_decibels_of_sound_are_ten_of_motion_where_damping_is_independent_of_it(law):
    # red: pressure_factor that returns 1 always
    summary = pd.read_csv(law / "summary.csv")
    of = summary[summary["reading"] == "paper_corrected"].set_index(["scenario", "point"])
    rms = of["acceleration_rms_g"]
    for point in ("centre", "Edge"):
        ratio = rms["PID-1_r0.5_150dB", point] / rms["PID-1_r0.5_140dB", point]
        assert 20 * np.log10(ratio) == pytest.approx(10, abs=1e-4)
        assert of["reduction_db"]["bare_140dB", point] == 0


def test_a_damper_lowers_the_motion_and_a_table_brings_its_errors(table):
    # red: standard_errors that returns None
    summary = pd.read_csv(table / "summary.csv")
    damped = summary[summary["patch"] != "none"]
    assert (damped["reduction_db"] > 0).all()
    assert (damped["acceleration_rms_error_g"] > 0).all()
    assert (summary["power_balance_error"] < 1e-6).all()
    bare = summary[summary["patch"] == "none"]
    assert bare["acceleration_rms_error_g"].isna().all()


def test_maps_and_psds_agree_at_the_points(table):
    summary = pd.read_csv(table / "summary.csv").set_index(["scenario", "point"])
    with xr.open_dataset(table / "maps.nc", engine="scipy") as maps:
        away = np.abs(maps["vertex_position"] - [0.75, 0.5]).sum("axis")
        rms = maps["acceleration_rms"].isel(case=0, vertex=int(np.argmin(away.to_numpy())))
        label = str(maps["scenario"].to_numpy()[0])
    # maps are computed on fewer lines, within 1e-3
    expected = summary["acceleration_rms_g"][label, "centre"] * 9.80665
    assert float(rms) == pytest.approx(expected, rel=2e-3)


def test_exports_hold_every_steady_scenario(law):
    # red: is_steady that returns True
    names = {path.name for path in (law / "export").iterdir()}
    assert "psd_paper_corrected_Left wing_r0.5_150dB.csv" in names
    assert "psd_paper_printed_bare_150dB.csv" in names
    assert not any("paper_printed_PID" in name for name in names)
    assert {"tabrnd1.bdf", "tabdmp1.bdf", "psd.uff", "third_octaves.csv"} <= names
    text = (law / "export" / "tabdmp1.bdf").read_text()
    bare = text.split("$ paper_corrected, bare_150dB\n")[1].split("ENDT")[0]
    cells = bare.replace("*", " ").split()[3:]  # after the card, its number and kind
    frequency, ratio = np.array(cells, float).reshape(-1, 2).T
    modes = pd.read_csv(law / "modes.csv")["frequency_hz"]
    np.testing.assert_allclose(frequency, np.unique(modes[(modes > 40) & (modes < 150)]), rtol=1e-6)
    np.testing.assert_allclose(ratio, 0.02, rtol=1e-9)
