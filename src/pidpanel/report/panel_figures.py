"""The shapes of the panel; call the function within `style.context`."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from pidpanel.arrays import Array, Index
from pidpanel.report.layout import WIDTH

# Axes of a picture of a shape, to the right and up, of one who looks down on the panel.
SEEN = np.array([[0.9439, -0.3303, 0.0], [0.2376, 0.6789, 0.6947]])
# Height of a picture over the panel's diagonal; largest deflection over its least side.
SPREAD, LIFT = 0.63, 0.1


def shapes_figure(
    vertices: Array, cells: Index, shapes: Array, lines: Index, points: Array, titles: Sequence[str]
) -> Figure:
    """Draw shapes (n_vertices, n_shapes) as the deflected panel, coloured from −1 to 1.

    ``lines`` (n_lines, 2) are edges to draw, ``points`` (n_points, 2) places near vertices [m].
    """
    rows = -(-len(titles) // 3)
    height = rows * ((WIDTH - 0.9) / 3 * 400 / 660 + 0.3)
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    grid = figure.subplots(rows, 3, squeeze=False).ravel().tolist()
    for axes in grid:
        axes.set_axis_off()
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
    scale = ScalarMappable(Normalize(-1, 1), mpl.colormaps["RdBu_r"])
    label = "deflection over its\nlargest value, –"
    figure.colorbar(scale, ax=figure.axes, label=label, shrink=0.75, pad=0.02, aspect=30)
    return figure
