"""Rms accelerations of scenarios, over all frequencies and by third octave."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report.html import PageCurve
from pidpanel.solve.bands import band_rms, third_octaves


def moving_points(summary: pd.DataFrame, points: Sequence[str]) -> list[str]:
    """Return the points that move: all but those on supports."""
    fixed = set(summary.loc[summary["status"] == "held", "point"])
    return [point for point in points if point not in fixed]


def rms_by(
    summary: pd.DataFrame,
    labels: Mapping[object, str],
    points: Sequence[str],
    column: str = "acceleration_rms_g",
) -> pd.DataFrame:
    """Return rms accelerations of scenarios, or another column, NaN where unknown, by label."""
    rows = summary
    if column not in rows:
        rows = rows.assign(**{column: np.nan})
    wide = rows.pivot(index="scenario", columns="point", values=column)
    frame = wide.reindex(index=list(labels.values()), columns=list(points))
    return frame.set_axis(pd.Index(list(labels)), axis=0)


def band_rms_of(
    psd: xr.Dataset, labels: Sequence[str], points: Sequence[str]
) -> tuple[Array, Array]:
    """Return centres (n_bands,) [Hz] and rms values (n_scenarios, n_bands, n_points) [m/s²]."""
    frequency = psd["frequency"].to_numpy()
    chosen = psd["acceleration_psd"].sel(scenario=list(labels), point=list(points))
    values = chosen.transpose("frequency", "scenario", "point").to_numpy()
    centre, edge = third_octaves(frequency[0], frequency[-1])
    return centre, band_rms(frequency, values, edge).transpose(1, 0, 2)


def band_error_of(psd: xr.Dataset, labels: Sequence[str], points: Sequence[str]) -> Array:
    """Return standard errors of the levels of third-octave rms accelerations [dB].

    (n_scenarios, n_bands, n_points); NaN where no errors are known. Errors are common to the lines
    of a band, which has their mean, weighted with their PSD.
    """
    _, whole = band_rms_of(psd, labels, points)
    if "acceleration_psd_log_error" not in psd:
        return np.full(whole.shape, np.nan)
    weighted = psd["acceleration_psd"] * psd["acceleration_psd_log_error"]
    _, error = band_rms_of(psd.assign(acceleration_psd=weighted), labels, points)
    return 10 / np.log(10) * error**2 / whole**2


def inside_of(psd: xr.Dataset, scenario: str) -> Flags:
    """Return (nf,) whether the damping of all patches is within the range of its data."""
    if "inside" not in psd:  # a panel without patches
        return np.ones(psd.sizes["frequency"], dtype=np.bool_)
    inside = psd["inside"].sel(scenario=scenario).transpose("patch", "frequency")
    return np.asarray((inside.to_numpy() > 0.5).all(axis=0))


def psd_curve(
    psd: xr.Dataset,
    place: Mapping[str, str],
    label: str,
    colour: str,
    width: float,
    *,
    has_band: bool = False,
) -> PageCurve:
    """Return the acceleration PSD [g²/Hz] of a scenario and point as a curve.

    Its band is the standard error of ln of the PSD due to its damping, where there is one.
    """
    values = psd["acceleration_psd"].sel(place).to_numpy() / STANDARD_GRAVITY**2
    inside, error = inside_of(psd, place["scenario"]), None
    if has_band and "acceleration_psd_log_error" in psd:
        errors = psd["acceleration_psd_log_error"].sel(place).to_numpy()
        error = errors if np.isfinite(errors).all() else None
    return PageCurve(label, values, colour, width=width, log_error=error, inside=inside)
