"""What large sweeps cost besides LIGGGHTS: plans of many runs, and tables of many recorded cases.

    python benchmarks/load.py plan [runs …]      # 2 minutes: dry runs of 10 000 and 100 000 runs
    python benchmarks/load.py gather [cases …]   # 5 minutes: 2000 and 20 000 cases to cases.csv
    python benchmarks/load.py report [cases …]   # 5 minutes: as many from cases.csv to the page

Process CPU time (user and system, of children too) and the largest memory of one process. The
cases of `gather` are copies of one that LIGGGHTS ran: what is measured is how they are read. Those
of `report` are read off the surface of 122 cases that LIGGGHTS ran (tests/damping/data), with their
scatter; the page shows the cycles of one real run. Snakemake's own start is in their numbers.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"

import dataclasses
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import attempts, summary
from pidpanel.coupon.cases import Case
from pidpanel.coupon.from_study import cases_by_coupon, cases_of
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES
from pidpanel.study import load_study
from pidpanel.study.coupon import Coupon

ROOT = Path(__file__).resolve().parents[1]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")
SEEDS = 2


def coupon_study(folder: Path, runs: int) -> Path:
    """A study of the coupon alone with about so many runs of `SEEDS` seeds."""
    fills, levels = [0.1, 0.3, 0.5, 0.7, 0.9], [3, 10, 30, 100, 300]
    frequencies = max(1, round(runs / SEEDS / len(fills) / len(levels)))
    step = 1500 / frequencies
    values = {
        "title": f"{runs} runs",
        "coupon": {
            "cell": {"across_flats_mm": 6.35, "depth_mm": 25, "count": 3},
            "particles": {"diameter_mm": 2.0},
            "sweep": {
                "fill_fraction": fills,
                # 400 Hz and more: at no level a bed crosses its gap, so there is no reserve
                "frequency_hz": [round(500 + step * k, 3) for k in range(frequencies)],
                "acceleration_g": levels,
            },
            "accuracy": {"relative_error": 0.05, "seeds": SEEDS, "min_cycles": 20},
        },
    }
    path = folder / "load.yaml"
    path.write_text(yaml.safe_dump(values))
    return path


def measured(command: list[object]) -> tuple[float, float, str]:
    """CPU seconds and largest memory [MB] of a command, and what it printed."""
    # in a process of its own: the kernel tells the largest memory of all children together
    reader = (
        "import resource, subprocess, sys\n"
        "done = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)\n"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
        "print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1000)\n"
        "sys.stdout.flush()\n"
        "sys.stdout.buffer.write(done.stdout)\n"
        "sys.exit(done.returncode)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", reader, *map(str, command)], capture_output=True, text=True
    )
    first, _, rest = done.stdout.partition("\n")
    if done.returncode:
        sys.exit(f"{command}:\n{rest[-3000:]}{done.stderr[-1000:]}")
    cpu, memory = map(float, first.split())
    return cpu, memory, rest


def plan(sizes: list[int]) -> None:
    """Dry runs of sweeps, locally and as a cluster plans them."""
    for runs in sizes:
        with tempfile.TemporaryDirectory() as name:
            study = coupon_study(Path(name), runs)
            for where, options in (("local", []), ("cluster", ["--config", "job_minutes=25"])):
                command = [SNAKEMAKE, "-s", ROOT / "Snakefile", "-d", name, "-j2", "-n", "--quiet"]
                cpu, memory, said = measured([*command, "rules", "--configfile", study, *options])
                jobs = next(line.split()[1] for line in said.splitlines() if "total" in line)
                print(f"{runs} runs, {where}: {cpu:.1f} CPU-s, {memory:.0f} MB, {jobs} jobs")


def gather(sizes: list[int]) -> None:
    """Tables of recorded cases, each read from its own folders."""
    values = {
        "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 3},
        "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
        "sweep": {"fill_fraction": [0.6], "frequency_hz": [200], "acceleration_g": [10]},
        "accuracy": {"relative_error": 0.2, "seeds": SEEDS, "min_cycles": 20, "min_time_s": 0},
    }
    (case,) = cases_of(Coupon.model_validate(values))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for run in case.runs:
            packing = folder / "packing" / run.packing.label / "packing.json"
            attempts.pour_packing(run.packing, packing)
            attempts.loosen_bed(run.bed, packing, folder / "bed" / run.bed.label / "bed.json")
        attempts.write_case(case, folder, case.outcome_file(folder))
        for size in sizes:
            copies = [dataclasses.replace(case) for _ in range(size)]
            for number, copy in enumerate(copies):
                copy.__dict__["label"] = f"copy{number}"
                for own, copied in zip(case.folders(folder), copy.folders(folder), strict=True):
                    copied.mkdir(parents=True, exist_ok=True)
                    for file in own.iterdir():
                        if not (copied / file.name).exists():
                            os.link(file, copied / file.name)
            before = time.process_time()
            summary.write_table(copies, folder, folder / "cases.csv", coverage=0.0)
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
            spent = time.process_time() - before
            print(f"{size} cases to cases.csv: {spent:.1f} CPU-s, {memory:.0f} MB", flush=True)


PANEL = {
    "title": "Many cases",
    "panel": {
        "outline_m": [1.0, 0.6],
        "section": {"kind": "thin", "mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.07,
                    "thickness_mm": 25},
        "supports": "simply_supported",
        "damping_ratio": 0.02,
        "mesh": {"kind": "quadrilaterals", "elements": [10, 6]},
        "patches": {"PID-1": {"centre_m": [0.5, 0.3], "size_m": [0.4, 0.2]}},
        "points": {"centre": [0.5, 0.3]},
    },
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv", "field": "diffuse", "oaspl_db": 140,
              "pressure_reference": "surface"},
    "response": {"frequency_hz": [50, 500]},
    "scenarios": {"fill": {"patch": "PID-1", "fill_fraction": [0.3, 0.6]}},
}  # fmt: skip
COUPON = {
    "cell": {"across_flats_mm": 6.35, "depth_mm": 25, "count": 1},
    "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
    "sweep": {"fill_fraction": [0.3, 0.6], "frequency_hz": [100], "acceleration_g": [20]},
    "accuracy": {"relative_error": 0.5, "seeds": 1, "min_cycles": 20, "max_cycles": 20,
                 "min_time_s": 0, "state_cycles": 0},
}  # fmt: skip
"""A study of a panel, and its coupon with two cases."""
BED = {**COUPON, "model": "tones"}


def report(sizes: list[int]) -> None:
    """From a table of many cases to the page: surface, forms compared, response, report."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study = folder / "many.yaml"
        study.write_text(
            yaml.safe_dump({**PANEL, "dampers": {"bed": {**COUPON, "model": "tones"}}})
        )
        snakemake = [SNAKEMAKE, "-s", ROOT / "Snakefile", "-d", folder, "-j2"]
        measured([*snakemake, "--configfile", study])
        rules = ["damping", "response", "report"]
        table = folder / "results" / "many" / "coupon" / "bed" / "cases.csv"
        row = pd.read_csv(table).tail(1)
        for size in sizes:
            count = round(size / 25)
            sweep = {
                "fill_fraction": [0.1, 0.3, 0.5, 0.7, 0.9],
                "frequency_hz": [100.0, *np.geomspace(20, 1500, count - 1).round(3).tolist()],
                "acceleration_g": [3, 10, 20, 100, 300],
            }
            study.write_text(
                yaml.safe_dump(
                    {**PANEL, "dampers": {"bed": {**COUPON, "sweep": sweep, "model": "tones"}}}
                )
            )
            cases = cases_by_coupon(load_study(study))["bed"]
            frame = many(row, cases)
            frame.to_csv(table, index=False)
            for rule in rules:
                # the table and the film are taken as they are; Snakemake's own start counts too
                only = ["--allowed-rules", rule, "--forcerun", rule, "--until", rule]
                cpu, memory, _ = measured([*snakemake, "--configfile", study, *only])
                print(f"{len(frame)} cases, {rule}: {cpu:.1f} CPU-s, {memory:.0f} MB", flush=True)


