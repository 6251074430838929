"""Figures of the coupon: sweeps, losses, what a varied key changes.

Functions return a `matplotlib.figure.Figure`; call them within `style.context`.
"""

import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pidpanel.arrays import Array
from pidpanel.coupon.window import CLOSURE_LIMIT
from pidpanel.report import layout, style, text


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
    law: Callable[[Array, float], Array] | None = None,
    bound: str | None = None,
) -> Figure:
    """Draw a quantity of the coupon over frequency or acceleration, one line per fill."""
    values = list(np.unique(cases[panel.column]))
    fills = sorted(cases["fill_fraction"].unique())
    figure, grid = layout.figure_of_axes(len(values), 3, 2.55, 0.5, sharex=True, sharey=True)
    ticks = np.unique(cases[x.column])
    for axes, value in zip(grid, values, strict=True):
        panel_cases = cases[cases[panel.column] == value]
        for fill, marker in zip(fills, itertools.cycle(style.MARKERS), strict=False):
            rows = panel_cases[panel_cases["fill_fraction"] == fill].sort_values(x.column)
            colour, places = style.fill_colour(fill), rows[x.column].to_numpy(float)
            axes.errorbar(
                places, rows[y.column], yerr=rows[y.error],
                color=colour, marker=marker, capsize=1.8, elinewidth=0.7, capthick=0.7,
            )  # fmt: skip
            if bound:
                axes.plot(places, rows[bound], color=colour, ls=":", lw=0.8)
            if law and len(rows):
                over_f = x is FREQUENCY
                fine = np.geomspace(ticks[0], ticks[-1], 60) if over_f else ticks[[0, -1]]
                damping = law(fine if over_f else np.full(2, value), fill)
                axes.plot(fine, damping, color=colour, ls="--", lw=0.8)
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
        handles["dashed: the paper's law, corrected"] = line(ls="--")
    if bound:
        handles["dotted: bound of an inelastic bed"] = line(ls=":")
    layout.add_legend(figure, 7, handles)
    return figure


CELLS_WITH_TEXT = 12  # most frequencies of a map whose values are written into it


def loss_factor_map(cases: pd.DataFrame) -> Figure:
    """Draw η over frequency and Γ, a map for each fill fraction.

    Several cases of a cell are averaged.
    """
    frequencies = np.unique(cases[FREQUENCY.column])
    amplitudes = np.unique(cases[ACCELERATION.column])
    fills = sorted(cases["fill_fraction"].unique())
    width = min(3, len(fills)) * min(3.0, 1.2 + 0.4 * len(frequencies)) + 1.0
    figure, grid = layout.figure_of_axes(
        len(fills), 3, 0.5 + 0.25 * len(amplitudes), 0.9, width, sharex=True, sharey=True
    )
    top = float(cases[LOSS_FACTOR.column].max())
    norm = Normalize(0.0, top)
    has_text = len(frequencies) <= CELLS_WITH_TEXT
    for axes, fill in zip(grid, fills, strict=True):
        table = cases[cases["fill_fraction"] == fill].pivot_table(
            index=ACCELERATION.column, columns=FREQUENCY.column, values=LOSS_FACTOR.column
        )
        values = table.reindex(index=amplitudes, columns=frequencies).to_numpy(float)
        look: dict[str, Any] = {"aspect": "auto", "origin": "lower", "interpolation": "nearest"}
        axes.imshow(values, cmap="viridis", norm=norm, **look)
        for row, column in np.argwhere(np.isfinite(values) & has_text):
            value = values[row, column]
            look = {"ha": "center", "va": "center", "fontsize": 5.5}
            look["color"] = "white" if value < 0.6 * top else "black"
            axes.text(column, row, text.number(value, 2), **look)
        axes.grid(False)
        axes.tick_params(length=2)
        axes.set_title(f"r = {fill:g}", loc="left")
        for axis, ticks in ((axes.xaxis, frequencies), (axes.yaxis, amplitudes)):
            places = layout.pick(np.arange(float(len(ticks))), CELLS_WITH_TEXT).astype(int)
            axis.set_ticks(places, [f"{value:g}" for value in ticks[places]])
        axes.tick_params(axis="x", rotation=90)
    figure.supxlabel(FREQUENCY.label, fontsize=8)
    figure.supylabel("acceleration amplitude Γ, –", fontsize=8)
    scale = ScalarMappable(norm, mpl.colormaps["viridis"])
    figure.colorbar(scale, ax=grid, label="η, –", pad=0.02, aspect=30)
    return figure


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


def losses_figure(cases: pd.DataFrame) -> Figure:
    """Draw where the energy goes and how well its balance closes, one marker per frequency."""
    balanced = cases[cases["closure"].notna()]
    figure, (left, right) = layout.figure_of_axes(2, 2, 3.1, 0.0)
    for number, (frequency, group) in enumerate(balanced.groupby(FREQUENCY.column)):
        look: dict[str, Any] = {
            "ls": "none",
            "marker": style.MARKERS[number % len(style.MARKERS)],
            "mfc": "none",
            "color": style.PLACES[number % len(style.PLACES)],
            "label": f"{frequency:g} Hz",
        }
        left.plot(group[ACCELERATION.column], 100 * group["normal_share"], **look)
        right.plot(group[ACCELERATION.column], 100 * group["closure"], **look)
    left.set(ylim=(0, 100), ylabel="normal loss, % of all losses")
    right.set_ylabel("error of the energy balance,\n% of the work done")
    right.axhspan(-100 * CLOSURE_LIMIT, 100 * CLOSURE_LIMIT, color="#dddddd", zorder=0, lw=0)
    right.axhline(0, color="#888888", lw=0.6)
    reach = max(2.5, 1.15 * 100 * float(balanced["closure"].abs().max() if len(balanced) else 0))
    right.set_ylim(-reach, reach)
    for axes in (left, right):
        layout.log_scale(axes, "x")
        _name_values(axes, np.unique(balanced[ACCELERATION.column]))
        axes.margins(x=0.1)
        axes.set_xlabel(ACCELERATION.label)
    layout.add_legend(figure, 6)
    return figure


def varied_figure(cases: pd.DataFrame, key: str, label: str) -> Figure:
    """Draw C_e over a varied key, one pair of axes per frequency, one line per fill and Γ."""
    frequencies = sorted(cases[FREQUENCY.column].unique())
    figure, grid = layout.figure_of_axes(len(frequencies), 4, 2.5, 0.5)
    values = list(dict.fromkeys(cases[key]))
    numeric = pd.api.types.is_numeric_dtype(cases[key])
    place = {value: value if numeric else float(i) for i, value in enumerate(values)}
    lines = cases.groupby(["fill_fraction", ACCELERATION.column])
    for number, ((fill, acceleration), line) in enumerate(lines):
        for axes, frequency in zip(grid, frequencies, strict=True):
            curve = line[line[FREQUENCY.column] == frequency]
            axes.errorbar(
                [place[value] for value in curve[key]], curve[EQUIVALENT_DAMPING.column],
                yerr=curve[EQUIVALENT_DAMPING.error],
                color=style.PLACES[number % len(style.PLACES)],
                marker=style.MARKERS[number % len(style.MARKERS)],
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
