"""CPU of the coupon stage: where it goes, and what 5 % on C_e costs.

    python benchmarks/coupon.py share      # 15 minutes: LIGGGHTS' share of the paper's sweep,
                                           # and the estimate of it; takes another study as well
    python benchmarks/coupon.py accuracy   # 15 minutes: against the obvious way
    python benchmarks/coupon.py starts     # 30 minutes: from what bed a run had best begin

Process CPU throughout (user and system, of children too), never wall time.
"""

from __future__ import annotations

import dataclasses
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from pidpanel.check import checked_study
from pidpanel.coupon import cycles, rows, runs
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case, RunTarget
from pidpanel.coupon.estimate import PLAN, cpu_seconds
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.geometry import cell_centres, closed_cells, lowest
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.process import Liggghts, check_installed
from pidpanel.coupon.liggghts.start_files import walls_file
from pidpanel.coupon.preparation import (
    BED_FILE,
    loosen,
    pour,
    read_bed,
    read_packing,
    write_start,
)
from pidpanel.study.coupon import Coupon

ROOT = Path(__file__).resolve().parents[1]


def children() -> float:
    """CPU seconds of all children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


TIMED = """#!/bin/bash
TIMEFORMAT='%U %S'
{{ time {liggghts} "$@" 2>&3; }} 3>&2 2>> {times}
"""
"""LIGGGHTS that writes its user and system time when it ends."""


def share(study: str = "workflow/studies/paper.yaml") -> None:
    """LIGGGHTS' share of the CPU of a study's sweep, and the estimate of it beforehand."""
    path = ROOT / study
    coupon = checked_study(path).coupon
    if coupon is None:
        sys.exit(f"{path}: no coupon")
    cases = cases_of(coupon)
    with tempfile.TemporaryDirectory() as name:
        results = Path(name, "results", "coupon")
        expected = PLAN + cpu_seconds(cases, results)
        # every LIGGGHTS tells its own CPU time, whoever started it
        times, timed = Path(name, "times.txt"), Path(name, "bin", "liggghts")
        timed.parent.mkdir()
        timed.write_text(TIMED.format(liggghts=check_installed(), times=times))
        timed.chmod(0o755)
        environment = {**os.environ, "PATH": f"{timed.parent}:{os.environ['PATH']}"}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        table = f"results/{path.stem}/coupon/cases.csv"
        command = [Path(sys.executable).with_name("snakemake"), "-s", ROOT / "Snakefile"]
        command += ["-d", name, "-j2", table, "--configfile", path, "--quiet", "all"]
        before = children()
        subprocess.run(command, check=True, env=environment)
        total = children() - before
        solver = sum(float(word) for word in times.read_text().split())
    print(f"CPU of the sweep {total:.0f} s, in LIGGGHTS {solver:.0f} s: {solver / total:.1%}")
    print(f"estimated {expected:.0f} s: {expected / total:.2f} of what it took")


def point(frequency: float, **changes: object) -> Coupon:
    """2 mm acrylic, half full, 10 g."""
    values = {
        "cell": {"count": 3},
        "time_step_rayleigh": 0.2,
        "sweep": {
            "fill_fraction": [0.5],
            "frequency_hz": [frequency],
            "acceleration_g": [10],
        },
        "accuracy": {"relative_error": 0.05, "seeds": 2, "min_time_s": 0.1, "max_cycles": 2000},
    }
    return Coupon.model_validate(values | changes)


def ours(frequency: float, folder: Path) -> tuple[float, float, float]:
    """CPU seconds of a case of the sweep, its C_e and its error with the bias; beds apart."""
    (case,) = cases_of(point(frequency))
    estimates, spent = [], 0.0
    for run in case.runs:
        own = folder / f"seed{run.packing.seed}"
        full = pour(run.packing, own / "packing").spheres_full
        loosen(run.bed, own / "packing", own / "bed", full)
        before = children()
        outcome = runs.shake(run, case.target, own / "bed", own / "run")
        spent += children() - before
        read = rows.read_rows(run, own / "run", outcome.legs, outcome.cycles)
        found = rows.estimates(run, read, outcome.mass_kg)[0]
        estimates.append((found.mean, found.error))
    value, error = cycles.combine(*np.array(estimates).T)
    return spent, value, np.hypot(error, case.bias * value)


def poured(run: Run, folder: Path) -> tuple[Path, int]:
    """A bed as it was poured, where a run that knows of no loosening begins, and N_full.

    Three cells are poured and repeated in the others; shaken, they part within a few cycles.
    """
    packing = dataclasses.replace(run.packing, count=min(3, run.packing.count))
    full = pour(packing, folder / "packing").spheres_full
    cell, spheres = read_packing(folder / "packing")
    chosen = lowest(cell, spheres[:, 2], round(run.fill_fraction * full))
    cell, spheres = cell[chosen], spheres[chosen]
    few = cell_centres(packing.across_flats, packing.count)
    spheres[:, :2] -= few[cell]
    many = cell_centres(packing.across_flats, run.packing.count)
    bed = folder / "bed"
    bed.mkdir(parents=True)
    np.savetxt(
        bed / BED_FILE,
        np.concatenate(
            [
                spheres[cell == number % packing.count] + np.array([*centre, 0.0, 0.0])
                for number, centre in enumerate(many)
            ]
        ),
        delimiter=",",
        header="x_m,y_m,z_m,diameter_m",
        comments="",
    )
    cells = closed_cells(run.packing.outline, run.packing.centres, run.packing.depth)
    (bed / deck.WALLS_FILE).write_text(walls_file(cells))
    return bed, full


def obvious_case(frequency: float, cells: int) -> Case:
    """Spheres as stiff as they are, cells that move, wall force at every step."""
    (case,) = cases_of(
        point(
            frequency,
            cell={"count": cells},
            stiffness={"choices_mpa": []},
            time_step_rayleigh=0.15,
            deck=ROOT / "templates" / "shake_lab.in.j2",
            accuracy={"relative_error": 0.05, "seeds": 1, "min_time_s": 0.0, "max_cycles": 400},
        )
    )
    return case


def cost_of_steps(case: Case, bed: Path, folder: Path, steps: int = 400) -> float:
    """CPU seconds of so many steps of a case."""
    run = case.point
    write_start(folder, run.packing, read_bed(bed), bed)
    spent = []
    for count in (10, 10 + steps):
        before = children()
        with Liggghts(folder, "cost") as solver:
            solver.read_deck(run.deck_text())
            solver.run(count)
            solver.finish()
        spent.append(children() - before)
    return spent[1] - spent[0]


def obvious(frequency: float, folder: Path) -> tuple[float, float, float]:
    """The same by the obvious way: one whole coupon of 64 cells.

    Spheres as stiff as they are, cells that move, wall force at every step, from the poured
    bed on, until the same rules call it steady and certain. To save an hour a quarter of the
    coupon is run and its CPU multiplied by the measured cost of a step of 64 cells over that
    of 16: the number of cycles is set by the transient, not by the scatter.
    """
    case = obvious_case(frequency, 16)
    bed, _ = poured(case.point, folder / "quarter")
    whole_case = obvious_case(frequency, 64)
    whole_bed, _ = poured(whole_case.point, folder / "whole")
    scale = cost_of_steps(whole_case, whole_bed, folder / "a") / cost_of_steps(
        case, bed, folder / "b"
    )
    before = children()
    outcome = runs.shake(case.point, case.target, bed, folder / "run")
    spent = children() - before
    read = rows.read_rows(case.point, folder / "run", outcome.legs, outcome.cycles)
    found = rows.estimates(case.point, read, outcome.mass_kg)[0]
    print(
        f"  the obvious way: {outcome.cycles} cycles, ended by {outcome.ended_by}; a step of "
        f"64 cells costs {scale:.2f} times one of 16"
    )
    return scale * spent, found.mean, found.error


def accuracy() -> None:
    """CPU to 5 % on C_e at 100 and 500 Hz, ours and the obvious way's."""
    for frequency in (500.0, 100.0):
        with tempfile.TemporaryDirectory() as name:
            cpu, value, error = ours(frequency, Path(name, "ours"))
            print(f"{frequency:g} Hz: ours {cpu:.1f} CPU-s, C_e = {value:.4g} ± {error:.2g}")
            cpu2, value2, error2 = obvious(frequency, Path(name, "obvious"))
            print(
                f"{frequency:g} Hz: the obvious way {cpu2:.1f} CPU-s, C_e = {value2:.4g} ± "
                f"{error2:.2g}; {cpu2 / cpu:.0f} times ours; they differ by "
                f"{(value - value2) / np.hypot(error, error2):+.1f} standard errors",
                flush=True,
            )


