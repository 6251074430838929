"""Measured PSDs on the page, drawn over computed ones, with the difference by third octave."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.charts import chart_of
from pidpanel.report.html import PageSection, Paragraph, Picture, Table, table_of
from pidpanel.report.inputs import MeasurementResults
from pidpanel.report.response_figures import FigurePanel, PsdCurve, psd_figure
from pidpanel.report.rms import log_error_of
from pidpanel.report.text import READINGS, number, records, with_error

MEASURED = style.BARE


def measurement_section(
    measured: MeasurementResults, psd: xr.Dataset, names: Mapping[str, str]
) -> PageSection:
    """Return each measurement with the computed PSDs of its point and scenario."""
    blocks: list[Paragraph | Picture | Table] = []
    for index, (name, rows) in enumerate(measured.differences.groupby("measurement", sort=False)):
        blocks.append(Paragraph(_sentence(str(name), rows, names)))
        lines = measured.psd[measured.psd["measurement"] == name]
        blocks.append(_picture(f"measurement_{index + 1}", lines, rows, psd))
    table = table_of(
        records(measured.differences),
        "Mean PSDs of third octaves, and how much higher the computed one is. ±: one standard "
        "error of the computed PSD due to the damping. Numbers are in measurement/differences.csv.",
        {
            "measurement": lambda row: row["measurement"],
            "damping model": lambda row: READINGS[row["reading"]],
            "band, Hz": lambda row: number(row["center_hz"]),
            "measured, g²/Hz": lambda row: number(row["measured_psd_g2_hz"]),
            "computed, g²/Hz": lambda row: number(row["computed_psd_g2_hz"]),
            "difference, dB": _difference,
        },
        folded=True,
        title="Differences by third octave",
    )
    return PageSection("measurement", "Measured and computed", [*blocks, table])


def _difference(row: Mapping[str, float]) -> str:
    value, error = row["difference_db"], row["difference_error_db"]
    if not np.isfinite(value):
        return "–"
    return with_error(value, error) if np.isfinite(error) and error > 0 else f"{value:+.1f}"


def _sentence(name: str, rows: pd.DataFrame, names: Mapping[str, str]) -> str:
    """Return rms values in the common range, and the differences of its bands."""
    first = rows.iloc[0]
    parts = []
    for reading, bands in rows.groupby("reading", sort=False):
        width = bands["upper_hz"] - bands["lower_hz"]
        measured, computed = (
            float(np.sqrt((bands[f"{kind}_psd_g2_hz"] * width).sum()))
            for kind in ("measured", "computed")
        )
        level = 20 * np.log10(computed / measured)
        mean = bands["difference_db"].replace([np.inf, -np.inf], np.nan).abs().mean()
        parts.append(
            f"{READINGS[str(reading)]}: {number(computed)} g rms computed, {number(measured)} "
            f"g rms measured ({level:+.1f} dB); bands differ by {mean:.1f} dB on average"
        )
    low, high = rows["lower_hz"].min(), rows["upper_hz"].max()
    return (
        f"{name}: point {first['point']}, {names[first['scenario']]}, {number(low)} to "
        f"{number(high)} Hz. {'; '.join(parts)}."
    )


def _picture(name: str, lines: pd.DataFrame, rows: pd.DataFrame, psd: xr.Dataset) -> Picture:
    frequency = psd["frequency"].to_numpy()
    test = np.interp(
        frequency, lines["frequency_hz"], lines["acceleration_psd_g2_hz"], left=np.nan, right=np.nan
    )
    curves = [PsdCurve("measured", test * STANDARD_GRAVITY**2, MEASURED, width=1.4)]
    where = rows[["reading", "scenario", "point"]].drop_duplicates()
    for colour, (reading, scenario, point) in zip(style.PLACES, where.to_numpy(), strict=False):
        at = {"reading": reading, "scenario": scenario, "point": point}
        values = psd["acceleration_psd"].sel(at).to_numpy()
        error = log_error_of(psd, reading, scenario, point)
        label = f"{READINGS[reading]}, computed"
        curves.append(PsdCurve(label, values, colour, log_error=error))
    figure = psd_figure(frequency, [FigurePanel("", "", curves)])
    caption = (
        "Acceleration PSD, measured (straight between its lines) and computed. Bands: one "
        "standard error due to the damping."
    )
    return Picture(name, style.png(figure), caption, [chart_of("", frequency, curves)])
