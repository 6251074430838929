"""Margins of accelerations to limits, with their errors and verdicts.

The margin is 20 lg of the allowed rms over the rms, or 10 lg of the allowed mean PSD of a third
octave over the mean PSD. The margin of safety is the ratio of these amplitudes less 1.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.response.trust import MOTION_RESIDUAL, SIGNIFICANCE
from pidpanel.severity.tables import PLACE, PointMotion
from pidpanel.solve.bands import band_rms, third_octaves
from pidpanel.spectra.break_points import BreakPoints

MET, EXCEEDED, OPEN = "met", "exceeded", "not decided"
# of rows that are not judged yet
ROW = (*PLACE, "quantity", "center_hz", "value", "relative_error", "unit", "limit")
JUDGED = ("margin_db", "margin_error_db", "margin_of_safety", "verdict")
COLUMNS = ("excitation", *ROW, *JUDGED, "doubts")


def with_margins(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows with margin, its error, margin of safety and verdict.

    A limit is met or exceeded beyond two standard errors of the acceleration; else it is not
    decided. A row without an error is judged by its value.

    Examples
    --------
    >>> rows = pd.DataFrame({"quantity": "rms", "value": [20, 24, 30.0], "limit": 25.0})
    >>> with_margins(rows.assign(relative_error=0.05))["verdict"].tolist()
    ['met', 'not decided', 'exceeded']
    """
    per_decade = np.where(rows["quantity"] == "rms", 20.0, 10.0)
    with np.errstate(divide="ignore"):
        margin = per_decade * np.log10(rows["limit"] / rows["value"])
    ratio, error = 10 ** (margin / 20), rows["relative_error"]
    reach = SIGNIFICANCE * error.fillna(0.0)
    is_met = ratio >= 1 + reach - MOTION_RESIDUAL  # to which rms values are good
    return rows.assign(
        margin_db=margin,
        margin_error_db=20 * np.log10(1 + error),
        margin_of_safety=ratio - 1,
        verdict=np.select([is_met, ratio < 1 - reach], [MET, EXCEEDED], OPEN),
    )


def rms_rows(summary: pd.DataFrame, limits: Mapping[str, float]) -> pd.DataFrame:
    """Return rows of points with a limit [g] in ``response/summary.csv`` or ``base/summary.csv``.

    Points that do not move, and scenarios without a response, have none.
    """
    moves = (summary["status"] == "ok") & summary["point"].isin(list(limits))
    rows = summary.loc[moves, list(PLACE)]
    value = summary.loc[moves, "acceleration_rms_g"]
    error = summary.loc[moves, "acceleration_rms_error_g"] / value
    rows = rows.assign(quantity="rms", center_hz=np.nan, value=value, relative_error=error)
    return rows.assign(unit="g", limit=rows["point"].map(limits))


def band_rows(motion: PointMotion, limits: Mapping[str, BreakPoints]) -> Iterator[tuple[Any, ...]]:
    """Yield a row per point with a limit [g²/Hz] and third octave: means of the PSD and of it."""
    where, points, frequency, psd, error, _ = motion
    for index, point in enumerate(points):
        limit = limits.get(point)
        if limit is None:
            continue
        low, high = max(frequency[0], limit.frequency[0]), min(frequency[-1], limit.frequency[-1])
        centers, edges = third_octaves(low, high)
        means = band_rms(frequency, psd[:, [index]], edges)[:, 0] ** 2 / np.diff(edges)[:, 0]
        for center, edge, mean in zip(centers, edges, means, strict=True):
            allowed = limit.segment(*edge).rms ** 2 / (edge[1] - edge[0])
            yield (*where.values(), point, "psd", center, mean, error[index], "g2/Hz", allowed)
