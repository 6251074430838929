"""Figures of verification: computed points beside their closed forms.

Call the functions within `style.context`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib import ticker
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pidpanel.damping import inelastic
from pidpanel.report import style
from pidpanel.report.layout import GREY
from pidpanel.verification.rows import Row


def _resolutions(rows: Sequence[Row]) -> list[float]:
    return sorted({row.resolution for row in rows})


def differences(rows: Sequence[Row]) -> dict[float, list[float]]:
    """Return |computed − reference| by resolution, over the points that have a tolerance."""
    x = {row.at for row in rows if row.held}
    return {
        size: [abs(r.computed - r.reference) for r in rows if r.resolution == size and r.at in x]
        for size in _resolutions(rows)
    }


def spheres_text(count: float) -> str:
    """Return a number of spheres in words."""
    return f"{count:g} sphere" + "s" * (count != 1)


def collision_figure(rows: Sequence[Row]) -> Figure:
    """Draw the error of the loss against the time step, one line per restitution."""
    figure = Figure(figsize=(6.2, 3.6), layout="constrained")
    axes = figure.subplots()
    for i, restitution in enumerate(sorted({row.at for row in rows if row.reference})):
        points = sorted((r.resolution, abs(r.error)) for r in rows if r.at == restitution)
        axes.loglog(
            *zip(*points, strict=True),
            color=style.PLACES[i],
            marker=style.MARKERS[i],
            label=f"e = {restitution:g}",
        )
    steps = np.array(_resolutions(rows))[[0, -1]]
    axes.loglog(steps, 0.08 * steps, color=GREY, ls=":", label="first order")
    for row in rows:
        if row.held and row.reference:
            axes.plot(row.resolution, row.tolerance, color="black", marker="_", ms=14, mew=1.5)
            axes.annotate(
                "tolerance",
                (row.resolution, row.tolerance),
                (-9, 4),
                textcoords="offset points",
                ha="right",
                fontsize=7.5,
            )
            break
    axes.xaxis.set_major_locator(ticker.FixedLocator(_resolutions(rows)))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(ticker.NullLocator())
    axes.set_xlabel("time step over Rayleigh time, –")
    axes.set_ylabel("|error| of the energy lost, worst of 8, –")
    axes.legend()
    return figure


def curve_figure(
    rows: Sequence[Row],
    truth: Callable[[float], float],
    limits: tuple[float, float],
    label: str,
) -> Figure:
    """Draw closed form and computed points, and their difference over the number of spheres."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1))
    x = np.linspace(*limits, 600)
    left.plot(
        x, [truth(value) for value in x], color=style.BARE, lw=1.3, label="closed form, e = 0"
    )
    for i, size in enumerate(_resolutions(rows)):
        members = [row for row in rows if row.resolution == size]
        left.plot(
            [row.at for row in members],
            [row.computed for row in members],
            ls="none",
            marker=style.MARKERS[i],
            ms=5.5,
            color=style.PLACES[i],
            mfc=style.PLACES[i] if size == _resolutions(rows)[-1] else "white",
            label=f"LIGGGHTS, {spheres_text(size)}",
        )
    compared = [row.at for row in rows if row.held]
    uncompared = [row.at for row in rows if row.at > max(compared)]
    if uncompared:
        left.axvspan(0.5 * (max(compared) + min(uncompared)), limits[1], color="#eeeeee", lw=0)
        left.annotate(
            "shown without tolerance", (limits[1], 0.02), (-3, 0),
            xycoords=("data", "axes fraction"), textcoords="offset points", ha="right",
            fontsize=7, color=GREY,
        )  # fmt: skip
    left.set_xlabel(label)
    left.set_ylabel("energy per cycle / $m A^2 \\omega^2$, –")
    left.set_xlim(*limits)
    left.set_ylim(bottom=0)
    left.legend(loc="upper left")
    _difference_axes(right, rows)
    return figure


def _difference_axes(axes: Axes, rows: Sequence[Row]) -> None:
    errors = differences(rows)
    axes.loglog(
        list(errors),
        [float(np.mean(values)) for values in errors.values()],
        color=style.BARE,
        marker="o",
        ms=5,
    )
    axes.xaxis.set_major_locator(ticker.FixedLocator(list(errors)))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(ticker.NullLocator())
    axes.set_xlabel("number of spheres, –")
    axes.set_ylabel("mean |difference| / $m A^2 \\omega^2$, –")


def slug_figure(rows: Sequence[Row]) -> Figure:
    """Draw the energy per cycle against the clear gap."""
    return curve_figure(
        rows,
        inelastic.slug_energy,
        (0.05, inelastic.LONGEST_GAP),
        "clear gap over amplitude, L/A, –",
    )


def floor_figure(rows: Sequence[Row]) -> Figure:
    """Draw the energy per cycle against the acceleration."""
    return curve_figure(
        rows,
        inelastic.floor_energy,
        (0.8, inelastic.LARGEST_GAMMA),
        "acceleration amplitude over gravity, Γ, –",
    )
