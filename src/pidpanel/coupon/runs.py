"""Pour a packing, shake a case: what happens in one folder of ``results/coupon``."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import bed, contact, cycles, deck, log
from pidpanel.coupon.cases import (
    POUR_MODULUS,
    Bed,
    Case,
    Packing,
    Run,
    cell_outline,
    loosening,
)
from pidpanel.coupon.solver import VERSION, Liggghts

SETTLED = 1e-7
"""Kinetic energy per sphere over m g d at which a poured bed is at rest."""

FLOOR = 2e-4
"""An error below this share of the inelastic bound ends a run too: a bed that dissipates next
to nothing never reaches an error relative to itself."""


def write_walls(path: Path, packing: Packing, height: float) -> None:
    """STL of the side walls of all cells."""
    import meshio  # slow to import, and not needed by a run that copies its walls

    outline = cell_outline(packing)
    centres = bed.cell_centres(packing.across_flats, packing.count)
    triangles = bed.side_walls(outline, centres, height)
    points = triangles.reshape(-1, 3)
    meshio.Mesh(points, [("triangle", np.arange(len(points)).reshape(-1, 3))]).write(path)


def _box(packing: Packing, height: float) -> bed.Array:
    centres = bed.cell_centres(packing.across_flats, packing.count)
    reach = bed.CELL_SPACING / 2 * packing.across_flats
    low, high = centres.min(axis=0) - reach, centres.max(axis=0) + reach
    # the wall triangles reach twice as high as the walls
    return np.array([[low[0], high[0]], [low[1], high[1]], [-packing.diameter, 2.1 * height]])


def _sphere_mass(packing: Packing) -> float:
    return packing.density * math.pi / 6 * packing.diameter**3


def _harmonic(run: Run, rows: bed.Array, spheres: int) -> tuple[bed.Array, bed.Array]:
    """C_e and m_a of each cycle of a run with so many spheres in all."""
    packing = run.packing
    return cycles.first_harmonic(
        rows[:, log.CYCLE_COLUMNS.index("p_sin")],
        rows[:, log.CYCLE_COLUMNS.index("p_cos")],
        amplitude=run.amplitude,
        frequency=run.frequency,
        mass=spheres * _sphere_mass(packing),
        area=packing.count * bed.polygon_area(cell_outline(packing)),
    )


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
    outline = cell_outline(packing)
    area = bed.polygon_area(outline)
    diameter = packing.diameter
    per_cell = bed.poured_count(area, packing.depth, diameter)
    height = max(bed.chimney_height(outline, diameter, per_cell), 1.5 * packing.depth)
    rng = np.random.default_rng(packing.seed)
    centres = bed.cell_centres(packing.across_flats, packing.count)
    start = np.concatenate(
        [
            bed.scatter(outline, height, diameter, per_cell, rng) + np.array([*centre, 0.0])
            for centre in centres
        ]
    )
    write_walls(folder / "walls.stl", packing, height)
    (folder / "start.data").write_text(
        deck.data_file(start, diameter, packing.density, _box(packing, height))
    )
    rayleigh = contact.rayleigh_time(
        diameter / 2, packing.density, POUR_MODULUS, packing.poissons_ratio
    )
    time_step = 0.25 * rayleigh
    mass = _sphere_mass(packing)
    fall_time = math.sqrt(2 * height / STANDARD_GRAVITY)
    chunk = math.ceil(0.25 * fall_time / time_step)
    text = deck.render(
        "fill.in.j2",
        {
            "data_file": "start.data",
            "walls_file": "walls.stl",
            "skin": 0.3 * diameter,
            "youngs_modulus": POUR_MODULUS,
            "poissons_ratio": packing.poissons_ratio,
            "restitution": 0.5,
            "wall_restitution": 0.5,
            "friction": packing.friction,
            "wall_friction": packing.wall_friction,
            "gravity": STANDARD_GRAVITY,
            # speed under drag: g m/c, the speed reached after a fall of a fifth of a second
            "drag": mass / 0.2,
            "time_step": time_step,
            "chunk_steps": chunk,
        },
    )
    rest = SETTLED * mass * STANDARD_GRAVITY * diameter * len(start)
    with Liggghts(folder, "fill") as solver:
        solver.execute(text)
        for _ in range(200):
            step, _, energy = solver.execute(f"run {chunk}", "ke")
            if step * time_step > fall_time and energy < rest:
                break
        else:
            raise log.NotSteady(
                f"{folder}: the poured bed still moves after {step * time_step:.2g} s, "
                f"{energy:.2g} J against {rest:.2g} J"
            )
        solver.execute("dump settled all custom 1 settled.dump id x y z\nrun 0")
        solver.finish()
    log.check_log(
        (folder / "fill.log").read_text(errors="replace"),
        str(folder / "fill.log"),
        last_step=step,
        atoms=len(start),
    )
    settled = log.read_dump((folder / "settled.dump").read_text(), str(folder / "settled.dump"))[-1]
    cell = np.repeat(np.arange(packing.count), per_cell)
    top = np.array([settled[cell == c, 2].max() for c in range(packing.count)])
    if top.min() + diameter / 2 < packing.depth:
        raise log.UnderFilled(
            f"{folder}: the bed of cell {int(top.argmin())} stands {top.min() + diameter / 2:g} m "
            f"high, the cell is {packing.depth:g} m deep"
        )
    full = bed.full_count(cell, settled[:, 2], packing.depth, diameter)
    volume = math.pi / 6 * diameter**3
    result = {
        "poured": per_cell,
        "spheres_full": full,
        "bulk_fraction": full * volume / (area * packing.depth),
    }
    np.savetxt(
        folder / "packing.csv",
        np.column_stack([cell, settled]),
        fmt=["%d", "%.12g", "%.12g", "%.12g"],
        delimiter=",",
        header="cell,x_m,y_m,z_m",
        comments="",
    )
    for name in ("settled.dump", "start.data", "walls.stl"):
        (folder / name).unlink()
    return result


def _write_start(
    folder: Path, packing: Packing, positions: bed.Array, walls: Path | None = None
) -> None:
    """An emptied folder with what a shake deck reads: the spheres and the walls.

    ``walls`` is an STL of the same cells to copy; left out, it is written anew.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if walls is None:
        write_walls(folder / "walls.stl", packing, packing.depth)
    else:
        shutil.copy(walls, folder / "walls.stl")
    (folder / "start.data").write_text(
        deck.data_file(positions, packing.diameter, packing.density, _box(packing, packing.depth))
    )


FRAMES = 20
"""Frames of the last loosening cycle, of which the one with the least overlap is kept."""


def loosen(start: Bed, packing_folder: Path, folder: Path, full: int) -> dict[str, Any]:
    """Take a packing down to a fill fraction and shake it loose: ``bed.csv``, ``walls.stl``.

    Of the last cycle the moment is kept at which the spheres overlap least, so that a stiffer
    run does not begin with the energy of soft contacts. ``full`` is N_full.

    Returns
    -------
    dict
        ``spheres``, ``deepest_overlap_m``.

    Raises
    ------
    UnderFilled
        If the fill is less than a sphere.
    SolverFailure
        Named after what went wrong.
    """
    packing = start.packing
    table = np.loadtxt(packing_folder / "packing.csv", delimiter=",", skiprows=1, ndmin=2)
    count = round(start.fill_fraction * full)
    if count < 1:
        raise log.UnderFilled(
            f"{folder}: a fill of {start.fill_fraction:g} is less than one of {full} spheres a cell"
        )
    cell = table[:, 0].astype(int)
    positions = table[bed.lowest(cell, table[:, 3], count), 1:]
    _write_start(folder, packing, positions)
    run = loosening(start)
    every = run.steps_per_cycle // FRAMES
    with Liggghts(folder, "loosen") as solver:
        solver.execute(deck.render("shake.in.j2", shake_values(run)))
        solver.execute(f"run {(run.max_cycles - 1) * run.steps_per_cycle}")
        solver.execute(
            f"dump frames all custom {every} frames.dump id x y z\nrun {run.steps_per_cycle}"
        )
        solver.finish()
    log.check_log(
        (folder / "loosen.log").read_text(errors="replace"),
        str(folder / "loosen.log"),
        last_step=run.max_cycles * run.steps_per_cycle,
        atoms=len(positions),
    )
    frames = log.read_dump((folder / "frames.dump").read_text(), str(folder / "frames.dump"))
    overlaps = [bed.deepest_overlap(frame, packing.diameter) for frame in frames]
    best = int(np.argmin(overlaps))
    np.savetxt(
        folder / "bed.csv",
        frames[best],
        fmt="%.12g",
        delimiter=",",
        header="x_m,y_m,z_m",
        comments="",
    )
    for name in ("frames.dump", "start.data", "cycles.txt"):
        (folder / name).unlink()
    return {"spheres": len(positions), "deepest_overlap_m": overlaps[best]}


