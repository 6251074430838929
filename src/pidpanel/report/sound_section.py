"""The sound on the page: band levels and pressure PSD."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pidpanel.report import style
from pidpanel.report.html import Chart, Fragment, PageCurve, PageSection, Picture
from pidpanel.report.layout import WIDTH, frequency_axis

LEVEL, DENSITY = "band level, dB re 20 µPa", "pressure PSD on the surface, Pa²/Hz"


def sound_section(
    bands: pd.DataFrame,
    spectrum: str,
    rows: str,
    frequency: tuple[float, float],
    *,
    assumed: bool = False,
) -> PageSection:
    """Return the spectrum of the sound, of a table of bands or of rows of PSD."""
    overall = 10 * np.log10(np.sum(10 ** (bands["band_spl_db"] / 10)))
    charts = [
        _steps(bands, "band_spl_db", LEVEL, is_log=False),
        _steps(bands, "surface_pressure_psd_pa2_hz", DENSITY),
    ]
    drawing = style.Drawing(spectrum_figure, bands, *frequency)
    values = {
        "spectrum": Picture("spectrum", drawing, charts=charts),
        "name": spectrum,
        "overall": overall,
        "rows": rows,
        "low": frequency[0],
        "high": frequency[1],
        "assumed": assumed,
    }
    return PageSection("sound", "Sound", [Fragment("sound.html", values)])


def _steps(bands: pd.DataFrame, column: str, unit: str, *, is_log: bool = True) -> Chart:
    """Return values of bands, each from edge to edge."""
    edges = np.column_stack([bands["lower_hz"], bands["upper_hz"]]).ravel()
    values = np.repeat(bands[column].to_numpy(float), 2)
    return Chart("", edges, unit, [PageCurve(unit, values, style.PLACES[0])], "", is_log)


def spectrum_figure(bands: pd.DataFrame, low: float, high: float) -> Figure:
    """Draw band levels and pressure PSD of the sound; outside the response's range is grey."""
    figure = Figure(figsize=(WIDTH, 3.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    edges = np.append(bands["lower_hz"].to_numpy(), bands["upper_hz"].to_numpy()[-1])
    colour = style.PLACES[0]
    for axes, column in ((left, "band_spl_db"), (right, "surface_pressure_psd_pa2_hz")):
        values = bands[column].to_numpy()
        axes.stairs(values, edges, color=colour, lw=1.1, baseline=None)
        frequency_axis(axes, edges[0], edges[-1])
        for start, stop in ((edges[0], low), (high, edges[-1])):
            if stop > start:
                axes.axvspan(start, stop, color="#eeeeee", lw=0, zorder=0)
    left.plot(bands["center_hz"], bands["band_spl_db"], "o", color=colour, ms=3)
    left.set_ylabel(LEVEL)
    left.set_title("band levels", loc="left", fontweight="bold")
    right.set_yscale("log")
    right.set_ylabel(DENSITY)
    right.set_title("one-sided PSD", loc="left", fontweight="bold")
    return figure
