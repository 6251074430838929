"""How long a sweep will take, before it starts: a count of steps and a probe of the machine."""

from __future__ import annotations

import math
import resource
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.coupon.cases import LOOSEN_CYCLES, Bed, Case, Packing, Run, loosening
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.preparation import loosen, pour, read_bed, shake_values, write_start
from pidpanel.coupon.window import FRAMES_PER_CONTACT, WINDOW

BULK_FRACTION = 0.45
"""Of a poured bed of equal spheres in cells a few diameters wide (0.43 to 0.48 seen)."""

SCATTER = 0.35
"""Scatter of one cell from cycle to cycle over the mean, its memory included: the error after n
cycles of N cells is `SCATTER`/√(n N). In 319 runs of six studies it lies between 0.09 and 0.43
for half of them."""

MISSED = 1.6
"""Cycles run over cycles needed, by cost (1.2 in the paper study, 1.5 to 2.1 in those of
friction, restitution, gravity, modulus and time step): a run that is short of its target grows
by half, and one in twenty takes eight times as long."""

PROBE_SPHERES = 150
"""About so many spheres are poured for the probe."""

PROBE_STEPS = (500, 3000)
"""What lies between the two is timed."""

PER_JOB = 0.4
"""CPU seconds of a process besides LIGGGHTS: Python and its imports."""

PER_RUN = 0.15
"""CPU seconds of a run in that process: its decks, its rows, its energy balance."""


@dataclass(frozen=True)
class StepCost:
    """CPU seconds of a step: a constant, a share for each sphere, more for a fast one.

    What moves far in a step (in diameters) has its neighbours looked for more often.
    """

    fixed: float
    per_sphere: float
    per_travel: float = 0.0
    """For each sphere and diameter."""

    def of(self, spheres: float, travel: float = 0.0) -> float:
        """Of so many spheres that move ``travel`` diameters in a step."""
        return self.fixed + spheres * (self.per_sphere + self.per_travel * travel)


@dataclass(frozen=True)
class Costs:
    """What a probe has measured on this machine."""

    step: StepCost
    poured_sphere: float
    """CPU seconds of a pour for each sphere of `diameter`."""
    diameter: float


def travel(run: Run) -> float:
    """Diameters that the cells move in a step at their fastest."""
    return run.speed * run.time_step / run.packing.sizes.smallest


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


def _spent(action: Callable[[], Any]) -> tuple[float, Any]:
    """CPU seconds of the children that an action starts, and what it returns."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = action()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, result


def probe(cases: Sequence[Case]) -> Costs:
    """Pour a few cells of this sweep, loosen them and time some steps of its drives.

    The packing with the fewest spheres in a cell is poured, so that it takes some ten CPU
    seconds; its lowest and highest fill are shaken as gently and as hard as the sweep will.
    CPU time is measured, so other work on the machine counts little.
    """
    packing = min(
        (case.point.packing for case in cases), key=lambda p: spheres_in(p, 1.0) / p.count
    )
    own = [case.point for case in cases if case.point.packing == packing]
    per_cell = spheres_in(packing, 1.0) / packing.count
    count = min(packing.count, max(1, round(PROBE_SPHERES / per_cell)))
    packing = replace(packing, count=count)
    fills = [run.fill_fraction for run in own]
    drives = (min(own, key=travel), max(own, key=travel))
    rows, times = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        poured, found = _spent(lambda: pour(packing, folder / "packing"))
        full = found["spheres_full"]
        # a third of one fill stands for the lower one where there is only one
        low = max(min(fills) if min(fills) < max(fills) else min(fills) / 3, 1 / full)
        for fill in (low, max(fills)):
            bed = replace(drives[0].bed, packing=packing, fill_fraction=fill)
            loosen(bed, folder / "packing", folder / "bed", full)
            spheres = read_bed(folder / "bed" / "bed.csv")
            for drive in drives:
                run = replace(drive, bed=bed)
                write_start(folder / "run", packing, spheres)
                spent = [_steps(run, folder / "run", steps) for steps in PROBE_STEPS]
                rows.append((1.0, len(spheres), len(spheres) * travel(run)))
                times.append(max(spent[1] - spent[0], 1e-3) / (PROBE_STEPS[1] - PROBE_STEPS[0]))
    return Costs(
        _fitted(np.array(rows), np.array(times)), poured / found["poured"], packing.diameter
    )


def _steps(run: Run, folder: Path, steps: int) -> float:
    """CPU seconds of LIGGGHTS over so many steps of a run."""

    def execute() -> None:
        with Liggghts(folder, "probe") as solver:
            solver.execute(deck.render("shake.in.j2", shake_values(run)))
            solver.execute(f"run {steps}")
            solver.finish()

    return _spent(execute)[0]


def _fitted(rows: np.ndarray, times: np.ndarray) -> StepCost:
    """Least squares with no negative share; times in relative terms."""
    # active set of three: leave out what comes out negative, last first
    for kept in ([0, 1, 2], [0, 1], [1]):
        weighted = rows[:, kept] / times[:, None]
        found = np.zeros(3)
        found[kept] = np.linalg.lstsq(weighted, np.ones(len(times)), rcond=None)[0]
        if (found >= 0).all():
            break
    return StepCost(*found.tolist())


def cpu_seconds(cases: Iterable[Case], costs: Costs, results: Path) -> float:
    """CPU seconds of what is not yet in ``results`` (``results/coupon``) of a sweep."""
    step = costs.step
    total = 0.0
    beds: set[Bed] = set()
    for case in cases:
        for run, outcome in zip(case.runs, case.outcomes(results), strict=True):
            if outcome.exists():
                continue
            spheres = spheres_in(run.packing, run.fill_fraction)
            total += PER_RUN + run_steps(run, case) * step.of(spheres, travel(run))
            if not (results / "bed" / run.bed.label / "bed.json").exists():
                beds.add(run.bed)
    packings: set[Packing] = set()
    for start in beds:
        drive = loosening(start)
        spheres = spheres_in(start.packing, start.fill_fraction)
        steps = LOOSEN_CYCLES * drive.steps_per_cycle
        total += PER_JOB + steps * step.of(spheres, travel(drive))
        if not (results / "packing" / start.packing.label / "packing.json").exists():
            packings.add(start.packing)
    for packing in packings:
        # as many steps more as the spheres are smaller
        sphere = costs.poured_sphere * costs.diameter / packing.diameter
        total += PER_JOB + spheres_in(packing, 1.4) * sphere
    return total
