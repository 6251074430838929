"""Run time of a sweep, estimated before it starts: number of steps times cost of a step."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from pidpanel.coupon.bed import LOOSENING, Bed, Run, loosening
from pidpanel.coupon.cases import Case
from pidpanel.coupon.packing import Packing
from pidpanel.coupon.runs import ORDINARY_STEP
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


@dataclass(frozen=True)
class StepCost:
    """CPU time of a step: a constant, a share for each sphere, more for a fast one.

    What moves far in a step (in diameters) has its neighbours looked for more often.
    """

    # [s]
    fixed: float
    per_sphere: float
    per_travel: float = 0.0  # for each sphere and diameter [s]

    def seconds(self, spheres: float, travel: float = 0.0) -> float:
        """Return the CPU time of a step with spheres that move ``travel`` diameters in it [s]."""
        return self.fixed + spheres * (self.per_sphere + self.per_travel * travel)


@dataclass(frozen=True)
class Costs:
    """CPU time on one kind of core."""

    step: StepCost
    poured_sphere: float  # of a pour for each sphere of ``diameter`` [s]
    diameter: float  # [m]


# On a core of 2.5 GHz: measured on cells with 30 and 150 acrylic spheres of 2 mm.
USUAL_COSTS = Costs(StepCost(4.9e-6, 7.1e-8, 2.1e-5), 7.3e-3, 0.002)


def travel(run: Run) -> float:
    """Return the largest motion of the cells in a step, in diameters [1]."""
    return run.drive.speed * run.time_step / run.packing.sizes.smallest


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
    step = StepCost(*ORDINARY_STEP)
    return sum(
        run_steps(run, case) * step.seconds(spheres_in(run.packing, run.fill_fraction))
        for run in case.runs
    )


def run_memory(run: Run) -> float:
    """Return the memory of the process of a run and of LIGGGHTS [bytes]."""
    spheres = spheres_in(run.packing, run.fill_fraction)
    return PROCESS_MEMORY + LIGGGHTS_MEMORY[0] + LIGGGHTS_MEMORY[1] * spheres


def cpu_seconds(cases: Iterable[Case], costs: Costs, results: Path) -> float:
    """Return the CPU time of the part of a sweep that is missing in ``results/coupon`` [s].

    Parameters
    ----------
    results
        The folder ``results/coupon``.
    """
    step = costs.step
    total = 0.0
    beds: set[Bed] = set()
    for case in cases:
        if case.outcome_file(results).exists():
            continue
        for run in case.runs:
            spheres = spheres_in(run.packing, run.fill_fraction)
            total += PER_RUN + run_steps(run, case) * step.seconds(spheres, travel(run))
            beds.add(run.bed)
    return total + bed_seconds(beds, costs, results)


def bed_seconds(beds: Iterable[Bed], costs: Costs, results: Path) -> float:
    """Return the CPU time of beds missing in ``results/coupon``, and of their packings [s]."""
    step, total = costs.step, 0.0
    packings: set[Packing] = set()
    for bed in beds:
        if (results / "bed" / bed.label / "bed.json").exists():
            continue
        loose = loosening(bed)
        spheres = spheres_in(bed.packing, bed.fill_fraction)
        steps = LOOSENING.cycles * loose.steps_per_cycle
        total += PER_JOB + steps * step.seconds(spheres, travel(loose))
        if not (results / "packing" / bed.packing.label / "packing.json").exists():
            packings.add(bed.packing)
    for packing in packings:
        # as many steps more as the spheres are smaller
        sphere = costs.poured_sphere * costs.diameter / packing.diameter
        total += PER_JOB + spheres_in(packing, 1.4) * sphere
    return total
