"""Every reading beside the coupled runs by third octave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.coupled import COUPLED
from pidpanel.report import style
from pidpanel.report.layout import WIDTH
from pidpanel.report.text import READINGS
from pidpanel.report.verdict import BAND_DEPTH, BAND_LIMIT
from pidpanel.response.psd_files import is_steady
from pidpanel.solve.bands import band_rms, whole_third_octaves


def band_differences(frequency: Array, psd: Array, run: pd.DataFrame) -> tuple[Array, Array, Array]:
    """Return centres [Hz] of the third octaves, a reading over the run, and the run's error [dB].

    NaN where a third octave of the run is `BAND_DEPTH` below its highest.
    """
    lines = run["frequency_hz"].to_numpy(float)
    run_psd = run["acceleration_psd_g2_hz"].to_numpy(float)
    centre, edge = whole_third_octaves(float(lines[0]), float(lines[-1]))
    run_rms, reading_rms = band_rms(lines, run_psd, edge), band_rms(frequency, psd, edge)
    weighted = band_rms(lines, run_psd * run["error_db"].to_numpy(float), edge) ** 2
    counts = run_rms >= 10 ** (-BAND_DEPTH / 20) * run_rms.max()
    difference = np.where(counts, 20 * np.log10(reading_rms / run_rms), np.nan)
    return centre, difference, np.where(counts, weighted / run_rms**2, np.nan)


def band_figure(
    psd: xr.Dataset, run: pd.DataFrame, scenarios: Sequence[tuple[str, str]], points: Sequence[str]
) -> Figure:
    """Draw every reading over the coupled run by third octave, a row a scenario."""
    readings = [str(name) for name in psd["reading"].to_numpy() if name != COUPLED]
    figure = Figure(figsize=(WIDTH, 0.7 + 1.5 * len(scenarios)), layout="constrained")
    grid = figure.subplots(len(scenarios), len(points), sharex=True, sharey="row", squeeze=False)
    lines = psd["frequency"].to_numpy()
    for row, (label, title) in zip(grid, scenarios, strict=True):
        for axes, point in zip(row, points, strict=True):
            rows = run[(run["scenario"] == label) & (run["point"] == point)]
            axes.axhspan(-BAND_LIMIT, BAND_LIMIT, color="#eeeeee", lw=0, zorder=0)
            for reading in readings:
                if not is_steady(psd, reading, label):
                    continue
                key = {"reading": reading, "scenario": label, "point": point}
                values = psd["acceleration_psd"].sel(key).to_numpy() / STANDARD_GRAVITY**2
                centre, difference, error = band_differences(lines, values, rows)
                colour = style.place_colour(reading, readings)
                axes.semilogx(centre, difference, color=colour, label=READINGS[reading])
            if readings:
                axes.errorbar(
                    centre, 0 * error, 2 * error, color=style.BARE, lw=0.8, capsize=1.5,
                    label="Coupled run, ± two standard errors",
                )  # fmt: skip
            axes.set_title(f"{title}, point {point}", loc="left", fontsize="small")
    for axes in grid[-1]:
        axes.set_xlabel("Frequency, Hz")
    for row in grid:
        row[0].set_ylabel("dB")
    handles, names = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure
