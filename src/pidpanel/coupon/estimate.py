"""Run time of a sweep, estimated before it starts: number of steps times cost of a step."""

import math
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

from pidpanel.coupon.bed import LOOSENING, Bed, Run, loosening
from pidpanel.coupon.cases import Case
from pidpanel.coupon.packing import Packing
from pidpanel.coupon.runs import ordinary_step
from pidpanel.coupon.window import FRAMES_PER_CONTACT, WINDOW
from pidpanel.geometry.cells import bulk_fraction
from pidpanel.geometry.sizes import Sizes

# Scatter of one cell from cycle to cycle over the mean [1], its memory included: the error after
# n cycles of N cells is `SCATTER`/√(n N). In 319 runs of six studies it lies between 0.09 and 0.43
# for half of them.
SCATTER = 0.35

# Cycles run over cycles needed, by cost [1] (1.2 in the paper study, 1.5 to 2.1 in those of
# friction, restitution, gravity, modulus and time step): a run that is short of its target grows
# by half, and one in twenty takes eight times as long.
MISSED = 1.6

PER_JOB = 0.4  # CPU time of a process besides LIGGGHTS [s]: Python and its imports

PLAN = 3.0  # CPU time of Snakemake from its start to the first job, and of the table of cases [s]

PER_RUN = 0.15  # CPU time of a run in that process [s]: its decks, its rows, its energy balance


# Memory of a process with numpy and the lists of contacts of an energy balance [bytes].
PROCESS_MEMORY = 300e6

LIGGGHTS_MEMORY = 60e6, 2e4  # memory of LIGGGHTS, and of each sphere in it [bytes]


# On a core of 2.5 GHz, measured on cells with 30 and 150 acrylic spheres of 2 mm [s]: CPU time of a
# step, a share for each sphere, and more for each diameter that it moves in the step, since what
# moves far has its neighbours looked for more often; of a pour for each sphere of 2 mm.
STEP, PER_SPHERE, PER_TRAVEL = 4.9e-6, 7.1e-8, 2.1e-5
POURED_SPHERE, POURED_DIAMETER = 7.3e-3, 0.002


def steps_seconds(run: Run, steps: float) -> float:
    """Return the CPU time of steps of a run [s]."""
    travel = run.drive.speed * run.time_step / run.packing.sizes.smallest
    spheres = spheres_in(run.packing, run.fill_fraction)
    return steps * (STEP + spheres * (PER_SPHERE + PER_TRAVEL * travel))


def spheres_in(packing: Packing, fill_fraction: float) -> float:
    """Return the expected number of spheres in all cells of a bed."""
    volume = _mean_volume(packing.sizes)
    bulk = bulk_fraction(packing.diameter, packing.across_flats)
    return fill_fraction * bulk * packing.area * packing.depth / volume


@cache
def _mean_volume(sizes: Sizes) -> float:
    """Return the mean volume of a sphere [m³]."""
    return float((math.pi / 6 * sizes.draw(1000, np.random.default_rng(0)) ** 3).mean())


def cycles_expected(run: Run, case: Case) -> float:
    """Return the cycles that a run's target will take.

    The least number, or what the scatter of its cells asks for; never more than the most.
    """
    target = case.target
    needed = SCATTER**2 / (run.packing.count * target.relative_error**2)
    return min(target.max_cycles, MISSED * max(case.least_cycles, needed))


def run_steps(run: Run, case: Case) -> float:
    """Return the steps of a run with its energy balance, whose output costs a few steps."""
    window = max(1.0, WINDOW * run.drive.frequency) * run.steps_per_cycle
    impact = run.contact_time_at(run.constants.youngs_modulus)
    stride = max(1.0, impact / FRAMES_PER_CONTACT[0] / run.time_step)
    cycles = run.cycles_before + cycles_expected(run, case)
    return cycles * run.steps_per_cycle + window * (1 + 8 / stride)


def case_seconds(case: Case) -> float:
    """Return the CPU time of a case on an ordinary core [s]; the longest go first."""
    return sum(
        run_steps(run, case) * ordinary_step(spheres_in(run.packing, run.fill_fraction))
        for run in case.runs
    )


def run_memory(run: Run) -> float:
    """Return the memory of the process of a run and of LIGGGHTS [bytes]."""
    spheres = spheres_in(run.packing, run.fill_fraction)
    return PROCESS_MEMORY + LIGGGHTS_MEMORY[0] + LIGGGHTS_MEMORY[1] * spheres


def cpu_seconds(cases: Iterable[Case], results: Path) -> float:
    """Return the CPU time of cases with their beds, where missing in ``results/coupon`` [s].

    Parameters
    ----------
    results
        The folder ``results/coupon``.
    """
    runs = [(run, case) for case in cases for run in case.runs]
    total = sum(PER_RUN + steps_seconds(run, run_steps(run, case)) for run, case in runs)
    beds = {bed for bed in {run.bed for run, _ in runs} if not _is_made(results, "bed", bed)}
    for run in map(loosening, beds):
        total += PER_JOB + steps_seconds(run, LOOSENING.cycles * run.steps_per_cycle)
    for packing in {bed.packing for bed in beds}:
        if not _is_made(results, "packing", packing):
            # as many steps more as the spheres are smaller
            sphere = POURED_SPHERE * POURED_DIAMETER / packing.diameter
            total += PER_JOB + spheres_in(packing, 1.4) * sphere
    return total


def _is_made(results: Path, kind: str, made: Bed | Packing) -> bool:
    return (results / kind / made.label / f"{kind}.json").exists()
