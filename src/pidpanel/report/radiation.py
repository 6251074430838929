"""What the air takes from the panel, beside what a damper takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pidpanel.report.html import Paragraph, Section, Table
from pidpanel.response.bands import reduction

SIDES = {"none": "no side", "one_side": "one side", "two_sides": "both sides"}
"""What the values of ``response.radiation`` are called on the page."""


def compared(summary: pd.DataFrame, radiation: pd.DataFrame) -> pd.DataFrame:
    """Each scenario with a response, as it stands and with the other radiation (``_beside``).

    Parameters
    ----------
    summary
        ``response/summary.csv`` with the points as text.
    radiation
        ``response/radiation.csv`` with the points as text.
    """
    good = summary[summary["status"] == "ok"]
    return good.merge(radiation, on=["reading", "scenario", "point"], suffixes=("", "_beside"))


def finding(both: pd.DataFrame, own: str, points: Sequence[str]) -> str:
    """How much the other radiation changes, against the best damper, and what that means.

    Parameters
    ----------
    both
        From `compared`.
    own
        ``response.radiation`` of the study.
    points
        Names of the response points, in the order wanted.
    """
    beside = str(both["radiation"].iloc[0])
    said = []
    for point in points:
        here = both[both["point"] == point]
        bare = here[here["patch"] == "none"].iloc[0]
        damped = here[here["patch"] != "none"]
        best = damped.sort_values("reduction_db").iloc[-1]
        air = float(reduction(bare["acceleration_rms_g"], bare["acceleration_rms_g_beside"]))
        said.append(
            f"at point {point} the bare panel goes from {bare['acceleration_rms_g']:.1f} to "
            f"{bare['acceleration_rms_g_beside']:.1f} g rms ({-air:+.1f} dB), and the best damper "
            f"({best['scenario']}) takes {best['reduction_db_beside']:.1f} dB in place of "
            f"{best['reduction_db']:.1f} dB"
        )
    damped = both[both["patch"] != "none"]
    less = float(np.mean(damped["reduction_db_beside"] < damped["reduction_db"]))
    verdict = (
        f"The gain of the damper is smaller so in {less:.0%} of the scenarios and points: computed "
        f"with radiation from {SIDES[own]} it is overstated."
        if less > 0.5
        else f"The gain of the damper is smaller so in {less:.0%} of the scenarios and points only."
    )
    return (
        f"Radiation from {SIDES[beside]} of a baffled panel, its added mass included, in place of "
        f"{SIDES[own]}: {'; '.join(said)}. {verdict}"
    )


def radiation_section(
    summary: pd.DataFrame,
    radiation: pd.DataFrame,
    own: str,
    points: Sequence[str],
    names: Mapping[str, str],
) -> Section:
    """The finding, and every scenario in both.

    Parameters
    ----------
    summary, radiation
        As of `compared`.
    own, points
        As of `finding`.
    names
        What each reading is called.
    """
    both = compared(summary, radiation)
    beside = SIDES[str(both["radiation"].iloc[0])]
    rows = [
        [
            names[str(row.reading)],
            str(row.scenario),
            str(row.point),
            f"{row.acceleration_rms_g:.3g}",
            f"{row.acceleration_rms_g_beside:.3g}",
            f"{row.reduction_db:.2f}",
            f"{row.reduction_db_beside:.2f}",
        ]
        for row in both.itertuples()
    ]
    columns = ["reading", "scenario", "point"]
    columns += [f"radiation from {side}: a rms, g" for side in (SIDES[own], beside)]
    columns += [f"{side}: reduction, dB" for side in (SIDES[own], beside)]
    table = Table(
        "Rms acceleration, and the reduction against the bare panel that radiates alike",
        columns,
        rows,
        folded=True,
    )
    return Section(
        "radiation", "Radiation into the air", [Paragraph(finding(both, own, points)), table]
    )
