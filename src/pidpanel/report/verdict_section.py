"""Validity of the damping models: each one compared with the coupled runs."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from pidpanel.report import style
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.layout import add_legend, figure_of_axes
from pidpanel.report.text import records
from pidpanel.report.verdict_files import (
    BAND_DEPTH,
    BAND_LIMIT,
    BARE,
    DEAD_WEIGHT,
    RMS_LIMIT,
    combined,
)

DASHED = {BARE: "#555555", DEAD_WEIGHT: "#999999"}  # curves that are no damping model, in grey

NAMES = {BARE: "Bare panel", DEAD_WEIGHT: "The same mass as dead weight"}

WORDS = {"yes": "holds", "no": "does not hold", "open": "open"}


def worst(verdict: pd.DataFrame) -> pd.DataFrame:
    """Return the worst result over the points, for each damping model and scenario."""
    rows = []
    for _, group in verdict.groupby(["damper", "scenario"], sort=False):
        band = group.iloc[int(group["band_difference_db"].abs().to_numpy().argmax())]
        rms = group.iloc[int(group["difference"].abs().to_numpy().argmax())]
        terms = {"difference": rms["difference"], "rms_error": rms["coupled_g_rms_relative_error"]}
        rows.append({**dict(band), **terms, "holds": combined(set(group["holds"]))})
    return pd.DataFrame(rows)


def _counts(summary: pd.DataFrame, titles: Mapping[str, str]) -> list[dict[str, Any]]:
    """Return in how many scenarios each damping model holds, does not hold or is open."""
    models = summary[~summary["damper"].isin(NAMES)]
    return [
        {
            "name": titles[str(damper)],
            **{holds: int((rows["holds"] == holds).sum()) for holds in WORDS},
        }
        for damper, rows in models.groupby("damper", sort=False)
    ]


def level_figure(verdict: pd.DataFrame, points: Sequence[str], titles: Mapping[str, str]) -> Figure:
    """Draw g rms over that of the coupled run against the level, a panel a point."""
    figure, panels = figure_of_axes(len(points), len(points), 3.2, 0.0, sharey=True)
    dampers = [name for name in verdict["damper"].unique() if name not in DASHED]
    for axes, point in zip(panels, points, strict=True):
        rows = verdict[verdict["point"] == point]
        axes.axhspan(-100 * RMS_LIMIT, 100 * RMS_LIMIT, color="#eeeeee", lw=0, zorder=0)
        for damper in rows["damper"].unique():
            curve = rows[rows["damper"] == damper].sort_values("oaspl_db")
            colour = DASHED.get(damper) or style.place_colour(damper, dampers)
            # several scenarios of a level differ in more than it: no line joins them
            joined = "--" if damper in DASHED else "-"
            line = "none" if curve["oaspl_db"].duplicated().any() else joined
            values = curve["oaspl_db"], 100 * curve["difference"]
            axes.plot(*values, ls=line, color=colour, marker="o", ms=3, label=titles[damper])
        run = rows.drop_duplicates("scenario").sort_values("oaspl_db")
        axes.errorbar(
            run["oaspl_db"], 0 * run["oaspl_db"], 200 * run["coupled_g_rms_relative_error"],
            color=style.BARE, capsize=2.5, lw=1.1, label="Coupled run, ± two standard errors",
        )  # fmt: skip
        axes.set_title(f"point {point}", loc="left", fontweight="bold")
        axes.set_xlabel("OASPL, dB re 20 µPa")
    panels[0].set_ylabel("g rms over the coupled run, %")
    add_legend(figure, 3)
    return figure


def verdict_section(
    verdict: pd.DataFrame, points: Sequence[str], dampers: Mapping[str, str]
) -> PageSection:
    """Return the finding, the figure over several levels, the table.

    ``dampers`` are the titles of damping models by damper.
    """
    summary, titles = worst(verdict), {**dampers, **NAMES}
    rows = [
        {"name": titles[str(damper)], "cells": {row["scenario"]: row for row in records(group)}}
        for damper, group in summary.groupby("damper", sort=False)
    ]
    values = {
        "rms_limit": RMS_LIMIT,
        "band_limit": BAND_LIMIT,
        "depth": BAND_DEPTH,
        "models": _counts(summary, titles),
        "scenarios": list(summary["scenario"].unique()),
        "rows": rows,
        "words": WORDS,
        "levels": None,
    }
    if summary["oaspl_db"].nunique() > 1:
        values["levels"] = figure_picture("verdict_level", level_figure, verdict, points, titles)
    return template_section("verdict.html", "Which damping model holds", values)
