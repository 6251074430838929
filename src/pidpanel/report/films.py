"""A shaken cell in motion: made by LIGGGHTS, kept as a file, drawn as an animation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from PIL import Image

from pidpanel.arrays import Array, Flags, variable
from pidpanel.coupon import geometry
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.film import Film, watch
from pidpanel.coupon.liggghts.failures import SolverFailure
from pidpanel.coupon.packing import Packing
from pidpanel.report.html import Picture
from pidpanel.report.layout import pick

# Fill fraction, frequency [Hz] and Γ of the case in the film, or of the nearest to it.
PICTURED = (0.5, 158.0, 10.0)

CYCLES, FRAMES = 2, 24  # cycles of the drive that are shown, and frames in each

CELLS_SHOWN = 2  # cells of an animation at most

SECONDS = 2.0  # how long an animation takes for one cycle [s]

PIXELS = 400  # width of an animation [pixel]

ROW_PITCH = 1.35  # distance of neighbouring cells in an animation over their width


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
    data = xr.load_dataset(file, engine="scipy")
    case = cases.get(data.attrs["case"])
    if case is None:
        return None
    names = ("time", "position", "velocity", "diameter")
    return Shot(case.point, Film(*(data[name].to_numpy().astype(float) for name in names)))


def film_picture(shot: Shot) -> Picture:
    """Return an animation of the spheres, seen from the laboratory, in slow motion."""
    run, film = shot.run, shot.film
    packing, drive = run.packing, run.drive
    index = pick(np.arange(len(film.time), dtype=float), CYCLES * FRAMES).astype(int)[:-1]
    inside, shift = in_a_row(film.position[0], packing)
    speed = np.linalg.norm(film.velocity[index][:, inside], axis=2)
    fastest = float(np.quantile(speed, 0.99))
    lift = drive.amplitude * np.sin(2 * np.pi * drive.frequency * film.time[index])
    positions = film.position[index][:, inside] + shift
    images = drawn_frames(positions, film.diameters[inside], speed / fastest, packing, lift)
    slow = SECONDS * drive.frequency
    caption = (
        f"{CYCLES} cycles at {drive.frequency:g} Hz, Γ = {drive.gamma:.4g}, r = "
        f"{run.fill_fraction:g}, {slow:.0f} times slower: computed positions of the particles "
        f"in {min(packing.count, CELLS_SHOWN)} of {packing.count} cells, seen from the side. The "
        f"cells move by ±{1e3 * drive.amplitude:.2g} mm. Colour: speed relative to the cell, 0 "
        f"(dark) to {fastest:.2g} m/s (bright)."
    )
    return Picture("film", _webp(images, SECONDS * CYCLES / len(images)), caption, format="webp")


def in_a_row(positions: Array, packing: Packing) -> tuple[Flags, Array]:
    """Return which spheres of a packing are drawn, and by how much to move those (n, 3) [m].

    The middles of the cells are then on the x axis, `ROW_PITCH` apart.
    """
    centres = geometry.cell_centres(packing.across_flats, packing.count)
    nearest = np.linalg.norm(positions[:, None, :2] - centres, axis=2).argmin(axis=1)
    inside: Flags = nearest < CELLS_SHOWN
    shift = np.zeros((int(inside.sum()), 3))
    shift[:, 0] = ROW_PITCH * packing.across_flats * nearest[inside]
    shift[:, :2] -= centres[nearest[inside]]
    return inside, shift


def drawn_frames(
    positions: Array, diameters: Array, values: Array, packing: Packing, lift: Array
) -> list[Image.Image]:
    """Draw spheres in cells that stand in a row, seen from the side, frame by frame.

    Parameters
    ----------
    positions
        (n_frames, n, 3) seen from the cells [m].
    values
        (n_frames, n) of the colours, 0 to 1.
    lift
        (n_frames,) height of the cells [m].
    """
    count, reach = min(packing.count, CELLS_SHOWN), float(np.abs(lift).max())
    width, margin = float(np.ptp(packing.outline[:, 0])), 0.1 * packing.across_flats
    middles = ROW_PITCH * packing.across_flats * np.arange(count)
    low, high = middles[0] - width / 2 - margin, middles[-1] + width / 2 + margin
    height = packing.depth + 2 * (reach + margin)
    figure = Figure(figsize=(1.0, height / (high - low)), dpi=PIXELS)
    canvas, axes = FigureCanvasAgg(figure), figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(low, high), ylim=(-reach - margin, packing.depth + reach + margin))
    axes.set_axis_off()
    cells = [
        Rectangle((middle - width / 2, 0.0), width, packing.depth, fill=False, lw=0.3)
        for middle in middles
    ]
    for cell in cells:
        axes.add_patch(cell)
    images = []
    for places, colours, up in zip(positions, values, lift.tolist(), strict=True):
        order = np.argsort(-places[:, 1])  # the nearest over all others
        spheres = EllipseCollection(
            diameters[order], diameters[order], 0.0, units="xy",
            offsets=places[order][:, [0, 2]] + [0.0, up], offset_transform=axes.transData,
            array=colours[order], cmap="plasma", clim=(0.0, 1.0), edgecolors="black", lw=0.1,
        )  # fmt: skip
        axes.add_collection(spheres, autolim=False)
        for cell in cells:
            cell.set_y(up)
        canvas.draw()
        images.append(Image.fromarray(np.array(canvas.buffer_rgba())[..., :3]))
        spheres.remove()
    return images


def _webp(images: Sequence[Image.Image], seconds: float) -> bytes:
    """Return images as an animation without end, each shown for so long [s]."""
    buffer = BytesIO()
    images[0].save(
        buffer, "WEBP", save_all=True, append_images=images[1:], duration=round(1e3 * seconds),
        loop=0, quality=70, method=4,
    )  # fmt: skip
    return buffer.getvalue()
