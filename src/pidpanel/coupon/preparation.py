"""Pour a packing, shake a bed loose: what happens in ``results/coupon/packing`` and ``bed``."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import contact, geometry
from pidpanel.coupon.cases import LOOSEN_CYCLES, POUR_MODULUS, Bed, Packing, Run, loosening
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.process import Liggghts

SETTLED = 1e-6
"""Kinetic energy per sphere over m g d at which a poured bed is at rest."""

FRAMES = 20
"""Frames of the last loosening cycle, of which the one with the least overlap is kept."""


def wall_triangles(packing: Packing) -> Array:
    """Triangles of the closed cells, sides first, then floors, then lids, (n, 3, 3) m."""
    centres = geometry.cell_centres(packing.across_flats, packing.count)
    sides = geometry.side_walls(packing.outline, centres, packing.depth)
    return np.concatenate([sides, geometry.caps(packing.outline, centres, packing.depth)])


def wall_planes(packing: Packing) -> Array:
    """Plane of each triangle of `wall_triangles`: unit normal into the cell, offset; (n, 4)."""
    corner, along, up = np.moveaxis(wall_triangles(packing), 1, 0)
    normal = np.cross(along - corner, up - corner)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    centres = geometry.cell_centres(packing.across_flats, packing.count)
    middle = np.column_stack([centres, np.full(packing.count, packing.depth / 2)])
    corners = len(packing.outline)
    own = np.concatenate(
        [np.repeat(np.arange(packing.count), corners)] + 2 * [range(packing.count)]
    )
    offset = (normal * corner).sum(axis=1)
    side = np.sign((normal * middle[own]).sum(axis=1) - offset)
    return np.column_stack([side[:, None] * normal, side * offset])


def write_walls(path: Path, triangles: Array) -> None:
    """STL of wall triangles, (n, 3, 3) m."""
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {:.12g} {:.12g} {:.12g}\n".format(*corner) for corner in triangle)
        + "endloop\nendfacet\n"
        for triangle in triangles
    )
    path.write_text(f"solid cells\n{facets}endsolid cells\n")


def _box(packing: Packing, height: float) -> Array:
    centres = geometry.cell_centres(packing.across_flats, packing.count)
    reach = geometry.CELL_SPACING / 2 * packing.across_flats
    low, high = centres.min(axis=0) - reach, centres.max(axis=0) + reach
    # the wall triangles reach twice as high as the walls
    below = -packing.sizes.largest
    return np.array([[low[0], high[0]], [low[1], high[1]], [below, 2.1 * height]])


def contact_model(rolling: bool) -> str:
    """LIGGGHTS' words for the contact law."""
    return "hertz tangential history" + (" rolling_friction cdt" if rolling else "")


