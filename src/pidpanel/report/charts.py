"""PSDs as curves that a reader can zoom and switch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.html import Chart, PageCurve
from pidpanel.report.response_figures import PsdCurve

PIXELS = 1.6  # width of a curve on a screen over that in a figure [pixel/pt]


def _line(curve: PsdCurve) -> Literal["solid", "dashed", "dotted"]:
    """Return the line of a curve: those of a figure, but for dashes in a part of a curve."""
    if curve.dotted:
        return "dotted"
    return "solid" if curve.inside is None or curve.inside.any() else "dashed"


def chart_of(title: str, frequency: Array, curves: Sequence[PsdCurve]) -> Chart:
    """Return PSD curves [(m/s²)²/Hz] for a reader to switch [g²/Hz], the first over all others."""
    drawn = [
        PageCurve(
            curve.label,
            curve.values / STANDARD_GRAVITY**2,
            curve.colour,
            _line(curve),
            1.0 if curve.colour == style.BARE else PIXELS * curve.width,
            curve.log_error,
        )
        for curve in curves
    ]
    return Chart(title, frequency, "acceleration PSD, g²/Hz", drawn)
