"""Figures of the coupon: sweeps, losses, what a varied key changes.

Functions return a `matplotlib.figure.Figure`; call them within `style.context`.
"""

import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.damping.surface import DampingSurface
from pidpanel.report import layout, style
from pidpanel.report.html import ColourTable
from pidpanel.report.response_figures import colour_table
from pidpanel.report.text import number


class Law(NamedTuple):
    """A law of C_e that is drawn with cases."""

    name: str
    damping: Callable[[Array, float, float], Array]  # [N s/m³] of f [Hz], r and Γ


class AxisQuantity(NamedTuple):
    """A column of ``coupon/cases.csv`` as an axis."""

    column: str
    label: str  # name and unit
    log: bool
    error: str = ""  # column of its standard error
    symbol: str = ""  # in titles


EQUIVALENT_DAMPING = AxisQuantity(
    "equivalent_damping_n_s_m3", "Cₑ, N s/m³", True, "equivalent_damping_error_n_s_m3"
)
LOSS_FACTOR = AxisQuantity("loss_factor", "loss factor η, –", True, "loss_factor_error")
MASS_SHARE = AxisQuantity("apparent_mass_share", "mₐ / mass of the particles, –", False,
                      "apparent_mass_share_error")  # fmt: skip
FREQUENCY = AxisQuantity("frequency_hz", "frequency, Hz", True, symbol="f")
ACCELERATION = AxisQuantity("acceleration_g", "acceleration amplitude Γ, –", True, symbol="Γ")

FINE = 61  # points of a surface or law along an axis

FEW_TICKS = 6  # most values of a sweep for a tick at each


def _name_values(axes: Axes, values: Sequence[float] | Array) -> None:
    """Give x a tick at each of some values, and no others."""
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.set_xticks([], minor=True)


def sweep_figure(
    cases: pd.DataFrame,
    x: AxisQuantity,
    y: AxisQuantity,
    panel: AxisQuantity,
    *,
    law: Law | None = None,
    bound: str | None = None,
    surface: DampingSurface | None = None,
) -> Figure:
    """Draw a quantity of the coupon over frequency or acceleration, one line per fill.

    Over frequency with the law, and with the surface of C_e in place of lines between the cases.
    """
    values = list(np.unique(cases[panel.column]))
    fills = sorted(cases["fill_fraction"].unique())
    figure, grid = layout.figure_of_axes(len(values), 3, 2.55, 0.5, sharex=True, sharey=True)
    ticks = np.unique(cases[x.column])
    fine = np.geomspace(ticks[0], ticks[-1], FINE)
    law = law if x is FREQUENCY else None
    for axes, value in zip(grid, values, strict=True):
        panel_cases = cases[cases[panel.column] == value]
        for fill, marker in zip(fills, itertools.cycle(style.MARKERS), strict=False):
            rows = panel_cases[panel_cases["fill_fraction"] == fill].sort_values(x.column)
            colour, places = style.fill_colour(fill), rows[x.column].to_numpy(float)
            axes.errorbar(
                places, rows[y.column], yerr=rows[y.error],
                color=colour, marker=marker, capsize=1.8, elinewidth=0.7, capthick=0.7,
                ls="-" if surface is None else "none",
            )  # fmt: skip
            if surface is not None:
                points = (np.full(FINE, value), fine) if x is ACCELERATION else (fine, value)
                _draw_surface(axes, surface, fine, (fill, *points), colour)
            if bound:
                axes.plot(places, rows[bound], color=colour, ls=":", lw=0.8)
            if law and len(rows):
                fitted = law.damping(fine, fill, float(value))
                axes.plot(fine, fitted, color=colour, ls="--", lw=0.8)
        axes.set_title(_constant(panel, value), loc="left")
        layout.log_scale(axes, "xy" if y.log else "x")
        if not y.log:
            axes.axhline(0, color="#888888", lw=0.6)
        if x is FREQUENCY:
            layout.frequency_axis(axes, ticks[0] / 1.25, ticks[-1] * 1.25)
        else:
            axes.set_xlim(ticks[0] / 1.25, ticks[-1] * 1.25)
            if len(ticks) <= FEW_TICKS:
                _name_values(axes, ticks)
        axes.set(xlabel=x.label, ylabel=y.label)
        axes.tick_params(labelleft=True)
    handles = layout.fill_handles(fills)
    line = partial(Line2D, [], [], color=layout.GREY, lw=0.8)
    if law:
        handles[f"dashed: {law.name}"] = line(ls="--")
    if surface is not None:
        handles["surface ± standard error"] = Patch(color=layout.GREY, alpha=0.35)
    if bound:
        handles["dotted: bound of an inelastic bed"] = line(ls=":")
    layout.add_legend(figure, 7, handles)
    return figure


