"""Where the energy of the coupon goes, and how well its balance closes."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from pidpanel.coupon.window import CLOSURE_LIMIT
from pidpanel.report import style
from pidpanel.report.figures import FREQUENCY, LEVEL, WIDTH
from pidpanel.report.html import Picture


def losses_figure(cases: pd.DataFrame) -> Figure:
    """Where the energy goes and how well it closes, over the level, a marker a frequency."""
    known = cases[cases["closure"].notna()]
    figure = Figure(figsize=(WIDTH, 2.8))
    left, right = figure.subplots(1, 2)
    frequencies = sorted(known[FREQUENCY.column].unique())
    for number, frequency in enumerate(frequencies):
        one = known[known[FREQUENCY.column] == frequency]
        look = {
            "ls": "none",
            "marker": style.MARKERS[number % len(style.MARKERS)],
            "mfc": "none",
            "color": style.PLACES[number % len(style.PLACES)],
            "label": f"{frequency:g} Hz",
        }
        left.plot(one[LEVEL.column], 100 * one["normal_share"], **look)
        right.plot(one[LEVEL.column], 100 * one["closure"], **look)
    left.set_ylim(0, 100)
    left.set_ylabel("lost along the normal, % of all losses")
    right.set_ylabel("missing in the energy balance,\n% of the work put in")
    right.axhspan(-100 * CLOSURE_LIMIT, 100 * CLOSURE_LIMIT, color="#dddddd", zorder=0, lw=0)
    right.axhline(0, color="#888888", lw=0.6)
    reach = max(2.5, 1.15 * 100 * float(known["closure"].abs().max() if len(known) else 0))
    right.set_ylim(-reach, reach)
    for axes in (left, right):
        axes.set_xscale("log")
        levels = sorted(known[LEVEL.column].unique())
        axes.set_xticks(levels, [f"{level:g}" for level in levels])
        axes.set_xticks([], minor=True)
        axes.margins(x=0.1)
        axes.set_xlabel(LEVEL.label)
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    handles, names = left.get_legend_handles_labels()
    figure.legend(handles, names, loc="lower center", ncols=6)
    return figure


def losses_picture(cases: pd.DataFrame) -> Picture | None:
    """`losses_figure` with its caption; None where no run listed its contacts."""
    closure = cases["closure"].dropna()
    if closure.empty:
        return None
    return Picture(
        "losses",
        style.png(losses_figure(cases)),
        "Left: share of the energy that is lost along the normal of the contacts (damping of the "
        "Hertz contact); the rest is friction, the second integral of the paper's Eq. 3. Right: "
        "what is missing in the balance work = losses + change of kinetic, elastic and potential "
        f"energy, worst of the seeds; median {closure.abs().median():.2%}, largest "
        f"{closure.abs().max():.2%}; grey: the {CLOSURE_LIMIT:.0%} within which a run counts. "
        "The forces listed are evaluated with the velocity at the end of the step and miss about "
        "1 % at a fifth of the Rayleigh time, the less the shorter the step.",
    )
