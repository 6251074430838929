"""Figures of verification: computed points beside their closed forms.

Call the functions within `style.context`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure

from pidpanel.damping import inelastic
from pidpanel.report import style
from pidpanel.report.layout import GREY
from pidpanel.verification.rows import Row


def _resolutions(rows: Sequence[Row]) -> list[float]:
    return sorted({row.resolution for row in rows})


def differences(rows: Sequence[Row]) -> dict[float, list[float]]:
    """Return |computed − reference| by resolution, over the points that have a tolerance."""
    x = {row.at for row in rows if row.has_tolerance}
    return {
        size: [abs(r.computed - r.reference) for r in rows if r.resolution == size and r.at in x]
        for size in _resolutions(rows)
    }


def spheres_text(count: float) -> str:
    """Return a number of spheres in words."""
    return f"{count:g} sphere" + "s" * (count != 1)


def curve_figure(
    rows: Sequence[Row],
    closed_form: Callable[[float], float],
    limits: tuple[float, float],
    label: str,
) -> Figure:
    """Draw the closed form and the computed points of each number of spheres."""
    figure = Figure(figsize=(6.2, 3.8), layout="constrained")
    axes = figure.subplots()
    x = np.linspace(*limits, 600)
    axes.plot(
        x, [closed_form(value) for value in x], color=style.BARE, lw=1.3, label="closed form, e = 0"
    )
    for i, size in enumerate(_resolutions(rows)):
        members = [row for row in rows if row.resolution == size]
        axes.plot(
            [row.at for row in members],
            [row.computed for row in members],
            ls="none",
            marker=style.MARKERS[i],
            ms=5.5,
            color=style.PLACES[i],
            mfc=style.PLACES[i] if size == _resolutions(rows)[-1] else "white",
            label=f"LIGGGHTS, {spheres_text(size)}",
        )
    compared = [row.at for row in rows if row.has_tolerance]
    uncompared = [row.at for row in rows if row.at > max(compared)]
    if uncompared:
        axes.axvspan(0.5 * (max(compared) + min(uncompared)), limits[1], color="#eeeeee", lw=0)
        axes.annotate(
            "shown without tolerance", (limits[1], 0.02), (-3, 0),
            xycoords=("data", "axes fraction"), textcoords="offset points", ha="right",
            fontsize=7, color=GREY,
        )  # fmt: skip
    axes.set_xlabel(label)
    axes.set_ylabel("energy per cycle / $m A^2 \\omega^2$, –")
    axes.set_xlim(*limits)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return figure


def slug_figure(rows: Sequence[Row]) -> Figure:
    """Draw the energy per cycle against the clear gap."""
    limits = (0.05, inelastic.LONGEST_GAP)
    return curve_figure(rows, inelastic.slug_energy, limits, "clear gap over amplitude, L/A, –")


def floor_figure(rows: Sequence[Row]) -> Figure:
    """Draw the energy per cycle against the acceleration."""
    limits = (0.8, inelastic.LARGEST_GAMMA)
    label = "acceleration amplitude over gravity, Γ, –"
    return curve_figure(rows, inelastic.floor_energy, limits, label)
