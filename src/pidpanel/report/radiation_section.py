"""Radiation on the page: what the air takes from the panel, beside what a damper takes."""

from __future__ import annotations

import pandas as pd

from pidpanel.report.html import PageSection, table_of
from pidpanel.report.text import READINGS, number, records

SIDES = {
    "none": "no radiation",
    "one_side": "radiation from one side",
    "two_sides": "radiation from both sides",
}
"""Names of the values of ``response.radiation``."""


def compared(summary: pd.DataFrame, radiation: pd.DataFrame) -> pd.DataFrame:
    """Return each scenario with a response under both radiations, the other one ``_beside``."""
    good = summary[summary["status"] == "ok"]
    return good.merge(radiation, on=["reading", "scenario", "point"], suffixes=("", "_beside"))


def radiation_section(pairs: pd.DataFrame, base: str, *, air_mass: bool) -> PageSection:
    """Return every scenario under both radiations, from `compared`."""
    base_side, rival_side = SIDES[base], SIDES[str(pairs["radiation"].iloc[0])]
    carried = "with its added mass" if air_mass else "without added mass"
    table = table_of(
        records(pairs),
        "Rms acceleration, and reduction against the bare panel with the same radiation of a "
        f"baffled panel into the air, {carried}",
        {
            "damping model": lambda row: READINGS[row["reading"]],
            "scenario": lambda row: row["scenario"],
            "point": lambda row: row["point"],
            f"{base_side}: g rms": lambda row: number(row["acceleration_rms_g"]),
            f"{rival_side}: g rms": lambda row: number(row["acceleration_rms_g_beside"]),
            f"{base_side}: reduction, dB": lambda row: f"{row['reduction_db']:.2f}",
            f"{rival_side}: reduction, dB": lambda row: f"{row['reduction_db_beside']:.2f}",
        },
    )
    return PageSection("radiation", "Radiation into the air", [table])