def _draw_surface(
    axes: Axes, surface: DampingSurface, x: Array, points: Sequence[ArrayLike], colour: str
) -> None:
    """Draw C_e with its standard error over x at points of r, f and Γ, within its range."""
    damping = surface.evaluate(*np.broadcast_arrays(*points))
    mean = np.where(damping.inside, damping.equivalent_damping, np.nan)
    factor = np.exp(damping.equivalent_damping_error / mean)
    axes.plot(x, mean, color=colour)
    axes.fill_between(x, mean / factor, mean * factor, color=colour, alpha=0.22, lw=0)


def loss_factor_tables(cases: pd.DataFrame) -> list[ColourTable]:
    """Return η over frequency and Γ, a table for each fill fraction; the mean of several cases."""
    colours = ScalarMappable(Normalize(0.0, float(cases[LOSS_FACTOR.column].max())), "viridis")
    tables = []
    for fill, rows in cases.groupby("fill_fraction"):
        table = rows.pivot_table(LOSS_FACTOR.column, ACCELERATION.column, FREQUENCY.column)
        heads, names = ([f"{value:g}" for value in axis] for axis in (table.columns, table.index))
        columns = ["Γ / Hz", *heads]
        values = table.to_numpy(float)
        tables.append(colour_table(f"r = {fill:g}", columns, names, values, colours, number))
    return tables


def design_figure(cases: pd.DataFrame, varied: Sequence[str]) -> Figure:
    """Draw η over each column of numbers that a table of cases varies, a point for each case."""
    columns = {quantity.column: quantity.label for quantity in (FREQUENCY, ACCELERATION)}
    columns = {"fill_fraction": "fill fraction r, –", **columns}
    columns |= {key: key for key in varied if pd.api.types.is_numeric_dtype(cases[key])}
    figure, grid = layout.figure_of_axes(len(columns), 3, 2.2, 0.1, sharey=True)
    for axes, (column, label) in zip(grid, columns.items(), strict=True):
        values = cases[column]
        axes.plot(values, cases[LOSS_FACTOR.column], ".", ms=3, color=style.PLACES[0], alpha=0.6)
        is_wide = values.min() > 0 and values.max() > 8 * values.min()
        layout.log_scale(axes, "xy" if is_wide else "y")
        axes.set(xlabel=label, ylabel=LOSS_FACTOR.label)
    return figure


def _constant(quantity: AxisQuantity, value: float) -> str:
    unit = quantity.label.rsplit(", ", 1)[-1]
    return f"{quantity.symbol} = {value:g}" + (f" {unit}" if unit != "–" else "")


def varied_figure(cases: pd.DataFrame, key: str, label: str) -> Figure:
    """Draw C_e over a varied key, one pair of axes per frequency, one line per fill and Γ."""
    frequencies = sorted(cases[FREQUENCY.column].unique())
    figure, grid = layout.figure_of_axes(len(frequencies), 4, 2.5, 0.5)
    values = list(dict.fromkeys(cases[key]))
    numeric = pd.api.types.is_numeric_dtype(cases[key])
    place = {value: value if numeric else float(i) for i, value in enumerate(values)}
    lines = cases.groupby(["fill_fraction", ACCELERATION.column])
    for rank, ((fill, acceleration), line) in enumerate(lines):
        for axes, frequency in zip(grid, frequencies, strict=True):
            curve = line[line[FREQUENCY.column] == frequency]
            axes.errorbar(
                [place[value] for value in curve[key]], curve[EQUIVALENT_DAMPING.column],
                yerr=curve[EQUIVALENT_DAMPING.error],
                color=style.PLACES[rank % len(style.PLACES)],
                marker=style.MARKERS[rank % len(style.MARKERS)],
                ls="-" if numeric else "none", capsize=2,
                label=f"r = {fill:g}, Γ = {acceleration:g}",
            )  # fmt: skip
    for axes, frequency in zip(grid, frequencies, strict=True):
        axes.set_title(f"f = {frequency:g} Hz", loc="left")
        is_wide = numeric and min(values) > 0 and max(values) > 8 * min(values)
        layout.log_scale(axes, "xy" if is_wide else "y")
        axes.set_xlabel(label)
        if numeric:
            _name_values(axes, values)
        else:
            axes.set_xticks(list(place.values()), [str(value) for value in values])
            axes.margins(x=0.25)
    grid[0].set_ylabel(EQUIVALENT_DAMPING.label)
    layout.add_legend(figure, 4)
    return figure
