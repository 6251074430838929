"""A shaken cell in motion: made by LIGGGHTS, kept as a file, drawn as an animation."""

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from PIL import Image

from pidpanel.arrays import variable
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.film import Film, watch
from pidpanel.coupon.liggghts.failures import SolverFailure
from pidpanel.report import pictures
from pidpanel.report.html import Picture
from pidpanel.report.layout import pick

# Fill fraction, frequency [Hz] and Γ of the case in the film, or of the nearest to it.
PICTURED = (0.5, 158.0, 10.0)

CYCLES, FRAMES = 2, 24  # cycles of the drive that are shown, and frames in each

CELLS_SHOWN = 2  # cells of an animation at most

SECONDS = 2.0  # how long an animation takes for one cycle [s]

PIXELS = 400  # width of an animation [pixel]


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
    cells = min(packing.count, CELLS_SHOWN)
    index = pick(np.arange(len(film.time), dtype=float), CYCLES * FRAMES).astype(int)[:-1]
    row = pictures.CellRow(packing.outline, packing.across_flats, packing.depth, cells)
    inside, shift = row.take(film.position[0], packing.count)
    speed = np.linalg.norm(film.velocity[index][:, inside], axis=2)
    fastest = float(np.quantile(speed, 0.99))
    images = pictures.spheres_film(
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


def _webp(images: list[pictures.Image], seconds: float) -> bytes:
    """Return images as an animation without end, each shown for so long [s]."""
    frames = [Image.fromarray(image) for image in images]
    buffer = BytesIO()
    frames[0].save(
        buffer, "WEBP", save_all=True, append_images=frames[1:], duration=round(1e3 * seconds),
        loop=0, quality=70, method=4,
    )  # fmt: skip
    return buffer.getvalue()
