"""How long a sweep will take, before it starts: a count of steps and a probe of the machine."""

from __future__ import annotations

import math
import resource
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pidpanel.coupon import bed, deck
from pidpanel.coupon.beds import shake_values, write_start
from pidpanel.coupon.cases import LOOSEN_CYCLES, Bed, Case, Packing, Run, loosening
from pidpanel.coupon.solver import Liggghts
from pidpanel.coupon.window import FRAMES_PER_CONTACT, WINDOW

BULK_FRACTION = 0.45
"""Of a poured bed of equal spheres in cells a few diameters wide (0.43 to 0.48 seen)."""

SCATTER = 0.35
"""Scatter of one cell from cycle to cycle over the mean, its memory included: the error after n
cycles of N cells is `SCATTER`/√(n N). In the paper study's 180 runs its median is 0.28, half of
them lie between 0.11 and 0.53; a little above the median."""

MISSED = 1.7
"""Cycles run over cycles needed, by cost (1.4 in the paper study, 2.5 in `coupon_friction`): a
run that is short of its target grows by half, and a few whose seeds or halves disagree, with a
stroke near the clear gap, take ten times as long."""

PROBE_STEPS = (3000, 6000)
"""The bed has fallen together by the first; what lies between the two is timed."""


@dataclass(frozen=True)
class StepCost:
    """CPU seconds of a step: a constant and a share for each sphere."""

    fixed: float
    per_sphere: float

    def of(self, spheres: float) -> float:
        return self.fixed + self.per_sphere * spheres


def spheres_in(packing: Packing, fill_fraction: float) -> float:
    """Spheres expected in all cells of a bed."""
    volume = math.pi / 6 * packing.sizes.draw(1000, np.random.default_rng(0)) ** 3
    return fill_fraction * BULK_FRACTION * packing.area * packing.depth / float(volume.mean())


def cycles_expected(run: Run, case: Case) -> float:
    """Cycles that a run's target will take.

    The least number, or what the scatter of its cells asks for; never more than the most.
    """
    target = case.target
    needed = SCATTER**2 / (run.packing.count * target.relative_error**2)
    return min(target.max_cycles, MISSED * max(target.min_cycles, needed))


def run_steps(run: Run, case: Case) -> float:
    """Steps of a run with its energy balance, whose output costs as much as a few steps."""
    window = max(1.0, WINDOW * run.frequency) * run.steps_per_cycle
    impact = run.contact_time_at(run.constants.youngs_modulus)
    stride = max(1.0, impact / FRAMES_PER_CONTACT[0] / run.time_step)
    return cycles_expected(run, case) * run.steps_per_cycle + window * (1 + 8 / stride)


def probe(packing: Packing, run: Run) -> StepCost:
    """Time some steps of this machine's LIGGGHTS with few spheres and with many.

    The spheres are dropped at random into the cells and shaken; CPU time is measured, so
    other work on the machine does not count.
    """
    times, counts = [], []
    for share in (0.1, 1.0):
        rng = np.random.default_rng(1)
        per_cell = max(1, round(share * 0.3 * spheres_in(packing, 1.0) / packing.count))
        centres = bed.cell_centres(packing.across_flats, packing.count)
        sizes = packing.sizes.draw(per_cell, rng)
        places = np.concatenate(
            [
                bed.scatter(packing.outline, packing.depth, sizes, rng) + np.array([*centre, 0.0])
                for centre in centres
            ]
        )
        spheres = np.column_stack([places, np.tile(sizes, packing.count)])
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "probe"
            write_start(folder, packing, spheres)
            spent = []
            for steps in PROBE_STEPS:
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                with Liggghts(folder, "probe") as solver:
                    solver.execute(deck.render("shake.in.j2", shake_values(run)))
                    solver.execute(f"run {steps}")
                    solver.finish()
                spent.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
        times.append(max(spent[1] - spent[0], 1e-3) / (PROBE_STEPS[1] - PROBE_STEPS[0]))
        counts.append(len(spheres))
    slope = max((times[1] - times[0]) / (counts[1] - counts[0]), 0.0)
    return StepCost(max(times[0] - slope * counts[0], 1e-6), slope)


PER_JOB = 0.5
"""CPU seconds of a run around LIGGGHTS: Python, its imports, Snakemake."""

POUR_STEPS = 60000
"""Steps of a pour, on the safe side: the paper study's took 37 480."""


def cpu_seconds(cases: Iterable[Case], cost: StepCost, results: Path) -> float:
    """CPU seconds of what is not yet in ``results`` (``results/coupon``) of a sweep."""
    total = 0.0
    beds: set[Bed] = set()
    for case in cases:
        for run, outcome in zip(case.runs, case.outcomes(results), strict=True):
            if outcome.exists():
                continue
            spheres = spheres_in(run.packing, run.fill_fraction)
            total += PER_JOB + run_steps(run, case) * cost.of(spheres)
            if not (results / "bed" / run.bed.label / "bed.json").exists():
                beds.add(run.bed)
    packings: set[Packing] = set()
    for start in beds:
        loosen = loosening(start)
        steps = LOOSEN_CYCLES * loosen.steps_per_cycle
        total += PER_JOB + steps * cost.of(spheres_in(start.packing, start.fill_fraction))
        if not (results / "packing" / start.packing.label / "packing.json").exists():
            packings.add(start.packing)
    for packing in packings:
        total += PER_JOB + POUR_STEPS * cost.of(spheres_in(packing, 1.4))
    return total
