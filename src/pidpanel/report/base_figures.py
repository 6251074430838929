"""Figures of base motion: curves over frequency, drawn from the charts of the page."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pidpanel.report.html import Chart
from pidpanel.report.layout import LINES, WIDTH, draw_curve, frequency_axis

DECADES = 7  # decades shown below the highest value at most


def charts_figure(charts: Sequence[Chart], height: float = 3.9) -> Figure:
    """Draw charts side by side on logarithmic axes, with one legend below."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    grid = figure.subplots(1, len(charts), squeeze=False)[0]
    handles: dict[str, Line2D] = {}
    for axes, chart in zip(grid, charts, strict=True):
        _draw(axes, chart)
        for curve in chart.curves:
            line = Line2D([], [], color=curve.colour, lw=1.6, ls=LINES[curve.line])
            handles.setdefault(curve.label, line)
    columns = min(4, len(handles))
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=columns)
    return figure


def _draw(axes: Axes, chart: Chart) -> None:
    for order, curve in enumerate(reversed(chart.curves)):
        positive = np.where(curve.values > 0, curve.values, np.nan)
        draw_curve(axes, chart.frequency, replace(curve, values=positive), 2 + order)
    axes.set_yscale("log")
    top = max(np.nanmax(curve.values) for curve in chart.curves)
    bottom = min(np.nanmin(curve.values[curve.values > 0]) for curve in chart.curves)
    axes.set_ylim(max(bottom / 2, top * 10.0**-DECADES), 2 * top)
    axes.set_ylabel(chart.unit)
    axes.set_title(chart.title, loc="left", fontweight="bold")
    frequency_axis(axes, chart.frequency[0], chart.frequency[-1])
