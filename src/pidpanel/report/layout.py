"""Layout that the figures share: width, margins, legends, the axis of frequency."""

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import ticker
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation
from matplotlib.tri import Triangulation, TriContourSet
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.report import style
from pidpanel.report.html import PageCurve
from pidpanel.report.text import SUPERSCRIPT

WIDTH = 10.0  # width of a figure that fills the page [inch]

LINES = {"solid": "-", "dashed": "--", "dotted": ":"}

DASHES = (0, (3.5, 1.2))  # of a curve outside the range of its damping's data

MARKER_RADIUS = 3.5  # of the markers that names leave free [pt]
NAME_GAP = 2.0  # between names [pt]

SHADES = 64  # of the colour scale of a map

# Ticks of a decade of frequency, by the least distance of two of them [decades].
STEPS = {0.095: (1, 1.5, 2, 3, 4, 5, 7), 0.3: (1, 2, 5), 0.47: (1, 3), 1.0: (1,)}
MOST_WIDE = 1e4  # ratio of the ends of an axis that has numbers between powers of ten
ARC = 6  # straight pieces of an arc
# Distance of the centres of two circles over their radius that are one, and the sharpest turn [rad]
# between chords of a circle: that of corners is larger.
OFF_CIRCLE, SHARPEST = 0.02, 0.9
TICK_WIDTH = 0.38  # of a number of four digits with its gap [inch]

GREY = "#555555"  # colour of a legend's line that represents all colours


class PowerFormatter(ticker.LogFormatterSciNotation):
    """Numbers of a logarithmic axis as text: 20, 10⁻⁵."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the text of a tick, of powers of ten alone where there are many of them."""
        low, high = self.axis.get_view_interval() if self.axis else (x, x)
        if high > MOST_WIDE * low and not np.isclose(np.log10(x) % 1, [0, 1]).any():
            return ""
        marked = super().__call__(x, pos).removeprefix(r"$\mathdefault{").removesuffix("}$")
        plain = marked.replace(r"\times", "·").replace("-", "−")
        return re.sub(r"\^\{(.*)\}", lambda power: power[1].translate(SUPERSCRIPT), plain)


def log_scale(axes: Axes, names: str = "y") -> None:
    """Make axes, ``"x"``, ``"y"`` or both, logarithmic."""
    for name in names:
        axes.set(**{f"{name}scale": "log"})
        axis = axes.xaxis if name == "x" else axes.yaxis
        axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5), numticks=99))
        axis.set_major_formatter(PowerFormatter(minor_thresholds=(np.inf, np.inf)))
        axis.set_minor_formatter(ticker.NullFormatter())


def frequency_axis(axes: Axes, low: float, high: float) -> None:
    """Make x a logarithmic axis of frequency from ``low`` to ``high`` [Hz] with plain numbers."""
    axes.set(xscale="log", xlim=(low, high))
    figure = axes.get_figure(root=True)
    width = axes.get_position().width * (WIDTH if figure is None else figure.get_figwidth())
    steps = [s for gap, s in STEPS.items() if gap * width > TICK_WIDTH * np.log10(high / low)]
    ticks = np.outer(10.0 ** np.arange(5), steps[0] if steps else [1]).ravel()
    ticks = ticks[(low * 0.999 <= ticks) & (ticks <= high * 1.001)]
    axes.xaxis.set_major_locator(ticker.FixedLocator(ticks.tolist()))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(ticker.NullFormatter())
    axes.set_xlabel("frequency, Hz")


def draw_curve(axes: Axes, x: Array, curve: PageCurve) -> None:
    """Draw a curve with its band, solid within the range of its data and dashed outside.

    The bare panel lies over all others: it is the measure of them.
    """
    look: dict[str, Any] = {
        "color": curve.colour,
        "lw": curve.width or 0.9,
        "zorder": 3.0 if curve.colour == style.BARE else 2.0,
        "label": curve.label,
    }
    if curve.band is not None:
        axes.fill_between(x, *curve.band, color=curve.colour, alpha=0.22, lw=0)
    if curve.inside is None or curve.inside.all():
        axes.plot(x, curve.values, ls=LINES[curve.line], **look)
        return
    outside = ~curve.inside
    # the dashed part reaches to the neighbouring lines, or a gap would be left
    touching = outside.copy()
    touching[1:] |= outside[:-1]
    touching[:-1] |= outside[1:]
    for drawn, dashes in ((curve.inside, "-"), (touching, DASHES)):
        axes.plot(x, np.where(drawn, curve.values, np.nan), ls=dashes, **look)


