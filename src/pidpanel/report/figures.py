"""Figures of arrays and frames: every axis with its unit, every line in the legend.

Functions return a `matplotlib.figure.Figure` that belongs to no window; call them within
`style.context`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib import ticker
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from pidpanel.arrays import Array, Flags, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.supports import boundary_edges
from pidpanel.report import style

WIDTH = 10.0
"""Inches of a figure that fills the page."""

DECADES = 9
"""At most so many decades of PSD are shown below the highest peak: nodes have none at all."""


@dataclass(frozen=True)
class Curve:
    """One line of a response figure.

    Attributes
    ----------
    label
        For the legend.
    values
        (nf,), unit of the axis.
    colour
        Of the line.
    inside
        (nf,) False where the damping behind it is a continuation past the run points: drawn
        dashed there; None where it knows no run points.
    width
        Of the line, points.
    log_error
        (nf,) standard error of ln of the values, drawn as a band; None where there is none.
    """

    label: str
    values: Array
    colour: str
    inside: Flags | None = None
    width: float = 0.9
    log_error: Array | None = None


@dataclass(frozen=True)
class Panel:
    """One of the axes side by side: a title, a note under it, and its curves."""

    title: str
    note: str
    curves: Sequence[Curve]


def _place(
    figure: Figure, rows: int, columns: int, *, top: float, across: float, down: float = 0.0
) -> None:
    """Room for labels, notes and the legend in inches; a layout engine takes as long as drawing.

    ``top`` is the room above the axes, ``across`` and ``down`` that between them.
    """
    width, height = figure.get_size_inches()
    left, right, bottom = 0.72, 0.22, 0.8
    each_width = (width - left - right - (columns - 1) * across) / columns
    each_height = (height - top - bottom - (rows - 1) * down) / rows
    figure.subplots_adjust(
        left=left / width,
        right=1 - right / width,
        bottom=bottom / height,
        top=1 - top / height,
        wspace=across / each_width,
        hspace=down / each_height,
    )


def _legend_below(figure: Figure, handles: Mapping[str, Line2D]) -> None:
    figure.legend(
        list(handles.values()),
        list(handles),
        loc="lower center",
        bbox_to_anchor=(0.5, 0.05 / figure.get_size_inches()[1]),
        ncols=min(7, len(handles)),
    )


def _frequency_axis(axes: Axes, low: float, high: float) -> None:
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    steps = (1, 2, 5) if high > 8 * low else (1, 1.5, 2, 3, 4, 5, 7)
    ticks = [
        decade * step
        for decade in (1, 10, 100, 1000, 10000)
        for step in steps
        if low * 0.999 <= decade * step <= high * 1.001
    ]
    axes.xaxis.set_major_locator(ticker.FixedLocator(ticks))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(ticker.NullFormatter())
    axes.set_xlabel("frequency, Hz")


def _draw(axes: Axes, x: Array, curve: Curve) -> None:
    """The curve, solid on run points and dashed past them, in its band."""
    if curve.log_error is not None:
        factor = np.exp(curve.log_error)
        axes.fill_between(
            x, curve.values / factor, curve.values * factor, color=curve.colour, alpha=0.18, lw=0
        )
    if curve.inside is None or curve.inside.all():
        axes.plot(x, curve.values, color=curve.colour, lw=curve.width, label=curve.label)
        return
    outside = ~curve.inside
    # the lines next to the dashed part belong to it too, or a gap would be left
    touching = outside.copy()
    touching[1:] |= outside[:-1]
    touching[:-1] |= outside[1:]
    axes.plot(
        x,
        np.where(curve.inside, curve.values, np.nan),
        color=curve.colour,
        lw=curve.width,
        label=curve.label,
    )
    axes.plot(
        x,
        np.where(touching, curve.values, np.nan),
        color=curve.colour,
        lw=curve.width,
        ls=(0, (3.5, 1.2)),
    )


def _heading(axes: Axes, panel: Panel) -> None:
    axes.set_title(f"{panel.title}\n", loc="left", fontweight="bold")
    axes.text(
        0.0, 1.012, panel.note, transform=axes.transAxes, fontsize=7, color="#444444", va="bottom"
    )


def _panel_legend(figure: Figure, panels: Sequence[Panel]) -> None:
    """One legend under all axes, with the meaning of dashes where there are any."""
    handles: dict[str, Line2D] = {}
    dashed = False
    for panel in panels:
        for curve in panel.curves:
            handles.setdefault(curve.label, Line2D([], [], color=curve.colour, lw=1.6))
            dashed |= curve.inside is not None and not bool(curve.inside.all())
    if dashed:
        handles["dashed: $C_e$ read outside the run points"] = Line2D(
            [], [], color="#777777", lw=1.2, ls=(0, (3.5, 1.2))
        )
    _legend_below(figure, handles)


def psd_figure(frequency: Array, panels: Sequence[Panel]) -> Figure:
    """Acceleration PSDs, the readings of the damping side by side on one scale.

    Parameters
    ----------
    frequency
        (nf,) rising, Hz.
    panels
        One a reading; ``values`` are one-sided PSDs in (m/s²)²/Hz and are drawn in g²/Hz.
    """
    figure = Figure(figsize=(WIDTH, 4.4))
    grid = np.atleast_1d(figure.subplots(1, len(panels), sharey=True))
    _place(figure, 1, len(panels), top=0.42, across=0.25)
    top = max(np.nanmax(c.values) for p in panels for c in p.curves) / STANDARD_GRAVITY**2
    bottom = min(np.nanmin(c.values) for p in panels for c in p.curves) / STANDARD_GRAVITY**2
    for axes, panel in zip(grid, panels, strict=True):
        for curve in panel.curves:
            _draw(axes, frequency, replace(curve, values=curve.values / STANDARD_GRAVITY**2))
        axes.set_yscale("log")
        axes.yaxis.set_minor_locator(ticker.NullLocator())  # too many over so many decades
        _frequency_axis(axes, frequency[0], frequency[-1])
        _heading(axes, panel)
    grid[0].yaxis.set_major_locator(ticker.LogLocator(numticks=DECADES + 2))
    grid[0].set_ylim(max(bottom / 2, top * 10.0**-DECADES), top * 2)
    grid[0].set_ylabel("acceleration PSD, g²/Hz")
    _panel_legend(figure, panels)
    return figure


def damping_figure(frequency: Array, damping: Sequence[Panel], mass: Sequence[Panel]) -> Figure:
    """C_e and m_a that the responses were computed with, a column a reading.

    Parameters
    ----------
    frequency
        (nf,) rising, Hz.
    damping, mass
        One a reading; values in N s/m³ and kg/m².
    """
    figure = Figure(figsize=(WIDTH, 4.9))
    grid = figure.subplots(
        2, len(damping), sharex=True, sharey="row", squeeze=False, height_ratios=(3, 2)
    )
    _place(figure, 2, len(damping), top=0.42, across=0.25, down=0.15)
    for column, (above, below) in enumerate(zip(damping, mass, strict=True)):
        for curve in above.curves:
            _draw(grid[0, column], frequency, curve)
        for curve in below.curves:
            _draw(grid[1, column], frequency, curve)
        grid[0, column].set_yscale("log")
        _heading(grid[0, column], above)
        for axes in grid[:, column]:
            _frequency_axis(axes, frequency[0], frequency[-1])
        grid[0, column].set_xlabel("")
    grid[0, 0].set_ylabel("$C_e$, N s/m³")
    grid[1, 0].set_ylabel("apparent mass $m_a$, kg/m²")
    _panel_legend(figure, damping)
    return figure


def reduction_figure(
    centre: Array,
    rows: Sequence[str],
    gained: Mapping[tuple[str, str], Array],
    points: Sequence[str],
    readings: Sequence[str],
    row_name: str,
) -> Figure:
    """Third-octave reductions against the bare panel as maps, a column a reading.

    Parameters
    ----------
    centre
        (bands,) Hz.
    rows
        What the rows are called, such as fill fractions.
    gained
        (rows, bands) reduction, dB, by (point, reading).
    points, readings
        Order of the maps, downwards and to the right.
    row_name
        Name and unit of the rows.
    """
    figure = Figure(
        figsize=(WIDTH, 1.0 + len(points) * (0.55 + 0.2 * len(rows))), layout="constrained"
    )
    grid = figure.subplots(len(points), len(readings), sharex=True, sharey=True, squeeze=False)
    limit = max(1.0, max(float(np.abs(map_).max()) for map_ in gained.values()))
    scale = ScalarMappable(Normalize(-limit, limit), mpl.colormaps["RdBu"])
    for (i, point), (j, reading) in (
        (a, b) for a in enumerate(points) for b in enumerate(readings)
    ):
        axes, values = grid[i, j], gained[point, reading]
        axes.imshow(values, cmap=scale.cmap, norm=scale.norm, aspect="auto")
        for (row, band), value in np.ndenumerate(values):
            axes.text(
                band, row, _short(value), ha="center", va="center", fontsize=5.5,
                color="white" if abs(value) > 0.6 * limit else "black",
            )  # fmt: skip
        axes.grid(False)
        axes.set_title(f"point {point} · {reading}", loc="left")
        axes.set_yticks(range(len(rows)), rows)
        axes.set_xticks(range(len(centre)), [_nominal(c) for c in centre], rotation=90)
        axes.tick_params(length=2)
        if j == 0:
            axes.set_ylabel(row_name)
        if i == len(points) - 1:
            axes.set_xlabel("third octave, Hz")
    figure.colorbar(scale, ax=grid, label="reduction of the rms, dB", pad=0.01)
    return figure


def _short(value: float) -> str:
    """Two digits for a cell of a map, no sign of a zero."""
    text = f"{value:.1f}" if abs(value) < 9.95 else f"{value:.0f}"
    return "0" if float(text) == 0 else text


def _nominal(centre: float) -> str:
    """Nominal centre of a third octave (ISO 266), such as 31.5 or 1250."""
    preferred = (1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8)
    number = round(10 * np.log10(centre))
    return f"{preferred[number % 10] * 10.0 ** (number // 10):g}"


# --------------------------------------------------------------------------- sound, panel


def spectrum_figure(bands: pd.DataFrame, low: float, high: float) -> Figure:
    """Band levels and pressure PSD of the sound; the range looked at is white.

    Parameters
    ----------
    bands
        ``sound/spectrum.csv``.
    low, high
        Range of the response, Hz.
    """
    figure = Figure(figsize=(WIDTH, 3.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    edges = np.append(bands["lower_hz"].to_numpy(), bands["upper_hz"].to_numpy()[-1])
    colour = style.PLACES[0]
    for axes, column in ((left, "band_spl_db"), (right, "surface_pressure_psd_pa2_hz")):
        values = bands[column].to_numpy()
        axes.stairs(values, edges, color=colour, lw=1.1, baseline=None)
        _frequency_axis(axes, edges[0], edges[-1])
        for start, stop in ((edges[0], low), (high, edges[-1])):
            if stop > start:
                axes.axvspan(start, stop, color="#eeeeee", lw=0, zorder=0)
    left.plot(bands["center_hz"], bands["band_spl_db"], "o", color=colour, ms=3)
    left.set_ylabel("band level, dB re 20 µPa")
    left.set_title("band levels", loc="left", fontweight="bold")
    right.set_yscale("log")
    right.set_ylabel("pressure PSD on the surface, Pa²/Hz")
    right.set_title("one-sided PSD", loc="left", fontweight="bold")
    return figure


def mesh_figure(
    vertices: Array,
    cells: Index,
    patches: Mapping[str, Flags],
    points: Mapping[str, tuple[float, float]],
) -> Figure:
    """The mesh with its patches and response points.

    Parameters
    ----------
    vertices
        (nv, 2) m.
    cells
        (nc, k) numbers of vertices.
    patches
        (nc,) whether a cell belongs to the patch, by name.
    points
        (x, y) in m by name.
    """
    size = np.ptp(vertices, axis=0)
    figure = Figure(figsize=(6.5, 5.9 * size[1] / size[0] + 0.5), layout="constrained")
    axes = figure.subplots()
    axes.add_collection(
        PolyCollection(list(vertices[cells]), facecolor="none", edgecolor="#9aa4ae", lw=0.4)
    )
    axes.add_collection(
        LineCollection(list(vertices[boundary_edges(cells)]), colors="black", linewidths=0.9)
    )
    for name, inside in patches.items():
        colour = style.place_colour(name, list(patches))
        corners = vertices[cells[inside]]
        axes.add_collection(
            PolyCollection(list(corners), facecolor=colour, alpha=0.35, edgecolor="none")
        )
        edges = vertices[boundary_edges(cells[inside])]
        axes.add_collection(LineCollection(list(edges), colors=colour, linewidths=1.3))
        lowest = corners[..., 1].min()
        middle = (corners[..., 0].min() + corners[..., 0].max()) / 2
        axes.annotate(
            name, (middle, lowest), xytext=(0, -3), textcoords="offset points",
            ha="center", va="top", fontweight="bold", color=colour, bbox=_PLATE,
        )  # fmt: skip
    for name, (x, y) in points.items():
        axes.plot(x, y, "o", color="black", ms=4)
        axes.annotate(
            name, (x, y), xytext=(5, 5), textcoords="offset points", va="bottom", bbox=_PLATE
        )
    axes.set_aspect("equal")
    room = 0.02 * size.max()
    axes.set_xlim(vertices[:, 0].min() - room, vertices[:, 0].max() + room)
    axes.set_ylim(vertices[:, 1].min() - room, vertices[:, 1].max() + room)
    axes.grid(False)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    return figure


_PLATE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}


def pictures_figure(
    images: Sequence[NDArray[np.uint8]],
    titles: Sequence[str],
    *,
    columns: int,
    colormap: str,
    limits: tuple[float, float],
    label: str,
    width: float = WIDTH,
) -> Figure:
    """Rendered pictures in rows with one colour bar.

    Parameters
    ----------
    images
        (height, width, 3), all of one size.
    titles
        One each.
    columns
        Pictures in a row.
    colormap, limits, label
        Of the colour bar; the label with its unit.
    width
        Of the figure, inches.
    """
    rows = -(-len(images) // columns)
    ratio = images[0].shape[0] / images[0].shape[1]
    each = (width - 0.9) / columns
    figure = Figure(figsize=(width, rows * (each * ratio + 0.3)), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for axes, image, title in zip(grid.flat, images, titles, strict=False):
        axes.imshow(image, interpolation="bilinear")
        axes.set_title(title, fontsize=8)
    scale = ScalarMappable(Normalize(*limits), mpl.colormaps[colormap])
    figure.colorbar(scale, ax=grid, label=label, shrink=0.75, pad=0.02, aspect=30)
    return figure


# --------------------------------------------------------------------------- coupon


@dataclass(frozen=True)
class Record:
    """The cycles of one run.

    Attributes
    ----------
    title
        The case.
    seed
        Of its packing.
    energy
        (n,) dissipated energy of each cycle, J/m².
    start
        First cycle (from 0) after the transient.
    mean, error
        Of the cycles from there on, J/m².
    """

    title: str
    seed: int
    energy: Array
    start: int
    mean: float
    error: float


def steadiness_figure(records: Sequence[Sequence[Record]]) -> Figure:
    """Dissipated energy per cycle against the cycle, a case to each of the axes.

    Parameters
    ----------
    records
        The runs (seeds) of each case.
    """
    columns = min(3, len(records))
    rows = -(-len(records) // columns)
    figure = Figure(figsize=(WIDTH, 2.4 * rows + 0.4), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat[len(records) :]:
        axes.set_visible(False)
    for axes, runs in zip(grid.flat, records, strict=False):
        for number, run in enumerate(runs):
            colour = style.PLACES[number % len(style.PLACES)]
            cycle = np.arange(1, len(run.energy) + 1)
            axes.plot(cycle, run.energy, color=colour, lw=0.6, marker=".", ms=2)
            axes.axvline(run.start + 0.5, color=colour, lw=0.9, ls=":")
            axes.fill_between(
                [run.start + 0.5, len(run.energy)],
                run.mean - run.error,
                run.mean + run.error,
                color=colour, alpha=0.25, lw=0,
            )  # fmt: skip
            axes.plot([run.start + 0.5, len(run.energy)], [run.mean] * 2, color=colour, lw=1.2)
        axes.set_title(runs[0].title, loc="left")
        low = min(0.0, *(run.energy.min() for run in runs))
        high = max(run.energy.max() for run in runs)
        axes.set_ylim(1.08 * low, 1.08 * high)
        axes.axhline(0, color="#888888", lw=0.6)
        axes.set_xlim(0, max(len(run.energy) for run in runs) + 1)
        axes.xaxis.set_major_locator(ticker.MaxNLocator(6, integer=True))
        axes.set_xlabel("cycle")
        axes.set_ylabel("$E_d$ per cycle, J/m²")
    seeds = sorted({run.seed for runs in records for run in runs})
    handles = {
        f"seed {seed}": Line2D([], [], color=style.PLACES[i % len(style.PLACES)], marker=".")
        for i, seed in enumerate(seeds)
    }
    handles["end of the transient"] = Line2D([], [], color="#555555", ls=":")
    handles["mean after it ± standard error"] = Line2D([], [], color="#555555", lw=4, alpha=0.35)
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4)
    return figure


@dataclass(frozen=True)
class Quantity:
    """A column of ``coupon/cases.csv`` as an axis."""

    column: str
    label: str
    log: bool
    error: str | None = None


EQUIVALENT_DAMPING = Quantity(
    "equivalent_damping_n_s_m3", "$C_e$, N s/m³", True, "equivalent_damping_error_n_s_m3"
)
LOSS_FACTOR = Quantity("loss_factor", "loss factor η, 1", True, "loss_factor_error")
MASS_SHARE = Quantity("apparent_mass_share", "$m_a$ / mass of the spheres, 1", False,
                      "apparent_mass_share_error")  # fmt: skip
FREQUENCY = Quantity("frequency_hz", "frequency, Hz", True)
LEVEL = Quantity("acceleration_g", "acceleration amplitude Γ, g", True)


def sweep_figure(
    cases: pd.DataFrame,
    x: Quantity,
    y: Quantity,
    panel: Quantity,
    *,
    law: Callable[[Array, float], Array] | None = None,
    bound: str | None = None,
) -> Figure:
    """A quantity of the coupon over frequency or level, a line a fill.

    Parameters
    ----------
    cases
        Rows of ``coupon/cases.csv`` that stand.
    x, y
        The axes; ``y`` with error bars of one standard error.
    panel
        The quantity that is constant in each of the axes.
    law
        C_e of (frequency in Hz, fill fraction) in N s/m³ to draw dashed.
    bound
        Column to draw dotted, in the unit of ``y``.
    """
    values = sorted(cases[panel.column].unique())
    fills = sorted(cases["fill_fraction"].unique())
    columns = min(3, len(values))
    rows = -(-len(values) // columns)
    figure = Figure(figsize=(WIDTH, 2.55 * rows + 0.5))
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    _place(figure, rows, columns, top=0.25, across=0.72, down=0.68)
    for axes in grid.flat[len(values) :]:
        axes.set_visible(False)
    for axes, value in zip(grid.flat, values, strict=False):
        for number, fill in enumerate(fills):
            rows_of = cases[(cases[panel.column] == value) & (cases["fill_fraction"] == fill)]
            one = rows_of.sort_values(x.column)
            colour = style.fill_colour(fill)
            at = one[x.column].to_numpy(float)
            axes.errorbar(
                at, one[y.column],
                yerr=one[y.error] if y.error else None,
                color=colour, marker=style.MARKERS[number % len(style.MARKERS)],
                capsize=1.8, elinewidth=0.7, capthick=0.7,
            )  # fmt: skip
            if bound:
                axes.plot(at, one[bound], color=colour, ls=":", lw=0.8)
            if law and len(one):
                fine = np.geomspace(
                    cases[FREQUENCY.column].min(), cases[FREQUENCY.column].max(), 60
                )
                if x is FREQUENCY:
                    axes.plot(fine, law(fine, fill), color=colour, ls="--", lw=0.8)
                else:
                    reach = np.array([cases[x.column].min(), cases[x.column].max()])
                    level = law(np.full(2, value), fill)
                    axes.plot(reach, level, color=colour, ls="--", lw=0.8)
        axes.set_title(f"{_symbol(panel)} = {value:g} {_unit(panel)}", loc="left")
        axes.set_xscale("log" if x.log else "linear")
        if y.log:
            axes.set_yscale("log")
        else:
            axes.axhline(0, color="#888888", lw=0.6)
        if x is FREQUENCY:
            low, high = cases[x.column].min(), cases[x.column].max()
            _frequency_axis(axes, low / 1.25, high * 1.25)
        else:
            axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
        axes.set_xlabel(x.label)
        axes.set_ylabel(y.label)
        axes.tick_params(labelbottom=True, labelleft=True)
    handles = {
        f"r = {fill:g}": Line2D(
            [], [], color=style.fill_colour(fill), marker=style.MARKERS[i % len(style.MARKERS)]
        )
        for i, fill in enumerate(fills)
    }
    if law:
        handles["dashed: the paper's law, corrected"] = Line2D(
            [], [], color="#555555", ls="--", lw=0.8
        )
    if bound:
        handles["dotted: bound of an inelastic bed"] = Line2D(
            [], [], color="#555555", ls=":", lw=0.8
        )
    _legend_below(figure, handles)
    return figure


def _symbol(quantity: Quantity) -> str:
    return {"frequency_hz": "f", "acceleration_g": "Γ"}.get(quantity.column, quantity.column)


def _unit(quantity: Quantity) -> str:
    return quantity.label.rsplit(", ", 1)[-1]
