"""Radiation on the page: what the air takes from the panel, beside what a damper takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pidpanel.report.html import PageSection, Paragraph, table_of
from pidpanel.report.text import READINGS, number, percent, records, signed
from pidpanel.solve.bands import reduction

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


def radiation_finding(
    pairs: pd.DataFrame, base: str, points: Sequence[str], *, air_mass: bool = True
) -> str:
    """Return how much the other radiation changes, beside the best damper, and what that means."""
    other_radiation = str(pairs["radiation"].iloc[0])
    changes = []
    for point in [name for name in points if name in set(pairs["point"])]:
        rows = pairs[pairs["point"] == point]
        bare = rows[rows["patch"] == "none"].iloc[0]
        damped = rows[rows["patch"] != "none"]
        air = float(reduction(bare["acceleration_rms_g"], bare["acceleration_rms_g_beside"]))
        changes.append(
            f"at point {point} the bare panel goes from {bare['acceleration_rms_g']:.1f} to "
            f"{bare['acceleration_rms_g_beside']:.1f} g rms ({signed(-air, 1)} dB)"
        )
        if len(damped):
            best = damped.sort_values("reduction_db").iloc[-1]
            changes[-1] += (
                f", and the largest reduction ({best['scenario']}) is "
                f"{best['reduction_db_beside']:.1f} dB instead of {best['reduction_db']:.1f} dB"
            )
    carried = "added mass included" if air_mass else "resistance without added mass"
    instead = (
        f"With {SIDES[other_radiation]} of a baffled panel ({carried}) instead of {SIDES[base]}: "
        f"{'; '.join(changes)}."
    )
    damped = pairs[pairs["patch"] != "none"]
    if not len(damped):
        return instead
    share = float(np.mean(damped["reduction_db_beside"] < damped["reduction_db"]))
    verdict = f"The reduction is then smaller in {percent(share)} of the scenarios and points"
    verdict += f": computed with {SIDES[base]}, it is overestimated." if share > 0.5 else " only."
    return f"{instead} {verdict}"


def radiation_section(
    summary: pd.DataFrame,
    radiation: pd.DataFrame,
    base: str,
    points: Sequence[str],
    *,
    air_mass: bool = True,
) -> PageSection:
    """Return the finding, and every scenario under both radiations."""
    pairs = compared(summary, radiation)
    base_side, rival_side = SIDES[base], SIDES[str(pairs["radiation"].iloc[0])]
    table = table_of(
        records(pairs),
        "Rms acceleration, and reduction against the bare panel with the same radiation",
        {
            "damping model": lambda row: READINGS[row["reading"]],
            "scenario": lambda row: row["scenario"],
            "point": lambda row: row["point"],
            f"{base_side}: g rms": lambda row: number(row["acceleration_rms_g"]),
            f"{rival_side}: g rms": lambda row: number(row["acceleration_rms_g_beside"]),
            f"{base_side}: reduction, dB": lambda row: f"{row['reduction_db']:.2f}",
            f"{rival_side}: reduction, dB": lambda row: f"{row['reduction_db_beside']:.2f}",
        },
        folded=True,
    )
    return PageSection(
        "radiation",
        "Radiation into the air",
        [Paragraph(radiation_finding(pairs, base, points, air_mass=air_mass)), table],
    )
