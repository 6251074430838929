"""All scenarios on the page, each with every point and reading."""

import math
from itertools import product
from typing import Any

import pandas as pd

from pidpanel.report import text
from pidpanel.report.html import PageSection, Table
from pidpanel.report.inputs import ReportedStudy

COLUMNS = (
    "scenario", "damping model", "added, kg", "of the panel, %", "point", "g rms",
    "displacement, mm rms", "reduction, dB", "dead weight: reduction, dB", "Γ of C_e",
)  # fmt: skip

CAPTION = (
    "Mass of the dampers, in kg and in percent of the panel including attached masses. Rms "
    "acceleration and displacement over the frequency range of the response, and reduction of the "
    "rms acceleration against the bare panel under the same sound. Dead weight: the same mass in "
    "the same places without damping. Γ of C_e: acceleration amplitude for the damping. ±: one "
    "standard error, where known. –: unknown, or none. † linear plate theory does not hold (rms "
    "displacement above a tenth of the thickness). ‡ partly outside the range of the damping's "
    "data."
)


def summary_section(study: ReportedStudy, summary: pd.DataFrame) -> PageSection:
    """Return mass, rms values and reductions of all scenarios."""
    by_key = {(row["scenario"], row["reading"], row["point"]): row for row in text.records(summary)}
    rms_decimals = text.common_decimals(summary["acceleration_rms_error_g"])
    decimals = text.common_decimals(summary["reduction_error_db"], text.DECIBEL_DECIMALS)
    rows = []
    for scenario, reading, point in product(study.scenarios, study.readings, study.panel.points):
        row = by_key[scenario.label, reading, point]
        name = study.names[scenario.label]
        if name == scenario.label and not scenario.is_bare:
            name += f" ({scenario.filling_text})"
        mass = [text.number(row["added_mass_kg"]), text.number(row["added_mass_percent"], 2)]
        if row["status"] == "ok":
            values = _values(row, rms_decimals, decimals)
        else:
            words = "does not move" if row["status"] == "held" else str(row["status"])
            values = [words, "–", "–", "–", "–"]
        rows.append([name, text.READINGS[reading], *mass, point, *values])
    return PageSection("summary", "All scenarios", [Table(CAPTION, COLUMNS, rows)])


def _values(row: dict[str, Any], rms_decimals: int | None, decimals: int | None) -> list[str]:
    is_bare = not row["reduction_db"]  # against itself
    return [
        text.value_text(row["acceleration_rms_g"], row["acceleration_rms_error_g"], rms_decimals),
        text.number(row["displacement_rms_mm"]) + " †" * bool(row["beyond_linear_plate"]),
        "–"
        if is_bare
        else text.value_text(row["reduction_db"], row["reduction_error_db"], decimals),
        "–" if is_bare else text.value_text(row["dead_weight_reduction_db"], math.nan, decimals),
        text.number(row["damping_read_at_g"]) + " ‡" * bool(row["outside_run_points_share"] > 0),
    ]
