"""Pour a packing, shake a bed loose: what happens in ``results/coupon/packing`` and ``bed``.

A change of the bits that are written takes a new version number in `packing` or `bed`.
"""

import math
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import geometry
from pidpanel.coupon.bed import LOOSENING, Bed, loosening
from pidpanel.coupon.liggghts import deck, output, start_files
from pidpanel.coupon.liggghts.failures import NotSteady, UnderFilled
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.packing import POURING, Packing
from pidpanel.coupon.records import Loosened, Poured

PACKING_FILE, BED_FILE = "packing.csv", "bed.csv"


class Scattered(NamedTuple):
    """Spheres at random in tall cells, before they fall."""

    cell: Index  # (n,) index of the cell of each sphere
    # (n, 3) and (n,) [m]
    positions: Array
    diameters: Array
    height: float  # of the walls [m]


def scattered(packing: Packing) -> Scattered:
    """Draw the spheres of a packing and scatter them over its cells."""
    outline, count = packing.outline, packing.count
    rng = np.random.default_rng(packing.seed)
    sizes = [
        geometry.poured_sizes(packing.sizes, packing.cell_area, packing.depth, rng)
        for _ in range(count)
    ]
    height = max(
        max(geometry.chimney_height(outline, diameters) for diameters in sizes), 1.5 * packing.depth
    )
    positions = [
        geometry.scatter(outline, height, diameters, rng) + np.array([*centre, 0.0])
        for centre, diameters in zip(packing.centres, sizes, strict=True)
    ]
    cell = np.repeat(np.arange(count), [len(diameters) for diameters in sizes])
    return Scattered(cell, np.concatenate(positions), np.concatenate(sizes), height)


def pour(packing: Packing, folder: Path) -> Poured:
    """Pour a packing and let it settle: ``packing.csv`` in ``folder``.

    Raises
    ------
    UnderFilled
        If the bed is lower than the lid.
    SolverFailure
        If LIGGGHTS fails.
    """
    start = scattered(packing)
    chimneys = geometry.side_walls(packing.outline, packing.centres, start.height)
    floors = geometry.caps(packing.outline, packing.centres, packing.depth)[: packing.count]
    folder.mkdir(parents=True, exist_ok=True)
    spheres = np.column_stack([start.positions, start.diameters])
    walls = start_files.walls_file(np.concatenate([chimneys, floors]))
    _write_start(folder, packing, spheres, start.height, walls)
    settled = _settle(packing, start, folder)
    reach = settled[:, 2] + start.diameters / 2
    top = np.array([reach[start.cell == c].max() for c in range(packing.count)])
    if top.min() < packing.depth:
        raise UnderFilled(
            f"{folder}: the bed of cell {int(top.argmin())} is {top.min():g} m high, the cell "
            f"is {packing.depth:g} m deep"
        )
    full = geometry.full_count(start.cell, settled[:, 2], packing.depth, start.diameters)
    chosen = geometry.lowest(start.cell, settled[:, 2], full)
    volume = math.pi / 6 * float((start.diameters[chosen] ** 3).sum())
    table = np.column_stack([start.cell, settled, start.diameters])
    _write_table(folder / PACKING_FILE, table, "cell,x_m,y_m,z_m,diameter_m")
    return Poured(len(settled), full, volume / (packing.area * packing.depth))


def _settle(packing: Packing, start: Scattered, folder: Path) -> Array:
    """Let scattered spheres fall and come to rest: their centres, (n, 3) [m]."""
    mass = geometry.masses(start.diameters, packing.density)
    time_step = packing.pour_time_step
    fall_time = math.sqrt(2 * start.height / STANDARD_GRAVITY)
    chunk = math.ceil(0.25 * fall_time / time_step)
    momentum_limit = POURING.settled * float((mass * start.diameters).sum()) * STANDARD_GRAVITY
    # terminal speed under drag: g m/c
    text = packing.deck_text(drag=float(mass.mean()) / POURING.fall_time, chunk_steps=chunk)
    dump = folder / "settled.dump"
    with Liggghts(folder, "fill") as solver:
        solver.read_deck(text)
        for _ in range(200):
            step, _, energy = solver.run(chunk, read_energy=True)
            if step * time_step > fall_time and energy < momentum_limit:
                break
        else:
            raise NotSteady(
                f"{folder}: the poured bed still moves after {step * time_step:.2g} s, "
                f"{energy:.2g} J; {momentum_limit:.2g} J counts as rest"
            )
        solver.dump(dump.name)
        solver.finish(step, len(mass))
    settled = output.read_dump(dump.read_text(), str(dump))[-1]
    for path in (dump, folder / deck.START_FILE, folder / deck.WALLS_FILE):
        path.unlink()
    return settled


