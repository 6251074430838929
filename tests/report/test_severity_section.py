"""Severity of a study on its page and in its tables."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.report.severity_section import drawn_scenarios

KEYS = {"scenario": str, "point": str}


@pytest.fixture
def tables(table):
    """(severity, response) → tables by name."""
    folder = table[1]
    return {
        name: pd.read_csv(folder / name, dtype=KEYS)
        for name in (
            "severity/oscillators.csv",
            "severity/peaks.csv",
            "severity/fatigue.csv",
            "severity/strength.csv",
            "severity/margins.csv",
            "response/summary.csv",
            "response/stress.csv",
        )
    }


def test_peaks_have_the_rms_values_and_errors_of_the_response(tables):
    where = ["scenario", "point"]
    both = tables["severity/peaks.csv"].merge(
        tables["response/summary.csv"], on=where, suffixes=("", "_response")
    )
    assert len(both) == len(tables["severity/peaks.csv"]) > 0
    rms = both["acceleration_rms_g_response"]
    np.testing.assert_allclose(both["acceleration_rms_g"], rms, rtol=1e-4)
    error = both["acceleration_rms_error_g"].fillna(0.0) / rms
    np.testing.assert_allclose(both["peak_error_g"] / both["peak_g"], error, rtol=1e-4)
    assert (both["peak_g"] > both["three_sigma_g"]).all()


def test_damage_has_the_error_of_the_stress_times_the_exponent(tables):
    where = ["scenario", "point", "layer", "quantity"]
    both = tables["severity/fatigue.csv"].merge(tables["response/stress.csv"], on=where)
    assert len(both) == len(tables["severity/fatigue.csv"]) > 0
    np.testing.assert_allclose(both["stress_rms_mpa"], both["rms"], rtol=1e-4)
    expected = 6 * np.log1p(both["relative_error"].fillna(0.0))
    np.testing.assert_allclose(both["damage_log_error"], expected, rtol=1e-4)
    ratio = both["damage_narrow_band"] / both["damage_dirlik"]
    assert ratio.between(0.99, 1.6).all()


def test_errors_of_stresses_are_of_the_size_of_those_of_accelerations(tables):
    summary = tables["response/summary.csv"].dropna(subset=["acceleration_rms_error_g"])
    stress = tables["response/stress.csv"].dropna(subset=["relative_error"])
    assert len(stress) and len(summary)
    largest = (summary["acceleration_rms_error_g"] / summary["acceleration_rms_g"]).max()
    assert 0 < stress["relative_error"].max() < 3 * largest


def test_margins_are_those_of_the_mean_psd_of_each_band(tables):
    margins = tables["severity/margins.csv"]
    assert set(margins["point"]) == {"centre"}
    bands = margins[margins["quantity"] == "psd"]
    np.testing.assert_allclose(bands["limit"], 0.5, rtol=1e-9)
    np.testing.assert_allclose(10 ** (bands["margin_db"] / 10) * bands["value"], 0.5, rtol=1e-3)
    # bands that adjoin hold the whole mean square
    rms = margins[margins["quantity"] == "rms"].set_index("scenario")
    summary = tables["response/summary.csv"].query("point == 'centre'").set_index("scenario")
    np.testing.assert_allclose(rms["value"], summary["acceleration_rms_g"], rtol=1e-5)
    errors = summary["acceleration_rms_error_g"] / summary["acceleration_rms_g"]
    np.testing.assert_allclose(rms["relative_error"], errors, rtol=1e-4)
    for scenario, rows in bands.groupby("scenario"):
        square = (rows["value"] * rows["center_hz"] * (10**0.05 - 10**-0.05)).sum()
        assert square <= 1.05 * rms.loc[scenario, "value"] ** 2


def test_failure_indices_are_those_of_three_sigma(tables):
    stress = tables["response/stress.csv"]
    keys = ["scenario", "point", "layer"]
    wide = stress.pivot(index=keys, columns="quantity", values="three_sigma")
    index = tables["severity/strength.csv"].set_index(keys)
    assert len(index) and len(index) == len(wide)
    wide = wide.loc[index.index]
    expected = np.max(
        wide[["stress_xx", "stress_yy", "stress_xy"]].to_numpy() / [300, 300, 170], axis=1
    )
    np.testing.assert_allclose(index["maximum_stress_index"], expected, rtol=1e-4)
    # with equal strengths the worst signs of Tsai and Wu are von Mises' of opposite ones
    x, y, t = wide[["stress_xx", "stress_yy", "stress_xy"]].to_numpy().T
    mises = np.sqrt((x / 300) ** 2 + (y / 300) ** 2 + x * y / 300**2 + (t / 170) ** 2)
    np.testing.assert_allclose(index["tsai_wu_index"], mises, rtol=1e-4)


def test_maps_of_failure_indices_agree_with_those_at_the_points(table, tables):
    # maps are computed on fewer lines, within 1e-3
    strength = tables["severity/strength.csv"]
    with xr.open_dataset(table[1] / "severity" / "maps.nc", engine="scipy") as maps:
        away = np.abs(maps["vertex_position"] - [0.75, 0.5]).sum("axis")
        case = maps.isel(case=0, vertex=int(np.argmin(away.to_numpy())))
        rows = strength[
            (strength["scenario"] == str(case["scenario"].to_numpy()))
            & (strength["point"] == "centre")
        ].set_index("layer")
        for name in ("maximum_stress_index", "tsai_wu_index"):
            values = case[name].to_series()
            np.testing.assert_allclose(values, rows.loc[values.index, name], rtol=2e-3)
    assert "Failure index over the panel" in (table[1] / "report.html").read_text()


def test_the_page_shows_the_scenario_that_reduces_most_beside_its_bare_panel(table, tables):
    bare, best = drawn_scenarios(tables["response/summary.csv"])
    summary = tables["response/summary.csv"].set_index("scenario")
    assert (
        summary.loc[bare, "patch"].eq("none").all() and summary.loc[best, "patch"].ne("none").all()
    )
    assert summary.loc[bare, "oaspl_db"].iloc[0] == summary.loc[best, "oaspl_db"].iloc[0]
    text = (table[1] / "report.html").read_text()
    assert "von mises" not in text and "stress xx" not in text
    assert re.search(r"Vibration response spectrum at Q = \d+:", text)
    peaks = text[text.index("peak, g</th>") :].split("</table>")[0]
    errors = re.findall(r"± ([\d.]+)</td>", peaks)
    assert errors and len({len(error.partition(".")[2]) for error in errors}) == 1
    assert (
        "Peaks, strength and fatigue" in text
        and "No response point reaches the damage of failure, 1." in text
    )
