"""Rms accelerations of scenarios, over all frequencies and by third octave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.solve.bands import band_rms, third_octaves


def moving_points(summary: pd.DataFrame, points: Sequence[str]) -> list[str]:
    """Return the points that move; one on a support does not, and nothing can be said of it."""
    fixed = set(summary.loc[summary["status"] == "held", "point"])
    return [point for point in points if point not in fixed]


def rms_by(
    summary: pd.DataFrame,
    reading: str,
    labels: Mapping[object, str],
    points: Sequence[str],
    column: str = "acceleration_rms_g",
) -> pd.DataFrame:
    """Return rms accelerations of scenarios, or another column, NaN where unknown, by label."""
    rows = summary[summary["reading"] == reading]
    if column not in rows:
        rows = rows.assign(**{column: np.nan})
    wide = rows.pivot(index="scenario", columns="point", values=column)
    frame = wide.reindex(index=list(labels.values()), columns=list(points))
    return frame.set_axis(pd.Index(list(labels)), axis=0)


def band_rms_of(
    psd: xr.Dataset, reading: str, labels: Sequence[str], points: Sequence[str]
) -> tuple[Array, Array]:
    """Return centres (n_bands,) [Hz] and rms values (n_scenarios, n_bands, n_points) [m/s²]."""
    frequency = psd["frequency"].to_numpy()
    chosen = psd["acceleration_psd"].sel(reading=reading, scenario=list(labels), point=list(points))
    values = chosen.transpose("frequency", "scenario", "point").to_numpy()
    centre, edge = third_octaves(frequency[0], frequency[-1])
    return centre, band_rms(frequency, values, edge).transpose(1, 0, 2)


def band_error_of(
    psd: xr.Dataset, reading: str, labels: Sequence[str], points: Sequence[str]
) -> Array:
    """Return standard errors of the levels of third-octave rms accelerations [dB].

    (n_scenarios, n_bands, n_points); NaN where no errors are known. Errors are common to the lines
    of a band, which has their mean, weighted with their PSD.
    """
    frequency = psd["frequency"].to_numpy()
    _, edge = third_octaves(frequency[0], frequency[-1])
    if "acceleration_psd_log_error" not in psd:
        return np.full((len(labels), len(edge), len(points)), np.nan)
    chosen = psd.sel(reading=reading, scenario=list(labels), point=list(points))
    order = ("frequency", "scenario", "point")
    values = chosen["acceleration_psd"].transpose(*order).to_numpy()
    error = chosen["acceleration_psd_log_error"].transpose(*order).to_numpy()
    whole = band_rms(frequency, values, edge) ** 2
    error_square = band_rms(frequency, values * error, edge) ** 2
    return (10 / np.log(10) * error_square / whole).transpose(1, 0, 2)