def shake(run: Run, bed_folder: Path, folder: Path) -> dict[str, Any]:
    """Shake one run until its error target or its last cycle: files in ``folder``.

    Writes ``shake.in`` (runs again under ``liggghts -in``), ``start.data``, ``walls.stl``,
    ``cycles.txt``, ``last.dump``, ``shake.log``. An interrupted run leaves no trace in a
    finished one: the folder is emptied first.

    Returns
    -------
    dict
        ``cycles`` run, ``spheres``, ``ended_by`` ("accuracy" or "max_cycles").

    Raises
    ------
    SolverFailure
        Named after what went wrong.
    """
    packing = run.packing
    positions = np.loadtxt(bed_folder / "bed.csv", delimiter=",", skiprows=1, ndmin=2)
    _write_start(folder, packing, positions, bed_folder / "walls.stl")
    text = deck.render("shake.in.j2", shake_values(run))
    area = packing.count * bed.polygon_area(cell_outline(packing))
    mass = len(positions) * _sphere_mass(packing)
    floor = FLOOR * cycles.inelastic_bound(mass / area, run.frequency)
    done = 0
    wanted = run.min_cycles
    with Liggghts(folder, "shake") as solver:
        solver.execute(text)
        while True:
            step, _, _ = solver.execute(f"run {(wanted - done) * run.steps_per_cycle}")
            done = wanted
            if step != done * run.steps_per_cycle:
                raise log.RunStopped(
                    f"{folder / 'shake.log'}: at step {step}, not {done * run.steps_per_cycle}"
                )
            rows = read_run(run, folder, done)
            damping, _ = _harmonic(run, rows, len(positions))
            found = cycles.estimate(damping)
            good = found.error <= max(run.relative_error * abs(found.mean), floor)
            steady = is_steady(found, done)
            if (good and steady) or done >= run.max_cycles:
                break
            wanted = min(run.max_cycles, math.ceil(1.5 * done))
        solver.execute(f"dump last all custom 1 last.dump id {' '.join(LAST_COLUMNS)}\nrun 0")
        solver.finish()
    log.check_log(
        (folder / "shake.log").read_text(errors="replace"),
        str(folder / "shake.log"),
        last_step=done * run.steps_per_cycle,
        atoms=len(positions),
    )
    return {
        "cycles": done,
        "spheres": len(positions),
        "ended_by": "accuracy" if good and steady else "max_cycles",
    }


LAST_COLUMNS = ("x", "y", "z", "vx", "vy", "vz")
"""Of each sphere at the end of a run, in ``last.dump`` (m, m/s)."""

DRIFT_LIMIT = 3.0
"""Difference of the halves over its error beyond which a run is called drifting."""


def is_steady(found: cycles.Estimate, done: int) -> bool:
    """Whether the transient ended well inside the run and nothing drifts after it."""
    return found.start < 0.45 * done and abs(found.drift) < DRIFT_LIMIT