def many(row: pd.DataFrame, cases: dict[str, Case]) -> pd.DataFrame:
    """Rows as those of one that LIGGGHTS ran, with what the surface of real cases says."""
    real = pd.read_csv(ROOT / "tests" / "damping" / "data" / "launch_cases.csv", comment="#")
    surface = DampingSurface.from_frame(real, depth=0.025)
    own = [case.point for case in cases.values()]
    axes = [(r.fill_fraction, r.drive.frequency, r.drive.acceleration) for r in own]
    points = np.array(axes) / (1.0, 1.0, STANDARD_GRAVITY)
    read, rng = surface.evaluate(*points.T), np.random.default_rng(1)
    damping = read.equivalent_damping * np.exp(0.03 * rng.standard_normal(len(points)))
    mass = surface.mass_per_area(1.0) * points[:, 0]
    columns = dict(zip(AXES, points.T, strict=True))
    return pd.concat([row] * len(points), ignore_index=True).assign(
        case=list(cases), **columns,
        equivalent_damping_n_s_m3=damping, equivalent_damping_error_n_s_m3=0.03 * damping,
        apparent_mass_kg_m2=read.apparent_mass, apparent_mass_error_kg_m2=0.05 * mass,
        particle_mass_per_area_kg_m2=mass, status="ok",
    )  # fmt: skip


if __name__ == "__main__":
    what, *sizes = sys.argv[1:]
    if what == "plan":
        plan(list(map(int, sizes)) or [10_000, 100_000])
    elif what == "report":
        report(list(map(int, sizes)) or [2_000, 20_000])
    else:
        gather(list(map(int, sizes)) or [2_000, 20_000])
