"""A shaken cell in motion: made by LIGGGHTS, kept as a file, drawn as an animation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from PIL import Image

from pidpanel.arrays import Array, Flags
from pidpanel.coupon import geometry
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.film import Film, watch
from pidpanel.coupon.liggghts.failures import SolverFailure
from pidpanel.coupon.packing import Packing
from pidpanel.report.html import Picture
from pidpanel.report.layout import pick

PICTURED = (0.5, 158.0, 10.0)
"""Fill fraction, frequency [Hz] and Γ of the case in the film, or of the nearest to it."""

CYCLES, FRAMES = 2, 24  # cycles of the drive that are shown, and frames in each

CELLS_SHOWN = 2  # cells of an animation at most

SECONDS = 2.0  # how long an animation takes for one cycle [s]

PIXELS = 400  # width of an animation [pixel]

PITCH = 1.35  # distance of neighbouring cells of an animation over their width


@dataclass(frozen=True)
class Shot:
    """A run watched for some cycles."""

    run: Run
    film: Film


def nearest_case(cases: pd.DataFrame) -> str:
    """Return the label of the case nearest to `PICTURED`, in r and octaves of f and Γ."""
    good = cases[cases["status"] == "ok"]
    fill, frequency, gamma = PICTURED
    away = (
        5 * (good["fill_fraction"] - fill).abs()
        + np.log2(good["frequency_hz"] / frequency).abs()
        + np.log2(good["acceleration_g"] / gamma).abs()
    )
    return str(good.loc[away.idxmin(), "case"])


def write_film(
    cases: Mapping[str, Case], stamp: Mapping[str, str], table: Path, folder: Path, file: Path
) -> None:
    """Watch the case that a page pictures, and write the positions of its spheres.

    Parameters
    ----------
    cases
        Of the damper, by label.
    stamp
        Of the study.
    table, folder
        Its ``cases.csv``, and runs of the coupon, ``results/coupon``.
    file
        NetCDF file to write; without frames where the run cannot be continued.
    """
    rows = pd.read_csv(table)
    recorded: Film | None = None
    label = nearest_case(rows) if (rows["status"] == "ok").any() else ""
    if label:
        case = cases[label]
        try:
            recorded = watch(case.point, case.folders(folder)[0], cycles=CYCLES, frames=FRAMES)
        except SolverFailure as failure:
            print(f"no animation: {failure}")
    if recorded is None:  # NetCDF 3 has no empty dimensions: the file has nothing but its name
        xr.Dataset(attrs={**stamp, "case": ""}).to_netcdf(file, engine="scipy")
        return
    film = recorded
    axes = ("frame", "sphere", "axis")
    xr.Dataset(
        {
            "time": ("frame", film.time, {"units": "s"}),
            "position": (axes, film.position.astype(np.float32), {"units": "m"}),
            "velocity": (axes, film.velocity.astype(np.float32), {"units": "m/s"}),
            "diameter": ("sphere", film.diameters, {"units": "m"}),
        },
        attrs={**stamp, "case": label},
    ).to_netcdf(file, engine="scipy")


def read_film(cases: Mapping[str, Case], file: Path) -> Shot | None:
    """Read a file of `write_film`; None where there is none, or it has no frames."""
    if not file.is_file():
        return None
    with xr.open_dataset(file, engine="scipy") as dataset:
        data = dataset.load()
    case = cases.get(data.attrs["case"])
    if case is None:
        return None
    time, position, velocity, diameters = (
        data[name].to_numpy().astype(float) for name in ("time", "position", "velocity", "diameter")
    )
    film = Film(time, position, velocity, diameters)
    return Shot(case.point, film)


def film_picture(shot: Shot) -> Picture:
    """Return an animation of the spheres, seen from the laboratory, in slow motion."""
    run, film = shot.run, shot.film
    packing, drive = run.packing, run.drive
    cells = min(packing.count, CELLS_SHOWN)
    index = pick(np.arange(len(film.time), dtype=float), CYCLES * FRAMES).astype(int)[:-1]
    inside, shift = in_a_row(film.position[0], packing, cells)
    speed = np.linalg.norm(film.velocity[index][:, inside], axis=2)
    fastest = float(np.quantile(speed, 0.99))
    lift = drive.amplitude * np.sin(2 * np.pi * drive.frequency * film.time[index])
    places = film.position[index][:, inside] + shift
    images = draw_frames(packing, cells, places, film.diameters[inside], speed / fastest, lift)
    slow = SECONDS * drive.frequency
    caption = (
        f"{CYCLES} cycles at {drive.frequency:g} Hz, Γ = {drive.gamma:.4g}, r = "
        f"{run.fill_fraction:g}, {slow:.0f} times slower: computed positions of the particles "
        f"in {cells} of {packing.count} cells, seen from the side. The cells move "
        f"by ±{1e3 * drive.amplitude:.2g} mm. Colour: speed relative to the cell, 0 (dark) to "
        f"{fastest:.2g} m/s (bright)."
    )
    return Picture("film", _webp(images, SECONDS * CYCLES / len(images)), caption, format="webp")


def in_a_row(positions: Array, packing: Packing, cells: int) -> tuple[Flags, Array]:
    """Return which spheres (n, 3) are in the first cells, and what moves these into a row [m]."""
    centres = geometry.cell_centres(packing.across_flats, packing.count)
    nearest = np.linalg.norm(positions[:, None, :2] - centres, axis=2).argmin(axis=1)
    row = np.outer(np.arange(cells), [PITCH * packing.across_flats, 0.0])
    inside: Flags = nearest < cells
    return inside, np.pad(row - centres[:cells], ((0, 0), (0, 1)))[nearest[inside]]


def draw_frames(
    packing: Packing, cells: int, positions: Array, diameters: Array, colour: Array, lift: Array
) -> list[Image.Image]:
    """Draw spheres in a row of cells from the side, x to the right and z up, frame by frame.

    Positions (n_frames, n, 3) relative to the cells and their lift (n_frames,) in m; colours
    (n_frames, n) from 0 to 1.
    """
    start, stop = packing.outline[:, 0].min(), packing.outline[:, 0].max()
    step, gap = PITCH * packing.across_flats, 0.1 * packing.across_flats
    low, high = -np.abs(lift).max() - gap, packing.depth + np.abs(lift).max() + gap
    width = (cells - 1) * step + stop - start + 2 * gap
    figure = Figure(figsize=(PIXELS / 100, PIXELS / 100 * (high - low) / width), dpi=100)
    canvas, images = FigureCanvasAgg(figure), []
    for places, values, up in zip(positions, colour, lift, strict=True):
        figure.clear()
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(start - gap, start - gap + width))
        axes.set(ylim=(low, high))
        axes.set_axis_off()
        far_first = np.argsort(-places[:, 1])
        size = diameters[far_first]
        spheres = EllipseCollection(
            size, size, 0 * size, units="xy", offsets=places[far_first][:, [0, 2]] + [0.0, up],
            offset_transform=axes.transData, array=values[far_first], cmap="plasma",
            norm=Normalize(0, 1), edgecolors="black", linewidths=0.5,
        )  # fmt: skip
        axes.add_collection(spheres)
        for number in range(cells):
            wall = Rectangle((start + number * step, up), stop - start, packing.depth, fill=False)
            axes.add_patch(wall)
        canvas.draw()
        images.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    return images


def _webp(frames: list[Image.Image], seconds: float) -> bytes:
    """Return images as an animation without end, each shown for so long [s]."""
    buffer = BytesIO()
    frames[0].save(
        buffer, "WEBP", save_all=True, append_images=frames[1:], duration=round(1e3 * seconds),
        loop=0, quality=70, method=4,
    )  # fmt: skip
    return buffer.getvalue()
