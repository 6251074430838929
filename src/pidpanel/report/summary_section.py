"""All scenarios on the page, each with every point and reading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pandas as pd

from pidpanel.report.html import PageSection, Table
from pidpanel.report.text import READINGS, common_decimals, number, records, value_text


def summary_section(
    summary: pd.DataFrame, scenarios: Sequence[str], points: Sequence[str]
) -> PageSection:
    """Return the table of all scenarios."""
    return PageSection("summary", "All scenarios", [response_table(summary, scenarios, points)])


def response_table(summary: pd.DataFrame, scenarios: Sequence[str], points: Sequence[str]) -> Table:
    """Return rms values and reduction of each scenario and point, the readings side by side."""
    readings = list(dict.fromkeys(summary["reading"]))
    columns = ["scenario", "point"]
    for reading in readings:
        name = READINGS.get(reading, reading)
        columns += [f"{name}: g rms", "displacement, mm rms", "reduction, dB", "Γ of C_e"]
    by_key = {(row["scenario"], row["point"], row["reading"]): row for row in records(summary)}
    decimals = {
        error: common_decimals(summary[error]) if error in summary else None
        for error in ("acceleration_rms_error_g", "reduction_error_db")
    }

    def text(row: dict[str, Any], value: str, error: str) -> str:
        return value_text(row[value], row.get(error, math.nan), decimals[error])

    rows = []
    for scenario in scenarios:
        for point in points:
            row = [scenario, point]
            for reading in readings:
                cell = by_key[scenario, point, reading]
                if cell["status"] == "held":
                    row += ["does not move", "–", "–", "–"]
                    continue
                if cell["status"] != "ok":
                    row += [str(cell["status"]), "–", "–", "–"]
                    continue
                row += [
                    text(cell, "acceleration_rms_g", "acceleration_rms_error_g"),
                    number(cell["displacement_rms_mm"]) + " †" * bool(cell["beyond_linear_plate"]),
                    text(cell, "reduction_db", "reduction_error_db")
                    if cell["reduction_db"]  # none of the bare panel against itself
                    else "–",
                    number(cell["damping_read_at_g"])
                    + " ‡" * bool(cell["outside_run_points_share"] > 0),
                ]
            rows.append(row)
    return Table(
        "Rms acceleration and displacement over the frequency range of the response, and "
        "reduction of the rms acceleration against the bare panel under the same sound. Γ of "
        "C_e: acceleration amplitude for the damping. ±: one standard error. † linear plate "
        "theory does not hold (rms displacement above a tenth of the thickness). ‡ partly "
        "outside the range of the damping's data.",
        columns,
        rows,
    )
