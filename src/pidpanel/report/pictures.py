"""Scenes drawn off screen: spheres in their cells, mode shapes of the panel.

Functions return images as arrays. No display is needed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Flags, Index
from pidpanel.coupon import geometry

if TYPE_CHECKING:
    import pyvista as pv

Image = NDArray[np.uint8]

ROW_PITCH = 1.35
"""Distance of neighbouring cells in the picture over their width."""


def _plotter(width: int, height: int) -> pv.Plotter:
    """Return a white scene of so many pixels that needs no display."""
    import pyvista as pv  # half a second, for pages without a picture too

    # VTK looks for this when its first window is made
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    plotter = pv.Plotter(off_screen=True, window_size=[width, height])
    plotter.background_color = pv.Color("white")
    return plotter


def cells_in_a_row(positions: Array, across_flats: float, count: int) -> tuple[Array, Array]:
    """Return centres of spheres (n, 3) and of cells (count, 2) with the cells side by side [m]."""
    centres = geometry.cell_centres(across_flats, count)
    row = np.zeros_like(centres)
    row[:, 0] = ROW_PITCH * across_flats * np.arange(count)
    away = np.linalg.norm(positions[:, None, :2] - centres[None], axis=-1)
    nearest = away.argmin(axis=1)
    moved = positions.copy()
    moved[:, :2] += (row - centres)[nearest]
    return moved, row


def in_first_cells(positions: Array, across_flats: float, count: int, cells: int) -> Flags:
    """Return whether spheres lie in the first cells."""
    inside: Flags = _own_cell(positions, across_flats, count) < cells
    return inside


def moved_to_first_cells(positions: Array, across_flats: float, count: int, cells: int) -> Array:
    """Return spheres of the first cells as if there were no others."""
    nearest = _own_cell(positions, across_flats, count)
    centres = geometry.cell_centres(across_flats, count)
    moved = positions.copy()
    moved[:, :2] += (geometry.cell_centres(across_flats, cells) - centres[:cells])[nearest]
    return moved


def _own_cell(positions: Array, across_flats: float, count: int) -> Index:
    centres = geometry.cell_centres(across_flats, count)
    nearest: Index = np.linalg.norm(positions[:, None, :2] - centres, axis=2).argmin(axis=1)
    return nearest


def spheres_picture(
    positions: Array,
    diameters: Array,
    values: Array,
    limits: tuple[float, float],
    *,
    outline: Array,
    across_flats: float,
    depth: float,
    count: int,
    colormap: str = "plasma",
    pixels: int = 1500,
) -> Image:
    """Draw spheres in a row of transparent cells."""
    (image,) = spheres_film(
        [positions], diameters, values[None], limits, lift=np.zeros(1), outline=outline,
        across_flats=across_flats, depth=depth, count=count, colormap=colormap, pixels=pixels,
    )  # fmt: skip
    return image


def spheres_film(
    positions: Sequence[Array],
    diameters: Array,
    values: Array,
    limits: tuple[float, float],
    *,
    lift: Array,
    outline: Array,
    across_flats: float,
    depth: float,
    count: int,
    colormap: str = "plasma",
    pixels: int = 1500,
) -> list[Image]:
    """Draw spheres in a row of transparent cells, frame by frame.

    Values have the shape (n_frames, n); the outline is that of a cell round its centre.
    """
    import pyvista as pv

    ball = pv.Sphere(radius=0.5, theta_resolution=24, phi_resolution=24)
    # seen a little from above: the height of a cell and a part of its floor
    reach = float(np.abs(lift).max())
    width = (ROW_PITCH * (count - 1) + 1.3) * across_flats
    height = 0.96 * (depth + 2 * reach) + 0.5 * across_flats
    plotter = _plotter(pixels, round(pixels * height / width))
    plotter.enable_anti_aliasing("msaa", multi_samples=4)
    walls = _walls(outline, across_flats, depth, count)
    images = []
    for frame, (places, frame_values, up) in enumerate(zip(positions, values, lift, strict=True)):
        moved, centres = cells_in_a_row(places, across_flats, count)
        spheres = pv.PolyData(moved)
        spheres["value"] = frame_values
        spheres["diameter"] = diameters
        plotter.add_mesh(
            spheres.glyph(geom=ball, scale="diameter", orient=False),
            scalars="value", cmap=mpl.colormaps[colormap], clim=list(limits),
            show_scalar_bar=False, smooth_shading=True, specular=0.25, ambient=0.25, diffuse=0.8,
            name="spheres",
        )  # fmt: skip
        if frame == 0:
            for wall in walls:
                plotter.add_mesh(wall, color="#8fa3b5", opacity=0.10, lighting=False)
                plotter.add_mesh(
                    wall.extract_feature_edges(30), color="#44525f", line_width=2, lighting=False
                )
        # the cells stay where they are, and the eye moves the other way
        middle = np.array([*(centres.mean(axis=0)), depth / 2 - up])
        plotter.camera.focal_point = middle
        plotter.camera.position = middle + np.array([0.0, -1.0, 0.3])
        plotter.camera.up = (0.0, 0.0, 1.0)
        plotter.camera.enable_parallel_projection()
        plotter.camera.parallel_scale = 0.5 * height
        plotter.reset_camera_clipping_range()
        images.append(np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8))
    plotter.close()
    return images


def _walls(outline: Array, across_flats: float, depth: float, count: int) -> list[pv.PolyData]:
    """Return the walls of cells in a row."""
    import pyvista as pv

    sides = len(outline)
    side = [[4, k, (k + 1) % sides, (k + 1) % sides + sides, k + sides] for k in range(sides)]
    ends = [[sides, *range(sides)], [sides, *range(sides, 2 * sides)]]
    walls = []
    for number in range(count):
        centre = np.array([ROW_PITCH * across_flats * number, 0.0])
        floor = np.column_stack([outline + centre, np.zeros(sides)])
        ring = np.vstack([floor, floor + np.array([0.0, 0.0, depth])])
        walls.append(pv.PolyData(ring, faces=np.concatenate([*side, *ends])))
    return walls


def mode_pictures(
    vertices: Array,
    cells: Index,
    shapes: Array,
    lines: Index,
    points: Array,
    *,
    colormap: str = "RdBu_r",
    size: tuple[int, int] = (660, 400),
) -> list[Image]:
    """Draw mode shapes (n_vertices, n_modes), coloured from −1 to 1, with lines and points."""
    import pyvista as pv

    low, high = vertices.min(axis=0), vertices.max(axis=0)
    rise = 0.1 * float(np.min(high - low))
    faces = np.hstack([np.full((len(cells), 1), cells.shape[1]), cells]).ravel()
    flat = np.pad(vertices, ((0, 0), (0, 1)))
    at_points = np.linalg.norm(vertices[:, None] - points, axis=-1).argmin(axis=0)
    images = []
    plotter = _plotter(*size)
    plotter.enable_anti_aliasing("msaa", multi_samples=4)
    for shape in shapes.T:
        scaled = shape / shape[np.abs(shape).argmax()]
        plotter.clear_actors()
        panel = pv.PolyData(flat + np.pad(rise * scaled[:, None], ((0, 0), (2, 0))), faces=faces)
        panel["deflection"] = scaled
        plotter.add_mesh(
            panel, scalars="deflection", cmap=mpl.colormaps[colormap], clim=[-1, 1],
            show_scalar_bar=False, smooth_shading=True, ambient=0.35, diffuse=0.7,
        )  # fmt: skip
        drawn = pv.PolyData(
            panel.points + np.array([0.0, 0.0, 0.05 * rise]),
            lines=np.pad(lines, ((0, 0), (1, 0)), constant_values=2).ravel(),
        )
        plotter.add_mesh(drawn, color="black", line_width=2, lighting=False)
        plotter.add_points(
            panel.points[at_points] + np.array([0.0, 0.0, 0.15 * rise]),
            color="black", point_size=10, render_points_as_spheres=True, lighting=False,
        )  # fmt: skip
        middle = np.array([*(low + high) / 2, 0.0])
        plotter.camera.focal_point = middle
        plotter.camera.position = middle + np.array([-0.7, -2.0, 2.2])
        plotter.camera.up = (0.0, 0.0, 1.0)
        plotter.camera.enable_parallel_projection()
        plotter.camera.parallel_scale = 0.315 * float(np.hypot(*(high - low)))
        plotter.reset_camera_clipping_range()
        images.append(np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8))
    plotter.close()
    return images
