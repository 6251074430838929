"""Figures of responses: PSDs, the damping behind them; reductions in third octaves as tables.

Functions return a `matplotlib.figure.Figure` that belongs to no window; call them within
`style.context`.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import ticker
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pidpanel.arrays import Array
from pidpanel.report import style
from pidpanel.report.html import Chart, ColourTable, Picture
from pidpanel.report.layout import (
    DASHES,
    LINES,
    WIDTH,
    add_legend,
    draw_curve,
    figure_of_axes,
    frequency_axis,
    log_scale,
)
from pidpanel.report.text import nominal, plain

DECADES = 9  # decades of PSD shown below the highest peak at most: a node has no lower end


ACROSS = 2  # axes side by side at most: more of them leave no room for titles and numbers

# Width of the uppermost of several curves, that of the widest, and what each below adds [pt].
WIDTHS = (0.9, 3.3, 0.6)


def nested_width(index: int, count: int) -> float:
    """Return the width of a curve among several drawn one over the other, the widest first [pt].

    If curves coincide, each is then visible next to the one over it.

    Examples
    --------
    >>> [nested_width(i, 3) for i in range(3)]
    [2.1, 1.5, 0.9]
    """
    last, widest, step = WIDTHS
    return round(last + min(step, (widest - last) / max(count - 1, 1)) * (count - 1 - index), 3)


def _legend(figure: Figure, charts: Sequence[Chart]) -> None:
    """Add one legend below all axes, with the meaning of dashes where there are any."""
    handles: dict[str, Line2D] = {}
    dashed = False
    for chart in charts:
        for curve in chart.curves:
            line = Line2D([], [], color=curve.colour, lw=1.6, ls=LINES[curve.line])
            handles.setdefault(curve.label, line)
            dashed |= curve.inside is not None and not bool(curve.inside.all())
    if dashed:
        handles["dashed: Cₑ outside the range of its data"] = Line2D(
            [], [], color="#777777", lw=1.2, ls=DASHES
        )
    add_legend(figure, min(5, max(1, int(figure.get_figwidth() / 1.9))), handles)


def charts_figure(
    charts: Sequence[Chart], *, across: int = ACROSS, width: float = WIDTH, height: float = 4.4
) -> Figure:
    """Draw charts in rows, those of one unit on one scale, with one legend below."""
    figure, grid = figure_of_axes(len(charts), across, height, 0.0, width)
    for axes, chart in zip(grid, charts, strict=True):
        for curve in chart.curves:
            draw_curve(axes, chart.frequency, curve)
        frequency_axis(axes, chart.frequency[0], chart.frequency[-1])
        if chart.is_log:
            _decades(axes, [c.values for each in charts if each.unit == chart.unit
                            for c in each.curves])  # fmt: skip
        if chart.title:
            axes.set_title(f"{chart.title}\n", loc="left", fontweight="bold")
            note = axes.text(0.0, 1.012, chart.note, va="bottom", transform=axes.transAxes)
            note.set(fontsize=7, color="#444444")
        axes.set_ylabel(chart.unit)
    _legend(figure, charts)
    return figure


def _decades(axes: Axes, curves: Sequence[Array]) -> None:
    """Make y a logarithmic axis that shows curves, but at most `DECADES` of them."""
    log_scale(axes)
    axes.yaxis.set_minor_locator(ticker.NullLocator())  # too many over the decades
    axes.yaxis.set_major_locator(ticker.LogLocator(numticks=DECADES + 2))
    values = np.concatenate(curves)
    drawn = values[np.isfinite(values) & (values > 0)]
    if drawn.size:
        axes.set_ylim(max(drawn.min() / 2, drawn.max() * 10.0**-DECADES), drawn.max() * 2)


def psd_unit(point: str) -> str:
    """Return quantity and unit of the PSD of a point."""
    return f"PSD at point {point}, g²/Hz"


def chart_picture(
    name: str, charts: Sequence[Chart], caption: str = "", *, has_svg: bool = False, **size: Any
) -> Picture:
    """Return charts with their figure, whose sizes [inch] are those of `charts_figure`."""
    drawing = style.Drawing(charts_figure, charts, **size)
    vector = (
        style.Drawing(charts_figure, [c.thinned() for c in charts], **size) if has_svg else None
    )
    return Picture(name, drawing, caption, charts, vector=vector)


def colour_table(
    title: str,
    columns: Sequence[str],
    rows: Sequence[str],
    values: Array,
    colours: ScalarMappable,
    text: Callable[[float], str],
) -> ColourTable:
    """Return values (n_rows, n_columns) as texts on colours, white for NaN."""
    shades = colours.to_rgba(np.nan_to_num(values))[..., :3]
    shades[np.isnan(values)] = 1.0
    # white has a contrast above 4.5 on what is darker (WCAG 2)
    dark = np.where(shades > 0.04, ((shades + 0.055) / 1.055) ** 2.4, shades / 12.92)
    is_dark = dark @ [0.2126, 0.7152, 0.0722] < 0.179
    cells = [
        [(text(v), to_hex(s), bool(d)) for v, s, d in zip(*row, strict=True)]
        for row in zip(values.tolist(), shades, is_dark, strict=True)
    ]
    return ColourTable(title, columns, rows, cells)


def reduction_tables(
    centre: Array, rows: Sequence[str], gained: Mapping[tuple[str, str], Array], row_name: str
) -> list[ColourTable]:
    """Return third-octave reductions (n_rows, n_bands) [dB] as tables by point and model."""
    limit = max(1.0, max(float(np.abs(values).max()) for values in gained.values()))
    colours = ScalarMappable(Normalize(-limit, limit), "RdBu")
    bands = [f"{row_name} / Hz", *map(nominal, centre)]
    return [
        colour_table(
            " · ".join(filter(None, (f"point {point}", model))), bands, rows, dB, colours, _short
        )
        for (point, model), dB in gained.items()
    ]


def _short(value: float) -> str:
    """Return a number of two digits, zero without a sign."""
    text = plain(value, 1 if abs(value) < 9.95 else 0)
    return "0" if text == "0.0" else text