def write_start(folder: Path, packing: Packing, spheres: Array, walls: Path | None = None) -> None:
    """An emptied folder with what a shake deck reads: the spheres and the walls.

    ``spheres`` (n, 4) are x, y, z and diameter, m. ``walls`` is an STL of the same cells to
    copy; left out, it is written anew.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if walls is None:
        write_walls(folder / "walls.stl", wall_triangles(packing))
    else:
        shutil.copy(walls, folder / "walls.stl")
    (folder / "start.data").write_text(
        deck.data_file(spheres[:, :3], spheres[:, 3], packing.density, _box(packing, packing.depth))
    )


def read_bed(path: Path) -> Array:
    """The spheres of a ``bed.csv``: x, y, z and diameter, (n, 4) m."""
    return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)


def read_diameters(data: str) -> Array:
    """Diameters of the spheres of a LIGGGHTS data file, (n,) m."""
    rows = data.partition("Atoms\n\n")[2].splitlines()
    return np.array([float(row.split()[2]) for row in rows])


def shake_values(run: Run, leg: int = 1, restart: str | None = None) -> dict[str, Any]:
    """The variables of ``templates/shake.in.j2`` for a run, or a leg of it from a restart."""
    packing, constants = run.packing, run.constants
    values = {
        **vars(constants),
        "contact_model": contact_model(
            bool(constants.rolling_friction or constants.wall_rolling_friction)
        ),
        "data_file": "start.data",
        "walls_file": "walls.stl",
        "cycles_file": f"cycles_{leg}.txt",
        "skin": 0.3 * packing.diameter,
        "depth": packing.depth,
        "gravity": run.bed.gravity,
        "gravity_direction": " ".join(f"{part:.12g}" for part in run.bed.gravity_direction),
        "frequency": run.frequency,
        "amplitude": run.amplitude,
        "acceleration": run.acceleration,
        "speed": run.speed,
        "time_step": run.time_step,
        "steps_per_cycle": run.steps_per_cycle,
        "samples_per_cycle": run.samples_per_cycle,
        "steps_per_sample": run.steps_per_cycle // run.samples_per_cycle,
    }
    return values if restart is None else {**values, "restart_file": restart}


def pour(packing: Packing, folder: Path) -> dict[str, Any]:
    """Pour a bed and let it settle: ``packing.csv`` in ``folder``.

    Returns
    -------
    dict
        ``spheres_full`` (N_full per cell), ``bulk_fraction`` of a full cell, ``poured``.

    Raises
    ------
    UnderFilled
        If the bed stands below the lid.
    SolverFailure
        As the solver has it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    outline = packing.outline
    area = geometry.polygon_area(outline)
    rng = np.random.default_rng(packing.seed)
    poured = [
        geometry.poured_sizes(packing.sizes, area, packing.depth, rng) for _ in range(packing.count)
    ]
    cell = np.repeat(np.arange(packing.count), [len(sizes) for sizes in poured])
    diameters = np.concatenate(poured)
    height = max(
        max(geometry.chimney_height(outline, sizes) for sizes in poured), 1.5 * packing.depth
    )
    centres = geometry.cell_centres(packing.across_flats, packing.count)
    start = np.concatenate(
        [
            geometry.scatter(outline, height, sizes, rng) + np.array([*centre, 0.0])
            for centre, sizes in zip(centres, poured, strict=True)
        ]
    )
    chimneys = geometry.side_walls(outline, centres, height)
    floors = geometry.caps(outline, centres, packing.depth)[: packing.count]
    write_walls(folder / "walls.stl", np.concatenate([chimneys, floors]))
    (folder / "start.data").write_text(
        deck.data_file(start, diameters, packing.density, _box(packing, height))
    )
    smallest, mass = packing.sizes.smallest, geometry.masses(diameters, packing.density)
    time_step = 0.25 * contact.rayleigh_time(
        smallest / 2, packing.density, POUR_MODULUS, packing.poissons_ratio
    )
    fall_time = math.sqrt(2 * height / STANDARD_GRAVITY)
    chunk = math.ceil(0.25 * fall_time / time_step)
    text = deck.render(
        "fill.in.j2",
        {
            "data_file": "start.data",
            "walls_file": "walls.stl",
            "skin": 0.3 * packing.diameter,
            "contact_model": contact_model(rolling=False),
            "youngs_modulus": POUR_MODULUS,
            "wall_youngs_modulus": POUR_MODULUS,
            "poissons_ratio": packing.poissons_ratio,
            "wall_poissons_ratio": packing.poissons_ratio,
            "restitution": 0.5,
            "wall_restitution": 0.5,
            "friction": packing.friction,
            "wall_friction": packing.wall_friction,
            "rolling_friction": 0.0,
            "wall_rolling_friction": 0.0,
            "gravity": STANDARD_GRAVITY,
            # speed under drag: g m/c, the speed reached after a fall of a fifth of a second
            "drag": float(mass.mean()) / 0.2,
            "time_step": time_step,
            "chunk_steps": chunk,
        },
    )
    rest = SETTLED * float((mass * diameters).sum()) * STANDARD_GRAVITY
    with Liggghts(folder, "fill") as solver:
        solver.execute(text)
        for _ in range(200):
            step, _, energy = solver.execute(f"run {chunk}", "ke")
            if step * time_step > fall_time and energy < rest:
                break
        else:
            raise output.NotSteady(
                f"{folder}: the poured bed still moves after {step * time_step:.2g} s, "
                f"{energy:.2g} J against {rest:.2g} J"
            )
        solver.execute("dump settled all custom 1 settled.dump id x y z\nrun 0")
        solver.finish()
    output.check_log(
        (folder / "fill.log").read_text(errors="replace"),
        str(folder / "fill.log"),
        last_step=step,
        atoms=len(start),
    )
    settled = output.read_dump((folder / "settled.dump").read_text(), str(folder / "settled.dump"))[
        -1
    ]
    reach = settled[:, 2] + diameters / 2
    top = np.array([reach[cell == c].max() for c in range(packing.count)])
    if top.min() < packing.depth:
        raise output.UnderFilled(
            f"{folder}: the bed of cell {int(top.argmin())} stands {top.min():g} m high, the cell "
            f"is {packing.depth:g} m deep"
        )
    full = geometry.full_count(cell, settled[:, 2], packing.depth, diameters)
    chosen = geometry.lowest(cell, settled[:, 2], full)
    volume = math.pi / 6 * float((diameters[chosen] ** 3).sum())
    np.savetxt(
        folder / "packing.csv",
        np.column_stack([cell, settled, diameters]),
        fmt=["%d", "%.12g", "%.12g", "%.12g", "%.12g"],
        delimiter=",",
        header="cell,x_m,y_m,z_m,diameter_m",
        comments="",
    )
    for name in ("settled.dump", "start.data", "walls.stl"):
        (folder / name).unlink()
    return {
        "poured": len(start),
        "spheres_full": full,
        "bulk_fraction": volume / (packing.area * packing.depth),
    }


