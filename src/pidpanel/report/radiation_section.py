"""Radiation on the page: what the air takes from the panel, beside what a damper takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pidpanel.report.html import PageSection, Paragraph, Table
from pidpanel.report.text import READINGS, number, percent, records, signed
from pidpanel.solve.bands import reduction

SIDES = {
    "none": "no radiation",
    "one_side": "radiation from one side",
    "two_sides": "radiation from both sides",
}
"""Names of the values of ``response.radiation``."""


def compared(summary: pd.DataFrame, radiation: pd.DataFrame) -> pd.DataFrame:
    """Return each scenario with a response under both radiations, the other one ``_beside``.

    Parameters
    ----------
    summary
        ``response/summary.csv`` (points as text).
    radiation
        ``response/radiation.csv`` (points as text).
    """
    good = summary[summary["status"] == "ok"]
    return good.merge(radiation, on=["reading", "scenario", "point"], suffixes=("", "_beside"))


def radiation_finding(
    both: pd.DataFrame, own: str, points: Sequence[str], *, air_mass: bool = True
) -> str:
    """Return how much the other radiation changes, beside the best damper, and what that means.

    Parameters
    ----------
    both
        From `compared`.
    own
        ``response.radiation`` of the study.
    points
        Names of the response points in order.
    air_mass
        ``response.air_mass`` of the study.
    """
    beside = str(both["radiation"].iloc[0])
    said = []
    for point in [one for one in points if one in set(both["point"])]:
        here = both[both["point"] == point]
        bare = here[here["patch"] == "none"].iloc[0]
        damped = here[here["patch"] != "none"]
        air = float(reduction(bare["acceleration_rms_g"], bare["acceleration_rms_g_beside"]))
        said.append(
            f"at point {point} the bare panel goes from {bare['acceleration_rms_g']:.1f} to "
            f"{bare['acceleration_rms_g_beside']:.1f} g rms ({signed(-air, 1)} dB)"
        )
        if len(damped):
            best = damped.sort_values("reduction_db").iloc[-1]
            said[-1] += (
                f", and the largest reduction ({best['scenario']}) is "
                f"{best['reduction_db_beside']:.1f} dB instead of {best['reduction_db']:.1f} dB"
            )
    carried = "added mass included" if air_mass else "resistance without added mass"
    instead = (
        f"With {SIDES[beside]} of a baffled panel ({carried}) instead of {SIDES[own]}: "
        f"{'; '.join(said)}."
    )
    damped = both[both["patch"] != "none"]
    if not len(damped):
        return instead
    less = float(np.mean(damped["reduction_db_beside"] < damped["reduction_db"]))
    verdict = f"The reduction is then smaller in {percent(less)} of the scenarios and points"
    verdict += f": computed with {SIDES[own]}, it is overestimated." if less > 0.5 else " only."
    return f"{instead} {verdict}"


def radiation_section(
    summary: pd.DataFrame,
    radiation: pd.DataFrame,
    own: str,
    points: Sequence[str],
    *,
    air_mass: bool = True,
) -> PageSection:
    """Return the finding, and every scenario under both radiations.

    Parameters
    ----------
    summary, radiation
        As of `compared`.
    own, points, air_mass
        As of `radiation_finding`.
    """
    both = compared(summary, radiation)
    sides = (SIDES[own], SIDES[str(both["radiation"].iloc[0])])
    rows = [
        [
            READINGS[row["reading"]],
            row["scenario"],
            row["point"],
            number(row["acceleration_rms_g"]),
            number(row["acceleration_rms_g_beside"]),
            f"{row['reduction_db']:.2f}",
            f"{row['reduction_db_beside']:.2f}",
        ]
        for row in records(both)
    ]
    columns = ["damping model", "scenario", "point"]
    columns += [f"{side}: g rms" for side in sides]
    columns += [f"{side}: reduction, dB" for side in sides]
    table = Table(
        "Rms acceleration, and reduction against the bare panel with the same radiation",
        columns,
        rows,
        folded=True,
    )
    return PageSection(
        "radiation",
        "Radiation into the air",
        [Paragraph(radiation_finding(both, own, points, air_mass=air_mass)), table],
    )
