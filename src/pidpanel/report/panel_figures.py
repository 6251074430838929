"""Figures of the panel: its mesh, its shapes, rendered pictures in rows.

Functions return a `matplotlib.figure.Figure`; call them within `style.context`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from pidpanel.arrays import Array, Index
from pidpanel.report.layout import WIDTH

SEEN = np.array([[0.9439, -0.3303, 0.0], [0.2376, 0.6789, 0.6947]])
"""Axes of a picture of a shape, to the right and up, of one who looks down on the panel."""
SPREAD, LIFT = 0.63, 0.1
"""Height of a picture over the panel's diagonal; largest deflection over its least side."""


def shapes_figure(
    vertices: Array,
    cells: Index,
    shapes: Array,
    lines: Index,
    points: Array,
    titles: Sequence[str],
) -> Figure:
    """Draw shapes (n_vertices, n_shapes) as the deflected panel, coloured from −1 to 1.

    ``lines`` (n_lines, 2) are edges to draw, ``points`` (n_points, 2) places near vertices [m].
    """
    figure, grid = _grid(len(titles), 3, 400 / 660, WIDTH)
    size, middle = np.ptp(vertices, axis=0), (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    marked = np.linalg.norm(vertices[:, None] - points, axis=-1).argmin(axis=0)
    triangles = np.concatenate([cells[:, [0, i, i + 1]] for i in range(1, cells.shape[1] - 1)])
    # what is farther away is drawn first
    triangles = triangles[np.argsort(-(vertices[triangles].mean(axis=1) @ [0.33, 0.94]))]
    half = 0.5 * SPREAD * float(np.hypot(*size))
    for axes, shape, title in zip(grid, shapes.T, titles, strict=False):
        scaled = shape / shape[np.abs(shape).argmax()]
        place = np.column_stack([vertices - middle, LIFT * float(size.min()) * scaled]) @ SEEN.T
        mesh = Triangulation(place[:, 0], place[:, 1], triangles)
        axes.tripcolor(mesh, scaled, shading="gouraud", cmap="RdBu_r", vmin=-1.0, vmax=1.0)
        axes.add_collection(LineCollection(list(place[lines]), colors="black", linewidths=0.6))
        axes.plot(*place[marked].T, "o", color="black", ms=2.2)
        axes.set_title(title, fontsize=8)
        axes.set_aspect("equal")
        axes.set_xlim(-1.65 * half, 1.65 * half)
        axes.set_ylim(-half, half)
    _bar(figure, "RdBu_r", (-1, 1), "deflection over its largest value, –")
    return figure


LABEL_PITCH = 0.08
"""Width of a character of an axis label [inch]."""

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
    """Arrange rendered pictures in rows with one colour bar."""
    figure, grid = _grid(len(images), columns, images[0].shape[0] / images[0].shape[1], width)
    for axes, image, title in zip(grid, images, titles, strict=False):
        axes.imshow(image, interpolation="bilinear")
        axes.set_title(title, fontsize=8)
    _bar(figure, colormap, limits, label)
    return figure


def _grid(count: int, columns: int, ratio: float, width: float) -> tuple[Figure, list[Axes]]:
    """Return a figure of pictures in rows, each so high over its width."""
    rows = -(-count // columns)
    cell_width = (width - 0.9) / columns
    figure = Figure(figsize=(width, rows * (cell_width * ratio + 0.3)), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for axes in grid:
        axes.set_axis_off()
    return figure, grid


def _bar(figure: Figure, colormap: str, limits: tuple[float, float], label: str) -> None:
    """Add the colour bar of all pictures."""
    scale = ScalarMappable(Normalize(*limits), mpl.colormaps[colormap])
    # a bar may be shorter than its label in a line
    label = textwrap.fill(label, max(8, int(0.75 * figure.get_figheight() / LABEL_PITCH)))
    figure.colorbar(scale, ax=figure.axes, label=label, shrink=0.75, pad=0.02, aspect=30)
