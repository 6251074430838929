"""Layout that the figures share: width, margins, legends, the axis of frequency."""

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import ticker
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index
from pidpanel.report import style
from pidpanel.report.html import PageCurve

WIDTH = 10.0  # width of a figure that fills the page [inch]

LINES = {"solid": "-", "dashed": "--", "dotted": ":"}

DASHES = (0, (3.5, 1.2))  # of a curve outside the range of its damping's data

MARKER_RADIUS = 3.5  # of the markers that names leave free [pt]
NAME_GAP = 2.0  # between names [pt]

SHADES = 64  # of the colour scale of a map
FLAT_TRIANGLES = 90_000  # of a figure whose meshes have fewer

GREY = "#555555"  # colour of a legend's line that represents all colours


def frequency_axis(axes: Axes, low: float, high: float) -> None:
    """Make x a logarithmic axis of frequency from ``low`` to ``high`` [Hz] with plain numbers."""
    axes.set(xscale="log", xlim=(low, high))
    steps = (1, 2, 5) if high > 8 * low else (1, 1.5, 2, 3, 4, 5, 7)
    ticks = np.outer(10.0 ** np.arange(5), steps).ravel()
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
    if curve.log_error is not None:
        factor = np.exp(curve.log_error)
        low, high = curve.values / factor, curve.values * factor
        axes.fill_between(x, low, high, color=curve.colour, alpha=0.22, lw=0)
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


def shades(colours: str) -> Colormap:
    """Return a scale of colours whose bar has each of them, and whose flat areas are small files.

    Collections in it are not antialiased: neighbours would blend to colours that the bar lacks.
    """
    return mpl.colormaps[colours].resampled(SHADES)


def draw_field(
    axes: Axes, corners: Array, values: Array, colours: str, ends: tuple[float, float]
) -> PolyCollection:
    """Draw values (n, 3) at the corners (n, 3, 2) of triangles in colours of a scale and no others.

    Values are linear in a triangle. It is split into flat ones: shading between the colours of its
    corners passes by those of the scale.
    """
    triangles = np.concatenate([corners, values[..., None]], axis=-1)
    while 4 * len(triangles) * len(axes.figure.axes) <= FLAT_TRIANGLES:
        middle = (triangles + np.roll(triangles, -1, axis=1)) / 2
        outer = np.stack([triangles, middle, np.roll(middle, 1, axis=1)], axis=2)
        triangles = np.concatenate([outer, middle[:, None]], axis=1).reshape(-1, 3, 3)
    drawn = PolyCollection(list(triangles[..., :2]), array=triangles[..., 2].mean(axis=1))
    drawn.set(cmap=shades(colours), antialiased=False, rasterized=True)
    drawn.set_clim(*ends)
    axes.add_collection(drawn)
    return drawn


def panel_axes(axes: Axes, vertices: Array, margin: float) -> None:
    """Frame a panel with vertices (n, 2) [m] and a share of its length around it."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    room = margin * (high - low).max()
    x, y = np.column_stack([low - room, high + room])
    axes.set(aspect="equal", xlim=x, ylim=y, xlabel="x, m", ylabel="y, m")
    axes.grid(False)


def separate(figure: Figure, names: Sequence[Annotation], points: ArrayLike = ()) -> None:
    """Move names in a figure, each by as little as it takes to lie on no name before it.

    ``points``: (n, 2) coordinates in the first axes, where markers and bars are.
    """
    if not names:
        return
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # known now, and takes longer than the drawing
    point = figure.dpi / 72
    marked = figure.axes[0].transData.transform(np.reshape(points, (-1, 2)))
    radius = MARKER_RADIUS * point
    placed = np.hstack([marked - radius, marked + radius])  # (n, 4): left, bottom, right, top
    steps = np.array([(across, up) for across in range(-4, 5) for up in range(-6, 7)])
    for name in names:
        first = name.get_window_extent()
        shifts = 0.51 * steps * first.size
        boxes = np.tile(shifts, 2) + first.extents
        cut = (boxes[:, :2] < 0).any(axis=1) | (boxes[:, 2:] > figure.bbox.max).any(axis=1)
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
    count: int, columns: int, height: float, extra: float, width: float = WIDTH, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes in rows of a height [inch]; ``extra`` is for the legend."""
    rows = -(-count // columns)
    figure = Figure(figsize=(width, height * rows + extra), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, **options)
    for unused in grid.flat[count:]:
        unused.remove()
    return figure, list(grid.flat[:count])