def pick(values: Array, count: int) -> Array:
    """Return at most ``count`` of the values, equally spaced, including the first and the last.

    Examples
    --------
    >>> pick(np.array([0.1, 0.3, 0.5, 0.7, 0.9]), 3)
    array([0.1, 0.5, 0.9])
    """
    index = np.unique(np.linspace(0, len(values) - 1, min(count, len(values))).round().astype(int))
    return values[index]


def triangles_of(cells: Index) -> Index:
    """Return the triangles (n, 3) of elements with three or more corners."""
    return np.concatenate([cells[:, [0, i, i + 1]] for i in range(1, cells.shape[1] - 1)])


def outline_curves(vertices: Array, cells: Index) -> list[Array]:
    """Return the edges round elements as lines (k, d), those along a circle as arcs of it.

    An edge is on a circle if it is so with the edge before and with the edge behind it.
    """
    edges = boundary_edges(cells)
    count, total = np.zeros((2, len(vertices)), dtype=np.int64)
    np.add.at(count, edges, 1)
    np.add.at(total, edges, edges[:, ::-1])
    neighbour = np.where(count[edges] == 2, total[edges] - edges[:, ::-1], edges)
    previous, start, end, following = vertices[[neighbour[:, 0], *edges.T, neighbour[:, 1]]]
    centre, next_centre = _circle(previous, start, end), _circle(start, end, following)
    radius = np.linalg.norm(start - centre, axis=1)
    steps = [start - previous, end - start, following - end]
    unit = [step / np.maximum(np.linalg.norm(step, axis=1), 1e-300)[:, None] for step in steps]
    turn = [np.sum(a * b, axis=1) for a, b in pairwise(unit)]
    is_round = np.linalg.norm(centre - next_centre, axis=1) < OFF_CIRCLE * radius
    is_round &= np.minimum(*turn) > np.cos(SHARPEST)
    share = np.linspace(0, 1, ARC + 1)[:, None]
    lines = [np.stack(ends) for ends in zip(start, end, strict=True)]
    for edge in np.flatnonzero(is_round).tolist():
        arm = start[edge] + share * (end - start)[edge] - centre[edge]
        scale = radius[edge] / np.linalg.norm(arm, axis=1, keepdims=True)
        lines[edge] = centre[edge] + scale * arm
    return lines


def _circle(a: Array, b: Array, c: Array) -> Array:
    """Return the centres (n, d) of circles through three points; NaN of straight lines."""
    u, v = b - a, c - a
    uu, vv, uv = (np.sum(x * y, axis=1)[:, None] for x, y in ((u, u), (v, v), (u, v)))
    twice = 2 * (uu * vv - uv**2)
    arm = vv * (uu - uv) * u + uu * (vv - uv) * v
    straight = twice <= 1e-12 * uu * vv
    return a + np.divide(arm, twice, out=np.full(arm.shape, np.nan), where=~straight)


def draw_field(
    axes: Axes, vertices: Array, cells: Index, values: Array, colours: str,
    ends: tuple[float, float],
) -> TriContourSet:  # fmt: skip
    """Draw values (n,) at vertices (n, 2) of elements in `SHADES` colours of a scale.

    They are not antialiased: neighbours would blend to colours that the bar of the scale lacks.
    """
    low, high = ends
    levels = np.linspace(low, high if high > low else low + 1.0, SHADES + 1)
    levels[-1] += 1e-9 * (levels[-1] - low)  # an element of the highest value is drawn
    mesh = Triangulation(vertices[:, 0], vertices[:, 1], triangles_of(cells))
    drawn = axes.tricontourf(
        mesh, values, levels=levels, antialiased=False,
        cmap=mpl.colormaps[colours].resampled(SHADES),
        extend="max" if values.max() > high else "neither",
    )  # fmt: skip
    drawn.set_rasterized(True)
    return drawn


