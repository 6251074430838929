"""Rms accelerations of scenarios, over all frequencies and by third octave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.response.bands import band_rms, third_octaves


def moving_points(summary: pd.DataFrame, points: Sequence[str]) -> list[str]:
    """Return the points that move; one on a support does not, and nothing can be said of it.

    Parameters
    ----------
    summary
        ``response/summary.csv`` (points as text).
    points
        Names of the points in order.
    """
    held = set(summary.loc[summary["status"] == "held", "point"])
    return [point for point in points if point not in held]


def rms_by(
    summary: pd.DataFrame, reading: str, labels: Mapping[object, str], points: Sequence[str]
) -> pd.DataFrame:
    """Return rms accelerations of scenarios under an index of one's own.

    Parameters
    ----------
    summary
        ``response/summary.csv`` (points as text).
    reading
        One of its readings.
    labels
        Labels of the scenarios by the index wanted.
    points
        The columns wanted.

    Returns
    -------
    pandas.DataFrame
        Rms acceleration [g]; NaN where there is no steady response.
    """
    of = summary[summary["reading"] == reading]
    wide = of.pivot(index="scenario", columns="point", values="acceleration_rms_g")
    frame = wide.reindex(index=list(labels.values()), columns=list(points))
    return frame.set_axis(pd.Index(list(labels)), axis=0)


def band_rms_of(
    psd: xr.Dataset, reading: str, labels: Sequence[str], points: Sequence[str]
) -> tuple[Array, Array]:
    """Return third-octave rms accelerations of scenarios.

    Parameters
    ----------
    psd
        ``response/psd.nc``.
    reading
        One of its readings.
    labels, points
        The scenarios and points wanted, in order.

    Returns
    -------
    centre
        Centres of the bands [Hz], shape ``(n_bands,)``.
    rms
        Rms acceleration [m/s²], shape ``(n_scenarios, n_bands, n_points)``.
    """
    frequency = psd["frequency"].to_numpy()
    chosen = psd["acceleration_psd"].sel(reading=reading, scenario=list(labels), point=list(points))
    values = chosen.transpose("frequency", "scenario", "point").to_numpy()
    centre, edge = third_octaves(frequency[0], frequency[-1])
    return centre, band_rms(frequency, values, edge).transpose(1, 0, 2)
