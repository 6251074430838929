"""Rows of text from frames of numbers, with the units in the heads of the columns."""

from __future__ import annotations

import math

import pandas as pd

from pidpanel.report.html import Table

READINGS = {
    "dem": "DEM",
    "paper_corrected": "paper's law, corrected",
    "paper_printed": "paper's law, as printed",
    "table": "table",
}
"""What the readings of the damping are called on the page."""


def number(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, no exponent between 1e-4 and 1e5; – for NaN.

    Examples
    --------
    >>> number(0.123456), number(1234.5), number(float("nan"))
    ('0.123', '1234', '–')
    """
    if not math.isfinite(value):
        return "–"
    if value != 0 and not 1e-4 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}·10^{int(exponent)}"
    decimals = max(0, digits - 1 - (math.floor(math.log10(abs(value))) if value else 0))
    return f"{value:.{decimals}f}"


def response_table(summary: pd.DataFrame) -> Table:
    """Scenario by point: rms values and reduction, the readings side by side.

    Parameters
    ----------
    summary
        ``response/summary.csv``: one row a reading, scenario and point.
    """
    readings = list(dict.fromkeys(summary["reading"]))
    columns = ["scenario", "point"]
    for reading in readings:
        name = READINGS.get(reading, reading)
        columns += [f"{name}: a rms, g", "w rms, mm", "reduction, dB", "C_e read at Γ"]
    rows = []
    for (scenario, point), group in summary.groupby(["scenario", "point"], sort=False):
        row = [str(scenario), str(point)]
        for reading in readings:
            one = group[group["reading"] == reading].iloc[0]
            if one["status"] != "ok":
                row += [str(one["status"]), "–", "–", "–"]
                continue
            row += [
                number(one["acceleration_rms_g"]),
                number(one["displacement_rms_mm"]),
                f"{one['reduction_db']:.2f}",
                number(one["damping_read_at_g"]),
            ]
        rows.append(row)
    return Table("Acceleration and displacement, rms over the frequencies looked at", columns, rows)