def add_colour_bar(
    figure: Figure, drawn: TriContourSet, axes: Sequence[Axes], label: str, **look: Any
) -> None:
    """Add the scale of fields that `draw_field` drew, with ticks within it."""
    low, *_, high = drawn.levels
    ticks = np.array(ticker.MaxNLocator(6).tick_values(low, high))
    within = ticks[(ticks >= low) & (ticks <= high)]
    figure.colorbar(drawn, ax=list(axes), label=label, ticks=within.tolist(), **look)


def panel_axes(axes: Axes, vertices: Array, margin: float) -> None:
    """Frame a panel with vertices (n, 2) [m] and a share of its length around it."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    room = margin * (high - low).max()
    x, y = np.column_stack([low - room, high + room])
    axes.set(aspect="equal", xlim=x, ylim=y, xlabel="x, m", ylabel="y, m")
    axes.grid(False)


def separate(figure: Figure, names: Sequence[Annotation], points: ArrayLike = ()) -> None:
    """Move names in the first axes, each by as little as it takes to lie on no name before it.

    ``points``: (n, 2) coordinates in the first axes, where markers and bars are.
    """
    if not names:
        return
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # known now, and takes longer than the drawing
    point = figure.dpi / 72
    marked = figure.axes[0].transData.transform(np.reshape(points, (-1, 2)))
    radius, frame = MARKER_RADIUS * point, figure.axes[0].bbox
    placed = np.hstack([marked - radius, marked + radius])  # (n, 4): left, bottom, right, top
    steps = np.array([(across, up) for across in range(-2, 3) for up in range(-4, 5)])
    for name in names:
        first = name.get_window_extent()
        shifts = 0.51 * steps * first.size
        boxes = np.tile(shifts, 2) + first.extents
        cut = ((boxes[:, :2] < frame.min) | (boxes[:, 2:] > frame.max)).any(axis=1)
        low = np.maximum(boxes[:, None, :2], placed[:, :2])
        high = np.minimum(boxes[:, None, 2:], placed[:, 2:])
        overlaps = (low < high).all(axis=2).sum(axis=1)
        best = np.lexsort([np.hypot(*shifts.T), overlaps + cut])[0]
        gap = NAME_GAP * point * np.array([-1, -1, 1, 1])
        placed = np.vstack([placed, boxes[best] + gap])
        x, y = np.array(name.xyann) + shifts[best] / point
        name.xyann = x, y


def fill_handles(fills: Iterable[float]) -> dict[str, Artist]:
    """Return the entries of a legend for fill fractions."""
    return {
        f"r = {fill:g}": Line2D(
            [], [], color=style.fill_colour(fill), marker=style.MARKERS[number % len(style.MARKERS)]
        )
        for number, fill in enumerate(fills)
    }


def figure_of_axes(
    count: int, across: int, height: float, extra: float, width: float = WIDTH, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes in rows of a height [inch]; ``extra`` is for the legend.

    There are about ``across`` in a row, such that at most one place is empty, for the legend.
    """
    choices = (across, across + 1, max(1, across - 1))
    columns = min(choices, key=lambda n: max(-count % n, 1)) if count > across else count
    rows = -(-count // columns)
    figure = Figure(figsize=(width, height * rows + extra), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, **options)
    for axes in grid.flat:
        axes.tick_params(labelbottom=True)
    for unused in grid.flat[count:]:
        unused.set_axis_off()
    return figure, list(grid.flat[:count])


def add_legend(figure: Figure, columns: int, handles: Mapping[str, Artist] | None = None) -> None:
    """Add a legend, by default of the first axes, in an empty place or below all axes."""
    if handles is None:
        drawn, labels = figure.axes[0].get_legend_handles_labels()
        handles = dict(zip(labels, drawn, strict=True))
    entries = list(handles.values()), list(handles)
    for axes in figure.axes:
        if not axes.axison:
            axes.legend(*entries, loc="center", ncols=1 + len(handles) // 8)
            return
    figure.legend(*entries, loc="outside lower center", ncols=columns)
