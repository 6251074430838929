"""A study of coupled runs beside a law, through Snakemake; real LIGGGHTS, about 25 CPU-seconds."""

import copy
import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from reference_pages import untold

from pidpanel.coupled.checkpoints import IDENTITY, read_record
from tests.commands import jobs, said, snakemake
from tests.workflow.test_workflow import STUDIES

SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
TABLES = "results/both/coupled"


def values(**keys):
    found = copy.deepcopy(SMOKE)
    del found["dampers"]["acrylic"]["sweep"]
    found["dampers"]["acrylic"]["model"] = "coupled"
    found["damping"] = {
        "coupled": {
            "duration_s": 0.3, "settle_s": 0.1, "runs": 2, "stations": 4, "cells": 8,
            "relative_error": 0.001, **keys,
        },
    }  # fmt: skip
    found["response"] = {"frequency_hz": [60, 400], "maps": ["one"]}
    found["panel"]["points"] = {"326": [0.7, 0.5]}
    found["scenarios"] = {
        name: {"layout": {"PID-1": {"damper": damper, "fill_fraction": 0.8}}}
        for name, damper in (("one", "acrylic"), ("law", "paper"))
    }
    return found


def identity_in(path):
    with xr.open_dataset(path, engine="scipy") as dataset:
        return dataset.attrs[IDENTITY]


def stored(path):
    return read_record(path, identity_in(path))


def written(folder, found):
    path = folder / "both.yaml"
    path.write_text(yaml.safe_dump(found, sort_keys=False))
    return path


@pytest.fixture(scope="module")
def coupled(tmp_path_factory):
    """Folder with the tables of a coupled study."""
    folder = tmp_path_factory.mktemp("coupled")
    wanted = f"{TABLES}/verdict.csv", "results/both/response/maps.nc"
    result = snakemake(folder, written(folder, values()), *wanted)
    assert result.returncode == 0, said(result)
    return folder


@pytest.mark.liggghts
def test_a_coupled_study_has_its_tables(coupled):
    (row,) = pd.read_csv(coupled / TABLES / "summary.csv").itertuples()
    assert (row.scenario, str(row.point), row.runs) == ("one", "326", 2)
    assert row.linear_g_rms < row.g_rms
    assert 0 < row.g_rms_error < 0.3 * row.g_rms
    bands = pd.read_csv(coupled / TABLES / "third_octaves.csv")
    assert np.hypot.reduce(bands.g_rms) == pytest.approx(row.g_rms, rel=2e-3)
    psd = pd.read_csv(coupled / TABLES / "psd.csv")
    square = np.trapezoid(psd.acceleration_psd_g2_hz, psd.frequency_hz)
    assert np.sqrt(square) == pytest.approx(row.g_rms, rel=1e-3)
    impedance = pd.read_csv(coupled / TABLES / "impedance.csv")
    # a bed takes energy where it is known, and has no more than it weighs: 2.1 kg/m² a layer
    assert np.median(impedance.equivalent_damping_n_s_m3) > 0
    assert (impedance.own_force_psd_pa2_hz > 0).all()
    assert impedance.own_force_coherence.between(0, 1).all()


@pytest.mark.liggghts
def test_every_model_is_set_beside_the_coupled_runs(coupled):
    (row,) = pd.read_csv(coupled / TABLES / "summary.csv").itertuples()
    verdict = pd.read_csv(coupled / TABLES / "verdict.csv").set_index("damper")
    bare = verdict.loc["bare panel"]
    assert (bare.scenario, str(bare.point)) == ("one", "326")
    assert 0.3 < row.g_rms / bare.g_rms < 1.0
    assert "paper" in verdict.index


@pytest.mark.liggghts
def test_what_is_found_reaches_points_stresses_and_maps(coupled):
    # force)
    (run,) = pd.read_csv(coupled / TABLES / "summary.csv").itertuples()
    response = coupled / "results/both/response"
    rows = pd.read_csv(response / "summary.csv").set_index("scenario")
    one = rows.loc["one"]
    # C_e joined in its ln, and no less than half its error: not quite the same numbers
    assert one.acceleration_rms_g == pytest.approx(run.g_rms, rel=0.05)
    assert one.acceleration_rms_error_g / one.acceleration_rms_g == pytest.approx(
        run.g_rms_error / run.g_rms, rel=1e-3
    )
    stress = pd.read_csv(response / "stress.csv").set_index("scenario")
    of_run = stress.loc[["one"]]
    assert (of_run.relative_error > 0).all()
    assert (of_run["rms"] > 0).all()
    with xr.open_dataset(response / "maps.nc", engine="scipy") as stored:
        maps = stored.load()
    case = list(maps["scenario"].to_numpy()).index("one")
    apart = np.abs(maps["vertex_position"].to_numpy() - [0.7, 0.5]).sum(axis=1)
    assert apart.min() < 1e-6
    there = float(maps["acceleration_rms"][case, int(apart.argmin())]) / 9.80665
    assert there == pytest.approx(one.acceleration_rms_g, rel=0.01)
    assert float(maps["relative_error"][case]) > 0


@pytest.mark.liggghts
def test_records_are_of_their_own_sounds_and_packings(coupled):
    one, other = (stored(coupled / TABLES / f"one/run{k}.nc") for k in (1, 2))
    coherence = np.vdot(one.amplitude, other.amplitude)
    assert abs(coherence) < 0.1 * np.linalg.norm(one.amplitude) * np.linalg.norm(other.amplitude)
    # the walls carry the bed on the whole: impulse over time is its weight per area, 5 kg/m², but
    # for what its momentum changes: 2 m/s of it in 0.3 s are 3.4 kg/m²
    for record in (one, other):
        time = record.interval * (record.rows - 1)
        mean = (record.impulse[-1] - record.impulse[0]) / time / 9.80665
        assert mean.mean() == pytest.approx(5.0, abs=3.4)


@pytest.mark.liggghts
def test_what_has_not_changed_is_not_run_again(coupled, tmp_path):
    shutil.copytree(coupled, tmp_path / "copy", symlinks=True)
    folder = tmp_path / "copy"
    target = f"{TABLES}/verdict.csv"
    assert jobs(snakemake(folder, written(folder, values()), "-n", target)) == {}
    longer = jobs(snakemake(folder, written(folder, values(duration_s=0.5)), "-n", target))
    assert longer == {"coupled_scenario": 1, "coupled": 1, "response": 1, "verdict": 1}
    # a third run beside the two that are there, from their records
    before = {path.name: path.stat().st_mtime_ns for path in (folder / TABLES / "one").iterdir()}
    result = snakemake(folder, written(folder, values(runs=3)), f"{TABLES}/summary.csv")
    assert result.returncode == 0, said(result)
    after = {path.name: path.stat().st_mtime_ns for path in (folder / TABLES / "one").iterdir()}
    assert set(after) - set(before) == {"run3.nc"}
    assert before.items() <= after.items()


@pytest.mark.liggghts
def test_every_column_of_coupled_runs_is_described(coupled):
    assert untold((coupled / TABLES).parent)[0] == []