def _attempt(action: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Do it, twice if need be; a failure is kept by its name.

    The first failure may be the machine's; the second is reported, so that a sweep goes on
    and its coverage decides.
    """
    attempts = 0
    while True:
        attempts += 1
        try:
            outcome = {"status": "ok", "message": "", **action()}
        except log.SolverMissing:
            raise
        except log.SolverFailure as failure:
            outcome = {"status": type(failure).__name__, "message": str(failure)}
        if outcome["status"] == "ok" or attempts == 2:
            return {**outcome, "attempts": attempts, "liggghts": VERSION}


def attempt_pour(packing: Packing, folder: Path) -> dict[str, Any]:
    """Content of ``packing.json``: `pour`, or the name of its failure."""
    return {**_attempt(lambda: pour(packing, folder)), "packing": asdict(packing)}


def attempt_loosen(start: Bed, packing: Path, folder: Path) -> dict[str, Any]:
    """Content of ``bed.json``: `loosen`, or the name of its failure or of its packing's."""
    before = json.loads(packing.read_text())
    outcome = _failed(before) or _attempt(
        lambda: loosen(start, packing.parent, folder, before["spheres_full"])
    )
    return {**outcome, "bed": start.as_dict()}


def attempt_shake(run: Run, start: Path, folder: Path) -> dict[str, Any]:
    """Content of ``run.json``: `shake`, or the name of its failure or of its bed's."""
    before = json.loads(start.read_text())
    outcome = _failed(before) or _attempt(lambda: shake(run, start.parent, folder))
    return {**outcome, "run": run.as_dict()}


def _failed(before: dict[str, Any]) -> dict[str, Any] | None:
    """The outcome that is handed on when an earlier step failed."""
    if before["status"] == "ok":
        return None
    return {key: before[key] for key in ("status", "message", "attempts", "liggghts")}


def summarise(case: Case, folders: list[Path]) -> dict[str, Any]:
    """One row of ``cases.csv``: what was asked, what came out, how sure it is.

    Parameters
    ----------
    case
        The case.
    folders
        Folders of its runs, one a seed, each with its ``run.json``.
    """
    point = case.point
    packing = point.packing
    area = packing.count * bed.polygon_area(cell_outline(packing))
    problems: list[tuple[str, str]] = []
    kept = []
    for run, folder in zip(case.runs, folders, strict=True):
        outcome = json.loads((folder / "run.json").read_text())
        try:
            if outcome["status"] != "ok":
                problems.append((outcome["status"], outcome["message"]))
                continue
            rows = read_run(run, folder, outcome["cycles"])
        except log.SolverFailure as failure:
            problems.append((type(failure).__name__, str(failure)))
            continue
        damping, mass = _harmonic(run, rows, outcome["spheres"])
        found = cycles.estimate(damping)
        kept.append((found, cycles.estimate(mass, start=found.start), outcome))
        if not is_steady(found, len(rows)):
            problems.append(("NotSteady", f"{folder}: not steady after {len(rows)} cycles"))
    c, c_error, m, m_error, spheres = (math.nan,) * 5
    if kept:
        c, c_error = cycles.combine(*np.array([[e.mean, e.error] for e, _, _ in kept]).T)
        m, m_error = cycles.combine(*np.array([[e.mean, e.error] for _, e, _ in kept]).T)
        spheres = float(np.mean([o["spheres"] for _, _, o in kept])) / packing.count
    per_area = spheres * packing.count * _sphere_mass(packing) / area
    bound = cycles.inelastic_bound(per_area, point.frequency)
    target = point.relative_error / math.sqrt(len(case.runs))
    w, f = point.amplitude, point.frequency
    return {
        "case": case.label,
        "fill_fraction": point.fill_fraction,
        "frequency_hz": f,
        "acceleration_g": point.acceleration / STANDARD_GRAVITY,
        "displacement_mm": w * 1e3,
        "velocity_m_s": 2 * math.pi * f * w,
        "diameter_mm": packing.diameter * 1e3,
        "youngs_modulus_mpa": point.youngs_modulus / 1e6,
        "seeds": len(kept),
        "cells": packing.count,
        "spheres_per_cell": spheres,
        "bulk_fraction": spheres
        * math.pi
        / 6
        * packing.diameter**3
        * packing.count
        / (area * packing.depth),
        "particle_mass_per_area_kg_m2": per_area,
        "dissipated_energy_j_m2": cycles.dissipated_energy(c, w, f),
        "dissipated_energy_error_j_m2": cycles.dissipated_energy(c_error, w, f),
        "equivalent_damping_n_s_m3": c,
        "equivalent_damping_error_n_s_m3": c_error,
        "apparent_mass_kg_m2": m,
        "apparent_mass_error_kg_m2": m_error,
        "loss_factor": cycles.loss_factor(c, per_area, f),
        "loss_factor_error": cycles.loss_factor(c_error, per_area, f),
        "bound_n_s_m3": bound,
        "share_of_bound": c / bound,
        "cycles_run": sum(o["cycles"] for _, _, o in kept),
        "cycles_used": sum(e.used for e, _, _ in kept),
        "target_met": bool(c_error <= max(target * abs(c), FLOOR * bound)),
        "ended_by": "max_cycles"
        if any(o["ended_by"] == "max_cycles" for _, _, o in kept)
        else "accuracy",
        "status": problems[0][0] if problems else "ok",
        "message": problems[0][1] if problems else "",
    }


def read_run(run: Run, folder: Path, done: int) -> bed.Array:
    """Cycle rows of a run's folder, checked; see `log.read_cycles`."""
    path = folder / "cycles.txt"
    return log.read_cycles(
        path.read_text(), str(path), steps_per_cycle=run.steps_per_cycle, cycles=done
    )


def shake_values(run: Run) -> dict[str, Any]:
    """The variables of ``templates/shake.in.j2`` for a run."""
    packing = run.packing
    return {
        "data_file": "start.data",
        "walls_file": "walls.stl",
        "cycles_file": "cycles.txt",
        "skin": 0.3 * packing.diameter,
        "youngs_modulus": run.youngs_modulus,
        "poissons_ratio": packing.poissons_ratio,
        "restitution": run.bed.restitution,
        "wall_restitution": run.bed.wall_restitution,
        "friction": packing.friction,
        "wall_friction": packing.wall_friction,
        "depth": packing.depth,
        "gravity": run.bed.gravity,
        "acceleration": run.acceleration,
        "speed": run.acceleration / (2 * math.pi * run.frequency),
        "time_step": run.time_step,
        "steps_per_cycle": run.steps_per_cycle,
        "samples_per_cycle": run.samples_per_cycle,
        "steps_per_sample": run.steps_per_cycle // run.samples_per_cycle,
    }
