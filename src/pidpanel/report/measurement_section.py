"""Measured curves on the page, drawn over computed ones, with the difference by third octave."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.measurement.computed import computed_psd
from pidpanel.report import style
from pidpanel.report.base_figures import charts_figure
from pidpanel.report.html import Chart, PageCurve, PageSection, Paragraph, Picture, Table, table_of
from pidpanel.report.inputs import BaseResults, MeasurementResults
from pidpanel.report.text import READINGS, number, records, with_error

PSD, RATIO = "psd_g2_hz", "transmissibility"  # ends of the columns of either quantity

Curves = Mapping[str, xr.Dataset | None]  # computed curves by excitation, ``sound`` and ``base``


def curves_of(base: BaseResults | None) -> xr.Dataset | None:
    """Return the curves of random motion of the supports, or of a sweep without any."""
    return None if base is None else base.sine if base.psd is None else base.psd


def measurement_section(
    measured: MeasurementResults, curves: Curves, names: Mapping[str, str]
) -> PageSection:
    """Return each measurement with the computed curves of its point and scenario."""
    blocks: list[Paragraph | Picture | Table] = []
    for index, (name, rows) in enumerate(measured.differences.groupby("measurement", sort=False)):
        blocks.append(Paragraph(_sentence(str(name), rows, names)))
        lines = measured.measured[measured.measured["measurement"] == name]
        blocks.append(_picture(f"measurement_{index + 1}", lines, rows, curves))
    table = table_of(
        records(measured.differences),
        "Mean PSDs of third octaves [g²/Hz], or rms transmissibilities [1], and how much higher "
        "the computed one is. ±: one standard error of the computed one due to the damping. "
        "Numbers are in measurement/differences.csv.",
        {
            "measurement": lambda row: row["measurement"],
            "damping model": lambda row: READINGS[row["reading"]],
            "band, Hz": lambda row: number(row["center_hz"]),
            "measured": lambda row: number(_either(row, "measured")),
            "computed": lambda row: number(_either(row, "computed")),
            "difference, dB": _difference,
        },
        folded=True,
        title="Differences by third octave",
    )
    return PageSection("measurement", "Measured and computed", [*blocks, table])


def _either(row: Mapping[str, float], kind: str) -> float:
    psd = row[f"{kind}_{PSD}"]
    return psd if np.isfinite(psd) else row[f"{kind}_{RATIO}"]


def _difference(row: Mapping[str, float]) -> str:
    value, error = row["difference_db"], row["difference_error_db"]
    if not np.isfinite(value):
        return "–"
    return with_error(value, error) if np.isfinite(error) and error > 0 else f"{value:+.1f}"


def _sentence(name: str, rows: pd.DataFrame, names: Mapping[str, str]) -> str:
    """Return rms values in the common range, and the differences of its bands."""
    first = rows.iloc[0]
    is_psd = bool(np.isfinite(first[f"measured_{PSD}"]))
    parts = []
    for reading, bands in rows.groupby("reading", sort=False):
        mean = bands["difference_db"].replace([np.inf, -np.inf], np.nan).abs().mean()
        text = f"bands differ by {mean:.1f} dB on average"
        if is_psd:
            width = bands["upper_hz"] - bands["lower_hz"]
            measured, computed = (
                float(np.sqrt((bands[f"{kind}_{PSD}"] * width).sum()))
                for kind in ("measured", "computed")
            )
            level = 20 * np.log10(computed / measured)
            rms = f"{number(computed)} g rms computed, {number(measured)} g rms measured"
            text = f"{rms} ({level:+.1f} dB); {text}"
        parts.append(f"{READINGS[str(reading)]}: {text}")
    low, high = rows["lower_hz"].min(), rows["upper_hz"].max()
    under = "base motion" if first["excitation"] == "base" else "sound"
    return (
        f"{name}: {'' if is_psd else 'transmissibility of '}point {first['point']} under {under}, "
        f"{names[first['scenario']]}, {number(low)} to {number(high)} Hz. {'; '.join(parts)}."
    )


def _picture(name: str, lines: pd.DataFrame, rows: pd.DataFrame, curves: Curves) -> Picture:
    first = rows.iloc[0]
    is_psd = bool(np.isfinite(first[f"measured_{PSD}"]))
    column, unit = "acceleration_psd_g2_hz", "acceleration PSD, g²/Hz"
    if not is_psd:
        column, unit = RATIO, "acceleration over that of the supports"
    computed, drawn = curves[first["excitation"]], []
    if computed is None:
        raise ValueError(f"{first['measurement']}: no computed curves")
    frequency = computed["frequency"].to_numpy()
    test = np.interp(frequency, lines["frequency_hz"], lines[column], left=np.nan, right=np.nan)
    places = rows[["reading", "scenario", "point"]].drop_duplicates()
    for colour, place in zip(style.PLACES, records(places), strict=False):
        case = computed_psd(computed, place, over_base=not is_psd)
        if case is None:
            continue
        power = 1.0 if is_psd else 0.5
        error = None if case.log_error is None else power * case.log_error
        label = f"{READINGS[place['reading']]}, computed"
        drawn.append(PageCurve(label, case.psd**power, colour, log_error=error))
    chart = Chart("", frequency, unit, [PageCurve("measured", test, style.BARE), *drawn])
    caption = (
        f"{'Acceleration PSD' if is_psd else 'Transmissibility'}, measured (straight between its "
        "lines) and computed. Bands: one standard error due to the damping."
    )
    return Picture(name, style.Drawing(charts_figure, [chart]), caption, [chart])
