"""Measured curves on the page, drawn over computed ones, with the difference by third octave."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.measurement.computed import computed_psd
from pidpanel.report import style
from pidpanel.report.html import Chart, PageCurve, PageSection, Picture, template_section
from pidpanel.report.inputs import BaseResults, MeasurementResults
from pidpanel.report.response_figures import chart_picture, psd_unit
from pidpanel.report.text import records, with_error

# Ends of the columns of each quantity
PSD, RATIO, ACCELERANCE = "psd_g2_hz", "transmissibility", "accelerance_1_kg"

Curves = Mapping[
    str, xr.Dataset | None
]  # computed curves by excitation, ``sound``, ``base`` and ``hammer``


def curves_of(base: BaseResults | None) -> xr.Dataset | None:
    """Return the curves of random motion of the supports, or of a sweep without any."""
    return None if base is None else base.sine if base.psd is None else base.psd


def measurement_section(
    measured: MeasurementResults, curves: Curves, names: Mapping[str, str]
) -> PageSection:
    """Return each measurement with the computed curves of its point and scenario."""
    measurements = []
    for index, (name, rows) in enumerate(measured.differences.groupby("measurement", sort=False)):
        lines = measured.measured[measured.measured["measurement"] == name]
        about = _values(str(name), rows, names)
        picture = _picture(
            f"measurement_{index + 1}", lines, rows, curves, names, is_psd=about["is_psd"]
        )
        measurements.append({**about, "picture": picture})
    differences = [
        {**row, **_either(row), "difference": _difference(row), "name": names[row["scenario"]]}
        for row in records(measured.differences)
    ]
    values = {"measurements": measurements, "differences": differences}
    return template_section("measurement.html", "Measured and computed", values)


def _either(row: Mapping[str, float]) -> dict[str, float]:
    """Return the measured and the computed value of a band, PSD or ratio."""
    end = next(end for end in (PSD, RATIO, ACCELERANCE) if np.isfinite(row[f"measured_{end}"]))
    return {kind: row[f"{kind}_{end}"] for kind in ("measured", "computed")}


def _difference(row: Mapping[str, float]) -> str:
    value, error = row["difference_db"], row["difference_error_db"]
    if not np.isfinite(value):
        return "–"
    return with_error(value, error) if np.isfinite(error) and error > 0 else f"{value:+.1f}"


def _values(name: str, rows: pd.DataFrame, names: Mapping[str, str]) -> dict[str, Any]:
    """Return rms values in the common range, and the differences of its bands."""
    first = rows.iloc[0]
    is_psd = bool(np.isfinite(first[f"measured_{PSD}"]))
    models = []
    for label, bands in rows.groupby("scenario", sort=False):
        width = bands["upper_hz"] - bands["lower_hz"]
        measured, computed = (
            float(np.sqrt((bands[f"{kind}_{PSD}"] * width).sum())) if is_psd else np.nan
            for kind in ("measured", "computed")
        )
        models.append(
            {
                "name": names[str(label)],
                "mean": bands["difference_db"].replace([np.inf, -np.inf], np.nan).abs().mean(),
                "measured": measured,
                "computed": computed,
                "level": 20 * np.log10(computed / measured),
            }
        )
    return {
        "name": name,
        "is_psd": is_psd,
        "point": first["point"],
        "excitation": first["excitation"],
        "low": rows["lower_hz"].min(),
        "high": rows["upper_hz"].max(),
        "models": models,
    }


def _picture(
    name: str,
    lines: pd.DataFrame,
    rows: pd.DataFrame,
    curves: Curves,
    names: Mapping[str, str],
    *,
    is_psd: bool,
) -> Picture:
    first = rows.iloc[0]
    column, unit = "acceleration_psd_g2_hz", psd_unit(str(first["point"]))
    if not is_psd:
        is_hit = first["excitation"] == "hammer"
        column, unit = (
            (ACCELERANCE, "accelerance, 1/kg") if is_hit else (RATIO, "transmissibility, –")
        )
    computed, drawn = curves[first["excitation"]], []
    if computed is None:
        raise ValueError(f"{first['measurement']}: no computed curves")
    frequency = computed["frequency"].to_numpy()
    test = np.interp(frequency, lines["frequency_hz"], lines[column], left=np.nan, right=np.nan)
    places = rows[["scenario", "point", "drive"]].drop_duplicates()
    for colour, place in zip(style.PLACES, records(places), strict=False):
        case = computed_psd(computed, place, over_base=not is_psd)
        if case is None:
            continue
        power = 1.0 if is_psd else 0.5
        error = None if case.log_error is None else power * case.log_error
        label = f"{names[place['scenario']]}, computed"
        drawn.append(PageCurve(label, case.psd**power, colour, log_error=error))
    chart = Chart("", frequency, unit, [PageCurve("measured", test, style.BARE), *drawn])
    return chart_picture(name, [chart])
