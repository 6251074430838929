"""Coupled runs as a reading: C_e, m_a and own force from their table, errors from the others."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.response.as_coupled import read_coupled, read_errors


@pytest.fixture
def impedance(tmp_path):
    frequency = 10 ** (np.arange(16, 30) / 10)
    table = pd.DataFrame(
        {
            "scenario": "one", "patch": "P", "frequency_hz": frequency,
            "equivalent_damping_n_s_m3": 500.0, "equivalent_damping_error_n_s_m3": 50.0,
            "apparent_mass_kg_m2": 2.0, "apparent_mass_error_kg_m2": 0.2,
            "own_psd_of_a_cell_pa2_hz": np.where(frequency < 60, 60.0, 30.0), "own_psd_in_common_pa2_hz": -1.0,
            "cell_area_m2": 4e-5, "particle_mass_per_area_kg_m2": 6.0,
            "common_error": 0.3, "carried_from": "two",
        }
    )  # fmt: skip
    path = tmp_path / "impedance.csv"
    table.to_csv(path, index=False)
    return path


def test_a_table_of_coupled_runs_is_a_reading(impedance):
    # red: own_psd not times the area; common_psd without its bound; packing_error 0
    reading = read_coupled(impedance)["one", "P"]
    f = np.array([50.0, 100.0, 700.0])
    found = reading(f, 0.5, 10.0)
    assert found.equivalent_damping == pytest.approx([500.0] * 3)
    assert found.apparent_mass == pytest.approx([2.0] * 3)
    assert reading.own_force_psd(f[1:]) == pytest.approx([30.0 * 4e-5] * 2)
    # half way in ln f it is the mean of both, not of their ln; red: `_psd` left out
    between = 10 ** np.array([1.75])
    assert reading.own_force_psd(between) == pytest.approx([45.0 * 4e-5])
    assert reading.common_force_psd(f).max() < 1e-200
    assert reading.mass_per_area(0.5) == 6.0
    # the error of the level is one of all lines together
    covariance = reading.covariance(f, 0.5, 10.0)
    assert covariance[0, 2] == pytest.approx(0.09)
    assert covariance[0, 0] > 0.09


def test_errors_are_those_of_the_runs(tmp_path):
    # red: np.log(10) / 10 → / 20; points in the order of the file
    frequency = np.array([30.0, 100.0, 1000.0])
    pd.DataFrame(
        {"scenario": "one", "point": ["326", "7"], "g_rms": [10.0, 4.0], "g_rms_error": [0.2, 0.2]}
    ).to_csv(tmp_path / "summary.csv", index=False)
    pd.concat(
        pd.DataFrame(
            {"scenario": "one", "point": point, "frequency_hz": frequency, "error_db": error}
        )
        for point, error in (("326", 0.5), ("7", 1.0))
    ).to_csv(tmp_path / "psd.csv", index=False)
    found = read_errors(
        tmp_path / "summary.csv", tmp_path / "psd.csv", np.array([50.0, 500.0]), ["7", "326"]
    )["one"]
    assert found.log_rms == pytest.approx([0.05, 0.02])
    assert found.log_psd == pytest.approx(np.log(10) / 10 * np.array([[1.0, 0.5]] * 2))