def after(run: Run, target: RunTarget, bed: Path, folder: Path) -> Path:
    """The bed that another run leaves behind, brought to rest: a warm start."""
    shaken = runs.shake(run, target, bed, folder / "run")
    last = folder / "run" / runs.last_file(shaken.cycles)
    columns = output.POSITION_AND_VELOCITY
    places = output.read_dump(last.read_text(), str(last), columns)[-1][:, :3]
    diameters = read_bed(bed)[:, 3]
    np.savetxt(
        folder / BED_FILE,
        np.column_stack([places, diameters]),
        delimiter=",",
        header="x_m,y_m,z_m,diameter_m",
        comments="",
    )
    shutil.copy(bed / deck.WALLS_FILE, folder)
    return folder


def first_reading(run: Run, target: RunTarget, read: np.ndarray, mass: float) -> tuple[int, float]:
    """Cycles after which the rules of `runs.shake` would have ended a run, and its C_e then."""
    done = target.min_cycles
    while True:
        found, _ = rows.estimates(run, read[:done], mass)
        good = found.error <= target.relative_error * found.mean and rows.is_steady(found, done)
        if good or done >= len(read):
            return done, found.mean
        done = min(len(read), math.ceil(1.5 * done))


def starts() -> None:
    """Cycles that a run takes, and the C_e it reads, from beds of four kinds.

    As poured; shaken loose once, as we do; as the run at twice the level left it; as the run at
    1.4 times the frequency left it (what a stepped tone in one process would begin with). Each
    is held to the mean over its last two thirds of 300 cycles.
    """
    cycles_run = 300
    for frequency, level in ((100.0, 10.0), (500.0, 10.0), (700.0, 3.0)):
        found: dict[str, list[tuple[int, float, float]]] = {}

        def case_of(frequency: float, level: float) -> Case:
            return cases_of(
                point(
                    frequency,
                    sweep={
                        "fill_fraction": [0.5],
                        "frequency_hz": [frequency],
                        "acceleration_g": [level],
                    },
                    stiffness={"from_acceleration_g": 0},
                    accuracy={"relative_error": 0.05, "seeds": 4, "min_time_s": 0.0},
                )
            )[0]

        case = case_of(frequency, level)
        louder, higher = case_of(frequency, 2 * level), case_of(1.4 * frequency, level)
        target = dataclasses.replace(case.target, min_cycles=12)
        whole = dataclasses.replace(target, min_cycles=cycles_run, max_cycles=cycles_run)
        for run, loud, high in zip(case.runs, louder.runs, higher.runs, strict=True):
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                bed, full = poured(run, folder / "poured")
                loosen(run.bed, folder / "poured" / "packing", folder / "loose", full)
                beds = {
                    "poured": bed,
                    "loosened": folder / "loose",
                    "after twice the level": after(loud, target, folder / "loose", folder / "loud"),
                    "after 1.4 times the frequency": after(
                        high, target, folder / "loose", folder / "high"
                    ),
                }
                for number, (what, start) in enumerate(beds.items()):
                    own = folder / f"run{number}"
                    outcome = runs.shake(run, whole, start, own)
                    read = rows.read_rows(run, own, outcome.legs, cycles_run)
                    damping, _ = rows.harmonic(run, read, outcome.mass_kg)
                    done, value = first_reading(run, target, read, outcome.mass_kg)
                    found.setdefault(what, []).append((done, value, damping[100:].mean()))
        for what, values in found.items():
            done, read, late = np.array(values).T
            scatter = late.std(ddof=1) / np.sqrt(len(late))
            print(
                f"{frequency:g} Hz, {level:g} g, {what}: {done.mean():.0f} cycles, C_e "
                f"{read.mean():.4g}, off its own late mean by {(read / late - 1).mean():+.1%} "
                f"(each {np.sqrt(np.mean((read / late - 1) ** 2)):.1%} rms); late C_e "
                f"{late.mean():.4g} ± {scatter:.2g}",
                flush=True,
            )


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    {"share": share, "accuracy": accuracy, "starts": starts}[sys.argv[1]](*sys.argv[2:])
