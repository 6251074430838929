"""Estimates and records come back from their files, and tables have their units."""

import numpy as np
import pytest
import xarray as xr

from pidpanel.coupled.checkpoints import IDENTITY, read_record, write_record
from pidpanel.coupled.estimate import PatchEstimate, ScenarioEstimate
from pidpanel.coupled.from_study import SimulatedBed, estimate_tables, write_estimate
from pidpanel.coupled.impedance import BandImpedance
from pidpanel.coupled.kurtosis import RecordedBursts
from pidpanel.coupled.own_force import OwnForce
from pidpanel.coupled.segments import SettledRecord
from pidpanel.provenance.results import ResultsDamaged
from pidpanel.solve.bands import whole_third_octaves

FREQUENCY = np.linspace(100.0, 400.0, 61)
CENTRE, EDGE = whole_third_octaves(100.0, 400.0)
BANDS = len(CENTRE)
G = 9.80665


def patch(scale):
    ones = scale * np.ones(BANDS)
    omega = 2 * np.pi * 1.01 * CENTRE
    return PatchEstimate(
        BandImpedance(
            1.01 * CENTRE, 400 * ones + 1j * omega * 2 * ones, np.zeros((len(CENTRE), 0))
        ),
        40 * ones,
        0.2 * ones,
        OwnForce(3 * ones, 0.1 * ones, 42.0 * scale),
        0.05 * ones,
        0.07 * scale,
    )


@pytest.fixture
def stored(tmp_path):
    """Accelerations of 4 and 1 g²/Hz at two points, a quarter of it by the own force."""
    psd = np.array([4.0, 1.0]) * G**2 / (2 * np.pi * FREQUENCY[:, None]) ** 4
    by_point = np.array([1.0, 2.0])
    found = ScenarioEstimate(
        centre=CENTRE,
        patches=[patch(1.0), patch(2.0)],
        frequency=FREQUENCY,
        psd=psd,
        linear_psd=0.75 * psd,
        log_psd_error=0.1 * by_point * np.ones((61, 1)),
        log_band_error=0.2 * by_point * np.ones((BANDS, 1)),
        band_residual=-0.3 * by_point * np.ones((BANDS, 1)),
        log_error=0.02 * by_point,
        residual=-0.03 * by_point,
        split_error=0.01 * by_point,
        contact_error=np.zeros(2),
        recorded=(by_point * G) ** 2 * 900,
        bursts=RecordedBursts(
            0.8 * by_point, 0.1 * by_point, np.outer([1, 2, 3], by_point), np.ones((3, 2))
        ),
    )
    beds = [SimulatedBed("P", 4e-5, 6.0, 5e7), SimulatedBed("Q", 5e-5, 7.0, 2e8)]
    path = tmp_path / "estimate.nc"
    write_estimate(path, found, beds, ["326", "7"], 3, {"study": "mine"})
    return xr.load_dataset(path, engine="scipy")


def test_the_table_of_points_has_rms_and_its_error(stored):
    table = estimate_tables("one", stored)["summary"]
    assert table["point"].tolist() == ["326", "7"]
    assert set(table["scenario"]) == {"one"}
    rms = np.sqrt(300 * np.array([4.0, 1.0]))
    assert table["g_rms"].to_numpy() == pytest.approx(rms)
    # of ln of the mean square 2 % and 4 %: half of it of the rms
    assert table["g_rms_error"].to_numpy() == pytest.approx([0.01, 0.02] * rms)
    assert table["linear_g_rms"].to_numpy() == pytest.approx(np.sqrt(0.75) * rms)
    assert table["recorded_g_rms"].to_numpy() == pytest.approx([30.0, 60.0])
    assert table["residual_db"].to_numpy() == pytest.approx(10 * np.log10(np.exp([-0.03, -0.06])))
    assert table["excess_kurtosis"].to_numpy() == pytest.approx([0.8, 1.6])
    assert table["excess_kurtosis_error"].to_numpy() == pytest.approx([0.1, 0.2])
    assert table["log_damage_8"].tolist() == [2, 4]
    assert table["log_damage_error_12"].tolist() == [1, 1]
    assert table["runs"].tolist() == [3, 3]