def loosen(start: Bed, packing_folder: Path, folder: Path, full: int) -> dict[str, Any]:
    """Shake a bed loose: ``bed.csv`` and ``walls.stl`` in ``folder``.

    The spheres are kept as they stand at the instant of the last cycle at which they overlap
    least, since a run may be stiffer than the loosening.

    Returns
    -------
    dict
        ``spheres`` in all cells, ``deepest_overlap_m``.

    Raises
    ------
    UnderFilled
        If the fill is less than one sphere a cell.
    SolverFailure
        As the solver has it.
    """
    packing = start.packing
    table = np.loadtxt(packing_folder / "packing.csv", delimiter=",", skiprows=1)
    count = round(start.fill_fraction * full)
    if count < 1:
        raise output.UnderFilled(
            f"{folder}: a fill of {start.fill_fraction:g} is less than one of {full} spheres a cell"
        )
    cell = table[:, 0].astype(int)
    spheres = table[geometry.lowest(cell, table[:, 3], count), 1:]
    write_start(folder, packing, spheres)
    run = loosening(start)
    every = run.steps_per_cycle // FRAMES
    steps = LOOSEN_CYCLES * run.steps_per_cycle
    with Liggghts(folder, "loosen") as solver:
        solver.execute(deck.render("shake.in.j2", shake_values(run)))
        solver.execute(f"run {steps - run.steps_per_cycle}")
        solver.execute(
            f"dump frames all custom {every} frames.dump id x y z\nrun {run.steps_per_cycle}"
        )
        solver.finish()
    output.check_log(
        (folder / "loosen.log").read_text(errors="replace"),
        str(folder / "loosen.log"),
        last_step=steps,
        atoms=len(spheres),
    )
    frames = output.read_dump((folder / "frames.dump").read_text(), str(folder / "frames.dump"))
    overlaps = [geometry.deepest_overlap(frame, spheres[:, 3]) for frame in frames]
    best = int(np.argmin(overlaps))
    np.savetxt(
        folder / "bed.csv",
        np.column_stack([frames[best], spheres[:, 3]]),
        fmt="%.12g",
        delimiter=",",
        header="x_m,y_m,z_m,diameter_m",
        comments="",
    )
    for name in ("frames.dump", "start.data", "cycles_1.txt"):
        (folder / name).unlink()
    return {"spheres": len(spheres), "deepest_overlap_m": overlaps[best]}
