"""What a pour and a step of a sweep cost on this machine, measured on a few cells of it.

CPU time is measured, so other work on the machine counts little.
"""

from __future__ import annotations

import resource
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import Costs, StepCost, spheres_in, travel
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.preparation import loosen, pour, read_bed, write_start

PROBE_SPHERES = 150
"""About so many spheres are poured for the probe."""

PROBE_STEPS = (500, 3000)
"""The steps between the two are timed."""

Result = TypeVar("Result")


@dataclass(frozen=True)
class Measured:
    """What was run for a probe, and how long it took.

    Attributes
    ----------
    spheres, travel, times
        (n,) of each drive of a bed: its spheres, the diameters moved in a step, CPU time of a
        step [s].
    poured, pour_time
        Spheres poured, and the CPU time of that [s].
    diameter
        [m]
    """

    spheres: Array
    travel: Array
    times: Array
    poured: int
    pour_time: float
    diameter: float

    @property
    def costs(self) -> Costs:
        """As `estimate.cpu_seconds` needs them."""
        step = StepCost.fitted(self.spheres, self.travel, self.times)
        return Costs(step, self.pour_time / self.poured, self.diameter)


def probe(cases: Sequence[Case]) -> Costs:
    """What a pour and a step of these cases cost."""
    return measure(cases).costs


def measure(cases: Sequence[Case]) -> Measured:
    """Pour a few cells of a sweep, loosen them and time some steps of its drives.

    The packing with the fewest spheres in a cell is poured, so that it takes some ten CPU
    seconds; its lowest and highest fill are shaken as gently and as hard as the sweep will.
    """
    packing = min(
        (case.point.packing for case in cases), key=lambda p: spheres_in(p, 1.0) / p.count
    )
    own = [case.point for case in cases if case.point.packing == packing]
    per_cell = spheres_in(packing, 1.0) / packing.count
    count = min(packing.count, max(1, round(PROBE_SPHERES / per_cell)))
    packing = replace(packing, count=count)
    fills = [run.fill_fraction for run in own]
    extremes = (min(own, key=travel), max(own, key=travel))
    table = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pour_time, found = _spent(lambda: pour(packing, folder / "packing"))
        full = found.spheres_full
        # a third of one fill takes the place of the lower one where there is only one
        low = max(min(fills) if min(fills) < max(fills) else min(fills) / 3, 1 / full)
        for fill in (low, max(fills)):
            bed = replace(extremes[0].bed, packing=packing, fill_fraction=fill)
            loosen(bed, folder / "packing", folder / "bed", full)
            spheres = read_bed(folder / "bed")
            for extreme in extremes:
                run = replace(extreme, bed=bed, deck=None)
                write_start(folder / "run", packing, spheres)
                spent = [_steps(run, folder / "run", steps) for steps in PROBE_STEPS]
                time = max(spent[1] - spent[0], 1e-3) / (PROBE_STEPS[1] - PROBE_STEPS[0])
                table.append((len(spheres), travel(run), time))
    spheres_run, moved, times = np.array(table, float).T
    return Measured(spheres_run, moved, times, found.poured, pour_time, packing.diameter)


def _spent(action: Callable[[], Result]) -> tuple[float, Result]:
    """CPU time of the children that an action starts [s], and what it returns."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = action()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, result


def _steps(run: Run, folder: Path, steps: int) -> float:
    """CPU time of LIGGGHTS over so many steps of a run [s]."""

    def execute() -> None:
        with Liggghts(folder, "probe") as solver:
            solver.read_deck(run.deck_text())
            solver.run(steps)
            solver.finish()

    return _spent(execute)[0]