def test_the_tables_of_bands_and_lines_have_every_point(stored):
    bands = estimate_tables("one", stored)["third_octaves"].set_index("point")
    lines = estimate_tables("one", stored)["psd"].set_index("point")
    for name, psd, scale in (("326", 4.0, 1.0), ("7", 1.0, 2.0)):
        table = bands.loc[name]
        assert table["frequency_hz"].to_numpy() == pytest.approx(CENTRE)
        assert table["g_rms"].to_numpy() ** 2 == pytest.approx(psd * np.diff(EDGE)[:, 0])
        assert table["error_db"].to_numpy() == pytest.approx(10 * np.log10(np.exp(0.2 * scale)))
        assert table["residual_db"].to_numpy() == pytest.approx(-3 * scale / np.log(10))
        table = lines.loc[name]
        assert table["frequency_hz"].to_numpy() == pytest.approx(FREQUENCY)
        assert table["acceleration_psd_g2_hz"].to_numpy() == pytest.approx(psd)
        assert table["linear_acceleration_psd_g2_hz"].to_numpy() == pytest.approx(0.75 * psd)
        assert table["error_db"].to_numpy() == pytest.approx(scale / np.log(10))


def test_the_table_of_patches_has_what_the_response_reads(stored):
    table = estimate_tables("one", stored)["impedance"].set_index("patch")
    assert table.groupby(level=0).size().to_dict() == {"P": BANDS, "Q": BANDS}
    for name, scale, area, mass, modulus in (("P", 1, 4e-5, 6.0, 50), ("Q", 2, 5e-5, 7.0, 200)):
        wanted = {
            "band_hz": CENTRE,
            "frequency_hz": 1.01 * CENTRE,
            "equivalent_damping_n_s_m3": 400.0 * scale,
            "equivalent_damping_error_n_s_m3": 40.0 * scale,
            "apparent_mass_kg_m2": 2.0 * scale,
            "apparent_mass_error_kg_m2": 0.2 * scale,
            "own_force_psd_pa2_hz": 3.0 * scale,
            "own_force_coherence": 0.1 * scale,
            "own_force_error": 0.05 * scale,
            "own_force_length_m_hz": 42.0 * scale,
            "cell_area_m2": area,
            "particle_mass_per_area_kg_m2": mass,
            "youngs_modulus_mpa": modulus,
            "common_error": 0.07 * scale,
        }
        rows = table.loc[name]
        for column, values in wanted.items():
            assert rows[column].to_numpy() == pytest.approx(values), column
        assert set(rows["scenario"]) == {"one"}


def test_the_file_has_units_and_attributes(stored):
    assert all("units" in stored[name].attrs for name in stored.data_vars)
    assert stored.attrs["study"] == "mine"
    assert stored["equivalent_damping"].dims == ("patch", "band")
    assert stored["band_log_error"].dims == ("band", "point")


@pytest.fixture
def record():
    rng = np.random.default_rng(1)
    amplitude = rng.standard_normal((5, 3)) + 1j * rng.standard_normal((5, 3))
    rows = [rng.standard_normal((40, n)) for n in (4, 2, 4)]
    return SettledRecord(np.arange(3.0, 8.0), amplitude, 3, 40, 7, 0.025, *rows)


def test_a_record_comes_back_rounded_to_single_precision(tmp_path, record):
    path = tmp_path / "run1.nc"
    write_record(path, record, {IDENTITY: "abc", "moduli": [1.0, 2.0]})
    found = read_record(path, "abc")
    for name in ("first", "rows", "settled", "interval"):
        assert getattr(found, name) == getattr(record, name)
    for name in ("frequency", "amplitude", "at_cells", "at_points"):
        assert getattr(found, name) == pytest.approx(getattr(record, name), rel=1e-6)
    assert np.array_equal(found.impulse, record.impulse)
    assert found.at_cells.dtype == np.float64


def test_a_record_of_another_run_is_none_and_one_that_cannot_be_read_is_named(tmp_path, record):
    path = tmp_path / "run1.nc"
    assert read_record(path, "abc") is None
    write_record(path, record, {IDENTITY: "abc"})
    assert read_record(path, "abd") is None
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(ResultsDamaged, match=r"run1\.nc: .*delete it and run the study again"):
        read_record(path, "abc")
