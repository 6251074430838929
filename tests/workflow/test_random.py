"""Coupons driven at random with the motions of their patches, as jobs and with real LIGGGHTS."""

import copy

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from reference_pages import untold

from pidpanel.random_round import RandomRound
from tests.workflow.test_dampers import values as of_two
from tests.workflow.test_dampers import written
from tests.workflow.test_workflow import jobs, said, snakemake

READINGS = ["random", "random_with_source"]


def values(**changes):
    """Two beads on two patches together; short records, and no sweep."""
    found = of_two()
    found["scenarios"].pop("pots")
    found["damping"] = {
        "readings": READINGS,
        "random": {"relative_error": 0.3, "time_s": 0.3, "max_time_s": 1.5, "max_rounds": 4}
        | changes,
    }
    return found


def psd_file(study):
    return f"results/{study}/response/psd.nc"


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Folder in which the study was run to its PSDs."""
    folder = tmp_path_factory.mktemp("random")
    result = snakemake(folder, written(folder, values()), psd_file("two"))
    assert result.returncode == 0, said(result)
    return folder


def rounds_of(folder):
    found = sorted((folder / "results/two/random").glob("round*.json"))
    return [RandomRound.read(path) for path in found]


@pytest.mark.liggghts
def test_panel_and_coupons_agree_in_bounded_rounds(ran):
    # red: `self.psd(frequency)` → `2 * …` in the patch motions; MOVED = 0
    rounds = rounds_of(ran)
    assert rounds[-1].is_last and not rounds[-2].is_last
    assert len(rounds) <= 5
    for drive in rounds[-1].drives:
        spent = sum(one.drive(drive.label).period for one in rounds)
        assert drive.reached or spent > 1.5 - 0.3 or len(rounds) == 5
        # the motion that was driven last is near the one that comes out
        driven = [one.drive(drive.label) for one in rounds if one.drive(drive.label).period][-1]
        assert driven.acceleration_rms == pytest.approx(drive.acceleration_rms, rel=0.25)
    # a patch with heavy beads has another motion and other damping than one with light ones
    (light, heavy) = rounds[-1].drives
    assert (light.damper, heavy.damper) == ("light", "heavy")
    assert light.acceleration_rms != pytest.approx(heavy.acceleration_rms, rel=0.01)


@pytest.mark.liggghts
def test_the_response_reads_the_impedance_of_the_last_round(ran):
    # red: `impedance{number}` → `impedance1` in last_impedance
    table = pd.read_csv(ran / f"results/two/random/impedance{len(rounds_of(ran)) - 1}.csv")
    with xr.open_dataset(ran / psd_file("two"), engine="scipy") as psd:
        assert psd["reading"].values.tolist() == READINGS
        for patch, rows in table.groupby("patch"):
            read = psd["equivalent_damping"].sel(reading="random", scenario="both", patch=patch)
            at = np.interp(np.log(rows["frequency_hz"]), np.log(psd["frequency"]), np.log(read))
            expected = np.maximum(
                rows["equivalent_damping_n_s_m3"], rows["equivalent_damping_error_n_s_m3"] / 2
            )
            # lines of the result lie beside the frequencies of the bands
            assert np.exp(at) == pytest.approx(expected.to_numpy(), rel=0.05)
        summary = pd.read_csv(ran / "results/two/response/summary.csv")
        reached = all(drive.reached for drive in rounds_of(ran)[-1].drives)
        assert set(summary.loc[summary["scenario"] == "both", "agreed"]) == {reached}
        assert summary.loc[summary["scenario"] == "bare", "agreed"].all()
        power = psd["acceleration_psd"].sel(scenario="both").integrate("frequency")
        plain, source = (power.sel(reading=name).to_numpy() for name in READINGS)
        assert (source > plain).all()


@pytest.mark.liggghts
def test_nothing_runs_again_and_a_tighter_accuracy_continues(ran):
    # red: `number` → the relative error in next_period
    assert jobs(snakemake(ran, written(ran, values()), psd_file("two"), "-n")) == {}
    tighter = written(ran, values(relative_error=0.001, max_time_s=2.7, max_rounds=5))
    before = len(rounds_of(ran))
    legs = sorted((ran / "results/two/random").glob("leg*/*.npz"))
    times = {path: path.stat().st_mtime_ns for path in legs}
    result = snakemake(ran, tighter, psd_file("two"))
    assert result.returncode == 0, said(result)
    assert len(rounds_of(ran)) > before
    assert times == {path: path.stat().st_mtime_ns for path in legs}


def test_a_study_at_random_needs_no_sweep_and_pours_its_own_beds(tmp_path):
    # red: without `BEDS |= …` in coupon.smk
    found = jobs(snakemake(tmp_path, written(tmp_path, values()), psd_file("two"), "-n"))
    assert "shake" not in found and "damper_cases" not in found
    assert found["random_round"] == 1


def test_a_mixed_layout_drives_its_coupons_alone(tmp_path):
    # red: `if coupon is not None` in Study.random_coupons
    study = values()
    study["scenarios"]["both"]["layout"]["PID-2"] = {"damper": "pot"}
    beside = copy.deepcopy(study)
    beside["damping"]["readings"] = ["stated", "random"]
    from pidpanel.study import load_study

    for one, sweeps in ((study, ()), (beside, ("light",))):
        found = load_study(written(tmp_path, one))
        assert [(f.patch, f.damper) for _, f, _ in found.random_coupons()] == [("PID-1", "light")]
        assert tuple(found.coupons) == found.surfaces == sweeps
        assert found.stated_dampers == (("light", "pot") if sweeps else ("pot",))


@pytest.mark.liggghts
def test_every_column_of_a_random_drive_is_described(ran):
    # red: low_hz renamed in random_reading.UNITS
    assert untold(ran / "results" / "two")[0] == []
