"""Scenes drawn off screen: spheres in their cells, as arrays. No display is needed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Flags
from pidpanel.coupon import geometry

if TYPE_CHECKING:
    import pyvista as pv

Image = NDArray[np.uint8]

ROW_PITCH = 1.35  # distance of neighbouring cells in the picture over their width


def _plotter(width: int, height: int) -> pv.Plotter:
    """Return a white scene of so many pixels that needs no display."""
    import pyvista as pv  # half a second, for pages without a picture too

    # VTK looks for this when its first window is made
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    plotter = pv.Plotter(off_screen=True, window_size=[width, height])
    plotter.background_color = pv.Color("white")
    return plotter


@dataclass(frozen=True)
class CellRow:
    """Cells drawn side by side."""

    outline: Array  # (n_corners, 2) of a cell round its centre [m]
    across_flats: float  # [m]
    depth: float  # [m]
    count: int

    @property
    def centres(self) -> Array:
        """Centres of the cells (count, 3) [m]."""
        pitch = ROW_PITCH * self.across_flats
        return np.outer(np.arange(self.count), [pitch, 0.0, 0.0])

    def take(self, positions: Array, packed: int) -> tuple[Flags, Array]:
        """Return which spheres of a packing of so many cells are drawn, and by how much to move.

        Positions (n, 3) and the shifts of those that are drawn in m.
        """
        centres = geometry.cell_centres(self.across_flats, packed)
        nearest = np.linalg.norm(positions[:, None, :2] - centres, axis=2).argmin(axis=1)
        inside: Flags = nearest < self.count
        shift = self.centres - np.pad(centres[: self.count], ((0, 0), (0, 1)))
        return inside, shift[nearest[inside]]


def spheres_film(
    positions: Sequence[Array],
    diameters: Array,
    values: Array,
    limits: tuple[float, float],
    cells: CellRow,
    *,
    lift: Array,
    pixels: int,
) -> list[Image]:
    """Draw spheres in transparent cells, frame by frame.

    Values (n_frames, n) give the colours; ``lift`` is the height of the cells in each frame [m].
    """
    import pyvista as pv

    ball = pv.Sphere(radius=0.5, theta_resolution=24, phi_resolution=24)
    # seen a little from above: the height of a cell and a part of its floor
    reach = float(np.abs(lift).max())
    width = (ROW_PITCH * (cells.count - 1) + 1.3) * cells.across_flats
    height = 0.96 * (cells.depth + 2 * reach) + 0.5 * cells.across_flats
    plotter = _plotter(pixels, round(pixels * height / width))
    plotter.enable_anti_aliasing("msaa", multi_samples=4)
    walls = _walls(cells)
    images = []
    for frame, (places, frame_values, up) in enumerate(zip(positions, values, lift, strict=True)):
        spheres = pv.PolyData(places)
        spheres["value"] = frame_values
        spheres["diameter"] = diameters
        plotter.add_mesh(
            spheres.glyph(geom=ball, scale="diameter", orient=False),
            scalars="value", cmap=mpl.colormaps["plasma"], clim=list(limits),
            show_scalar_bar=False, smooth_shading=True, specular=0.25, ambient=0.25, diffuse=0.8,
            name="spheres",
            render=False,  # the eye moves first
        )  # fmt: skip
        if frame == 0:
            for wall in walls:
                plotter.add_mesh(wall, color="#8fa3b5", opacity=0.10, lighting=False)
                plotter.add_mesh(
                    wall.extract_feature_edges(30), color="#44525f", line_width=2, lighting=False
                )
        # the cells stay where they are, and the eye moves the other way
        middle = cells.centres.mean(axis=0) + np.array([0.0, 0.0, cells.depth / 2 - up])
        plotter.camera.focal_point = middle
        plotter.camera.position = middle + np.array([0.0, -1.0, 0.3])
        plotter.camera.up = (0.0, 0.0, 1.0)
        plotter.camera.enable_parallel_projection()
        plotter.camera.parallel_scale = 0.5 * height
        plotter.reset_camera_clipping_range()
        plotter.render()
        images.append(np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8))
    plotter.close()
    return images


def _walls(cells: CellRow) -> list[pv.PolyData]:
    """Return the walls of cells in a row."""
    import pyvista as pv

    outline = cells.outline
    sides = len(outline)
    side = [[4, k, (k + 1) % sides, (k + 1) % sides + sides, k + sides] for k in range(sides)]
    ends = [[sides, *range(sides)], [sides, *range(sides, 2 * sides)]]
    walls = []
    for centre in cells.centres:
        floor = np.column_stack([outline + centre[:2], np.zeros(sides)])
        ring = np.vstack([floor, floor + np.array([0.0, 0.0, cells.depth])])
        walls.append(pv.PolyData(ring, faces=np.concatenate([*side, *ends])))
    return walls
