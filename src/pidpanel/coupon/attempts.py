"""Pour, loosen and shake as jobs: each is tried twice, and what became of it is written down.

A failure that the same inputs give again is an outcome with a name, so that a sweep continues and
its coverage decides. Any other ends the job, and the same command tries again.
"""

import math
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from pidpanel.coupon import cycles, records, rows, states
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case, RunTarget
from pidpanel.coupon.liggghts import failures
from pidpanel.coupon.packing import Packing
from pidpanel.coupon.preparation import loosen, pour
from pidpanel.coupon.records import Loosened, Outcome, Poured, Shaken
from pidpanel.coupon.runs import shake

Product = TypeVar("Product")

# Version of the algorithms that decide from its rows whether a run is steady, long enough or in
# several states, and its errors. With another version every run is evaluated again from its rows.
JUDGING_VERSION = 1


def pour_packing(packing: Packing, file: Path) -> Outcome[Poured]:
    """Pour a packing, in the folder of ``packing.json``, and write that."""
    outcome = _attempted(lambda: pour(packing, file.parent), file.parent)
    records.write(file, outcome)
    return outcome


def loosen_bed(bed: Bed, packing_file: Path, file: Path) -> Outcome[Loosened]:
    """Shake a bed loose, in the folder of ``bed.json``, and write that or a failed packing."""
    poured, folder = records.read(Outcome[Poured], packing_file), file.parent
    outcome = _attempted(
        lambda: loosen(bed, packing_file.parent, folder, poured.product.spheres_full), folder
    )
    records.write(file, outcome)
    return outcome


def prepared_bed(bed: Bed, file: Path) -> Outcome[Loosened]:
    """Return the content of ``bed.json``; a bed that is not there is made, from its packing.

    The packing is in ``../../packing`` of its folder. Jobs that do so at the same time write the
    same bits.
    """
    if file.exists():
        return records.read(Outcome[Loosened], file)
    packing = file.parent.parent.parent / "packing" / bed.packing.label / "packing.json"
    if not packing.exists():
        pour_packing(bed.packing, packing)
    return loosen_bed(bed, packing, file)


def shake_run(run: Run, target: RunTarget, bed_file: Path, folder: Path) -> Outcome[Shaken]:
    """Shake a run in a folder; hand on the failure of its bed."""
    bed = prepared_bed(run.bed, bed_file)
    if bed.found is None:
        return Outcome(bed.status, bed.message, None)
    return _attempted(lambda: shake(run, target, bed_file.parent, folder), folder)


def shake_seeds(case: Case, target: RunTarget, folder: Path) -> list[Outcome[Shaken]]:
    """Shake each seed of a case to a target; seeds that are apart continue.

    A bed can dwell in a state of motion that does not last, and look steady (100 Hz, 80 g,
    μ = 0.1: C_e = 1250 N s/m³ for 60 or 90 cycles, 190 ever after). Where two seeds are apart
    (`states.are_separated`), the shorter continues by half, until they agree or have run
    ``max_cycles``.
    """
    beds = [folder / "bed" / run.bed.label / "bed.json" for run in case.runs]
    seeds = list(zip(case.runs, beds, case.folders(folder), strict=True))
    outcomes = [shake_run(run, target, bed, home) for run, bed, home in seeds]
    while True:
        shaken = [outcome.found for outcome in outcomes if outcome.found is not None]
        if len(shaken) < len(outcomes):
            return outcomes
        damping = [
            rows.estimates(run, rows.read_shaken(run, home, record), record.mass_kg)[0]
            for (run, _, home), record in zip(seeds, shaken, strict=True)
        ]
        k = min(range(len(shaken)), key=lambda i: shaken[i].cycles)
        done = shaken[k].cycles
        if not seeds_disagree(damping) or done >= target.max_cycles:
            return outcomes
        longer = replace(target, min_cycles=min(target.max_cycles, math.ceil(1.5 * done)))
        run, bed, home = seeds[k]
        outcomes[k] = shake_run(run, longer, bed, home)


def seeds_disagree(damping: Sequence[cycles.Estimate]) -> bool:
    """Return whether the range of values exceeds `states.MARGIN` and four errors."""
    ends = min(damping, key=lambda e: e.mean), max(damping, key=lambda e: e.mean)
    return bool(states.are_separated(*np.array([(end.mean, end.error) for end in ends]).ravel()))


def shake_case(case: Case, folder: Path) -> list[Outcome[Shaken]]:
    """Shake the seeds of a case, and those of its reserve if its cells end in several states.

    A case of which that is possible lasts at least a third of ``state_cycles``. With several states
    all its runs last ``state_cycles``, and no longer on account of being apart: they need not ever
    agree. Returns the outcomes of the case or, with several states, of `Case.with_reserve`.
    """
    target, first = case.target, first_target(case)
    outcomes = shake_seeds(case, first, folder)
    if not case.state_cycles:
        return outcomes
    if has_states(case, outcomes, folder):
        longer = replace(target, min_cycles=first.max_cycles, max_cycles=first.max_cycles)
        return shake_seeds(case.with_reserve, longer, folder)
    if first.max_cycles < target.max_cycles:
        longer = replace(target, min_cycles=first.min_cycles)
        return shake_seeds(case, longer, folder)
    return outcomes


def first_target(case: Case) -> RunTarget:
    """Return the target of each run of a case before the seeds are compared with each other."""
    target = case.target
    if not case.state_cycles:
        return target
    largest = max(target.min_cycles, min(target.max_cycles, case.state_cycles))
    return replace(target, min_cycles=case.least_cycles, max_cycles=largest)


def has_states(case: Case, outcomes: Sequence[Outcome[Shaken]], folder: Path) -> bool:
    """Return whether the cells of the successful runs are in more than one state of motion."""
    estimates = [
        rows.cell_estimates(run, rows.read_cells(run, home, shaken), shaken.mass_kg)
        for run, home, outcome in zip(case.runs, case.folders(folder), outcomes, strict=False)
        if (shaken := outcome.found) is not None
    ]
    return bool(estimates) and len(states.states_of(*np.hstack(estimates)[:2])) > 1


def write_case(case: Case, folder: Path, file: Path) -> None:
    """Shake the runs of a case in ``results/coupon``, and write how each ended."""
    records.write(file, records.CaseOutcome(tuple(shake_case(case, folder))))


def _attempted(action: Callable[[], Product], folder: Path) -> Outcome[Product]:
    """Do it, twice if need be; a failure by the inputs, or of the step before, is kept by its name.

    The first failure may be the machine's; the second counts. A stopped run continues from its
    last restart; what any other failure left, or what cannot be read, is removed.
    """
    for is_last in (False, True):
        try:
            return Outcome(records.OK, "", action())
        except failures.RunFailed as failure:
            return Outcome(failure.status, str(failure), None)
        except (failures.SolverFailure, OSError) as failure:
            status, message = type(failure).__name__, str(failure)
            is_final = is_last and status not in failures.BY_INPUTS
            if is_final or isinstance(failure, failures.SolverMissing):
                raise
        if not is_last:
            print(f"{message}; tried again", file=sys.stderr, flush=True)
            if status != failures.RunStopped.__name__:
                shutil.rmtree(folder, ignore_errors=True)
    return Outcome(status, message, None)
