"""Figures of the panel: its mesh, rendered pictures of its modes in rows.

Functions return a `matplotlib.figure.Figure`; call them within `style.context`.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pidpanel.arrays import Array, Flags, Index
from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.report import style
from pidpanel.report.layout import WIDTH, panel_axes, separate


def mesh_figure(
    vertices: Array,
    cells: Index,
    patches: Mapping[str, Flags],
    points: Mapping[str, tuple[float, float]],
) -> Figure:
    """Draw the mesh with its patches and response points."""
    size = np.ptp(vertices, axis=0)
    figure = Figure(figsize=(6.5, 5.9 * size[1] / size[0] + 0.5), layout="constrained")
    axes = figure.subplots()
    axes.add_collection(
        PolyCollection(list(vertices[cells]), facecolor="none", edgecolor="#9aa4ae", lw=0.4)
    )
    axes.add_collection(
        LineCollection(list(vertices[boundary_edges(cells)]), colors="black", linewidths=0.9)
    )
    names = []
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
        names.append(axes.annotate(
            name, (middle, lowest), xytext=(0, -3), textcoords="offset points",
            ha="center", va="top", fontweight="bold", color=colour, bbox=_PLATE,
        ))  # fmt: skip
    for name, (x, y) in points.items():
        axes.plot(x, y, "o", color="black", ms=4)
        names.append(axes.annotate(
            name, (x, y), xytext=(5, 5), textcoords="offset points", va="bottom", bbox=_PLATE
        ))  # fmt: skip
    panel_axes(axes, vertices, 0.02)
    separate(figure, names)
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
    rows = -(-len(images) // columns)
    ratio = images[0].shape[0] / images[0].shape[1]
    cell_width = (width - 0.9) / columns
    figure = Figure(figsize=(width, rows * (cell_width * ratio + 0.3)), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for axes, image, title in zip(grid.flat, images, titles, strict=False):
        axes.imshow(image, interpolation="bilinear")
        axes.set_title(title, fontsize=8)
    scale = ScalarMappable(Normalize(*limits), mpl.colormaps[colormap])
    # a bar may be shorter than its label in a line
    label = textwrap.fill(label, max(8, int(0.75 * figure.get_figheight() / LABEL_PITCH)))
    figure.colorbar(scale, ax=grid, label=label, shrink=0.75, pad=0.02, aspect=30)
    return figure
