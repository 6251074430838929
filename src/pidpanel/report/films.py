"""A shaken cell in motion: made by LIGGGHTS, kept as a file, drawn as an animation."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import matplotlib as mpl
import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray
from PIL import Image

from pidpanel.arrays import Array, Flags, variable
from pidpanel.coupon import geometry
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.film import Film, watch
from pidpanel.coupon.liggghts.failures import SolverFailure
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.report.html import Picture
from pidpanel.report.layout import pick

if TYPE_CHECKING:
    import pyvista as pv

Pixels = NDArray[np.uint8]  # (rows, columns, 3) of an image

# Fill fraction, frequency [Hz] and Γ of the case in the film, or of the nearest to it.
PICTURED = (0.5, 158.0, 10.0)

CYCLES, FRAMES = 2, 24  # cycles of the drive that are shown, and frames in each

CELLS_SHOWN = 2  # cells of an animation at most

SECONDS = 2.0  # how long an animation takes for one cycle [s]

PIXELS = 400  # width of an animation [pixel]


class Shot(NamedTuple):
    """A run watched for some cycles."""

    run: Run
    film: Film


def nearest_case(cases: pd.DataFrame) -> str:
    """Return the label of the case nearest to `PICTURED`, in r and octaves of f and Γ."""
    good = cases[cases["status"] == "ok"]
    fill, frequency, gamma = PICTURED
    distance = (
        5 * (good["fill_fraction"] - fill).abs()
        + np.log2(good["frequency_hz"] / frequency).abs()
        + np.log2(good["acceleration_g"] / gamma).abs()
    )
    return str(good.loc[distance.idxmin(), "case"])


def write_film(
    cases: Mapping[str, Case], stamp: Mapping[str, str], table: Path, folder: Path, file: Path
) -> None:
    """Watch the case that a page pictures, and write the positions of its spheres.

    Parameters
    ----------
    cases
        Cases of the damper, by label.
    stamp
        Stamp of the study.
    table, folder
        ``cases.csv`` of the study, and runs of the coupon, ``results/coupon``.
    file
        NetCDF file to write; without frames where the run cannot be continued.
    """
    rows = read_csv(table)
    film: Film | None = None
    label = nearest_case(rows) if (rows["status"] == "ok").any() else ""
    if label:
        case = cases[label]
        try:
            film = watch(case.point, case.folders(folder)[0], cycles=CYCLES, frames=FRAMES)
        except SolverFailure as failure:
            print(f"no animation: {failure}")
    if film is None:  # NetCDF 3 has no empty dimensions: the file has nothing but its name
        xr.Dataset(attrs={**stamp, "case": ""}).to_netcdf(file, engine="scipy")
        return
    axes = "frame sphere axis"
    xr.Dataset(
        {
            "time": variable("frame", film.time, "s"),
            "position": variable(axes, film.position.astype(np.float32), "m"),
            "velocity": variable(axes, film.velocity.astype(np.float32), "m/s"),
            "diameter": variable("sphere", film.diameters, "m"),
        },
        attrs={**stamp, "case": label},
    ).to_netcdf(file, engine="scipy")


def read_film(cases: Mapping[str, Case], file: Path) -> Shot | None:
    """Read a file of `write_film`; None where there is none, or it has no frames."""
    if not file.is_file():
        return None
    data = read_netcdf(file)
    case = cases.get(data.attrs["case"])
    if case is None:
        return None
    names = ("time", "position", "velocity", "diameter")
    return Shot(case.point, Film(*(data[name].to_numpy().astype(float) for name in names)))


def film_picture(shot: Shot) -> Picture:
    """Return an animation of the spheres, seen from the laboratory, in slow motion."""
    run, film = shot.run, shot.film
    packing, drive = run.packing, run.drive
    cells = min(packing.count, CELLS_SHOWN)
    index = pick(np.arange(len(film.time), dtype=float), CYCLES * FRAMES).astype(int)[:-1]
    row = CellRow(packing.outline, packing.across_flats, packing.depth, cells)
    inside, shift = row.take(film.position[0], packing.count)
    speed = np.linalg.norm(film.velocity[index][:, inside], axis=2)
    fastest = float(np.quantile(speed, 0.99))
    images = spheres_film(
        film.position[index][:, inside] + shift,
        film.diameters[inside],
        speed,
        (0.0, fastest),
        row,
        lift=drive.amplitude * np.sin(2 * np.pi * drive.frequency * film.time[index]),
        pixels=PIXELS,
    )
    slow = SECONDS * drive.frequency
    caption = (
        f"{CYCLES} cycles at {drive.frequency:g} Hz, Γ = {drive.gamma:.4g}, r = "
        f"{run.fill_fraction:g}, {slow:.0f} times slower: computed positions of the particles "
        f"in {cells} of {packing.count} cells, seen from outside. The cells move "
        f"by ±{1e3 * drive.amplitude:.2g} mm. Colour: speed relative to the cell, 0 (dark) to "
        f"{fastest:.2g} m/s (bright)."
    )
    return Picture("film", _webp(images, SECONDS * CYCLES / len(images)), caption, format="webp")


def _webp(images: list[Pixels], seconds: float) -> bytes:
    """Return images as an animation without end, each shown for so long [s]."""
    frames = [Image.fromarray(image) for image in images]
    buffer = BytesIO()
    frames[0].save(
        buffer, "WEBP", save_all=True, append_images=frames[1:], duration=round(1e3 * seconds),
        loop=0, quality=70, method=4,
    )  # fmt: skip
    return buffer.getvalue()


ROW_PITCH = 1.35  # distance of neighbouring cells in the picture over their width


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
        """Return which spheres of a packing of ``count`` cells are drawn, and their displacement.

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
) -> list[Pixels]:
    """Draw spheres in transparent cells, frame by frame.

    Values (n_frames, n) give the colours; ``lift`` is the height of the cells in each frame [m].
    """
    import pyvista as pv  # half a second, for pages without a picture too

    # VTK looks for this when its first window is made
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    ball = pv.Sphere(radius=0.5, theta_resolution=24, phi_resolution=24)
    # seen a little from above: the height of a cell and a part of its floor
    reach = float(np.abs(lift).max())
    width = (ROW_PITCH * (cells.count - 1) + 1.3) * cells.across_flats
    height = 0.96 * (cells.depth + 2 * reach) + 0.5 * cells.across_flats
    shape = [pixels, round(pixels * height / width)]
    plotter = pv.Plotter(off_screen=True, window_size=shape)
    plotter.background_color = pv.Color("white")
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