def loosen(bed: Bed, packing_folder: Path, folder: Path, full: int) -> Loosened:
    """Shake a bed loose: ``bed.csv`` and the walls in ``folder``, which is emptied before.

    The spheres are kept as they are at the instant of the last cycle at which they overlap least,
    since a run may be stiffer than the loosening. ``full`` is N_full of the packing.

    Raises
    ------
    UnderFilled
        If the fill is less than one sphere a cell.
    SolverFailure
        If LIGGGHTS fails.
    """
    count = round(bed.fill_fraction * full)
    if count < 1:
        raise UnderFilled(
            f"{folder}: a fill of {bed.fill_fraction:g} is less than one of {full} spheres a cell"
        )
    cell, poured = read_packing(packing_folder)
    spheres = poured[geometry.lowest(cell, poured[:, 2], count)]
    write_start(folder, bed.packing, spheres)
    run = loosening(bed)
    cycle, steps = run.steps_per_cycle, LOOSENING.cycles * run.steps_per_cycle
    dump = folder / "frames.dump"
    with Liggghts(folder, "loosen") as solver:
        solver.read_deck(run.deck_text())
        solver.run(steps - cycle)
        solver.run_and_dump(cycle, cycle // LOOSENING.frames, dump.name)
        solver.finish(steps, len(spheres))
    frames = output.read_dump(dump.read_text(), str(dump))
    overlaps = [geometry.deepest_overlap(frame, spheres[:, 3]) for frame in frames]
    best = int(np.argmin(overlaps))
    table = np.column_stack([frames[best], spheres[:, 3]])
    _write_table(folder / BED_FILE, table, "x_m,y_m,z_m,diameter_m")
    for path in (dump, folder / deck.START_FILE, folder / deck.cycles_file(1)):
        path.unlink()
    return Loosened(spheres=len(spheres), deepest_overlap_m=overlaps[best])


# ------------------------------------------------------------------ files of spheres and walls


def _write_table(file: Path, table: Array, header: str) -> None:
    np.savetxt(file, table, fmt="%.12g", delimiter=",", header=header, comments="")


def read_packing(folder: Path) -> tuple[Index, Array]:
    """Read the cell of each sphere of a packing, (n,), and x, y, z and diameter, (n, 4) [m]."""
    table = np.loadtxt(folder / PACKING_FILE, delimiter=",", skiprows=1, ndmin=2)
    return table[:, 0].astype(int), table[:, 1:]


def read_bed(folder: Path) -> Array:
    """Read the spheres of a loosened bed: x, y, z and diameter, (n, 4) [m]."""
    return np.loadtxt(folder / BED_FILE, delimiter=",", skiprows=1, ndmin=2)


def write_start(
    folder: Path, packing: Packing, spheres: Array, bed_folder: Path | None = None
) -> None:
    """Empty a folder and write what a shake deck starts from: the spheres and the walls.

    Parameters
    ----------
    spheres
        (n, 4) x, y, z and diameter [m].
    bed_folder
        Folder of a bed in the same cells, whose walls are copied; by default they are made.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if bed_folder is None:
        triangles = geometry.closed_cells(packing.outline, packing.centres, packing.depth)
        walls = start_files.walls_file(triangles)
    else:
        walls = (bed_folder / deck.WALLS_FILE).read_text()
    _write_start(folder, packing, spheres, packing.depth, walls)


def _write_start(folder: Path, packing: Packing, spheres: Array, height: float, walls: str) -> None:
    box = geometry.simulation_box(
        packing.across_flats, packing.centres, height, packing.sizes.largest
    )
    data = start_files.data_file(spheres[:, :3], spheres[:, 3], packing.density, box)
    (folder / deck.WALLS_FILE).write_text(walls)
    (folder / deck.START_FILE).write_text(data)
