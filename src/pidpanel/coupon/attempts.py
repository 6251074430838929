"""Pour, loosen and shake as jobs: each is tried twice, and what became of it is written down.

A failure that the same inputs give again is an outcome with a name, so that a sweep continues and
its coverage decides. Any other ends the job, and the same command tries again.
"""

import math
import resource
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from pidpanel.coupon import coding, cycles, records, rows, states
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case, RunTarget
from pidpanel.coupon.liggghts import failures
from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.coupon.packing import Packing
from pidpanel.coupon.preparation import loosen, pour
from pidpanel.coupon.runs import shake

Product = TypeVar("Product")

# Version of the algorithms that decide from its rows whether a run is steady, long enough or in
# several states, and its errors. With another version every run is evaluated again from its rows.
JUDGING_VERSION = 1


def pour_packing(packing: Packing, file: Path) -> records.PourOutcome:
    """Pour a packing, in the folder of ``packing.json``, and write that."""
    attempt, poured = _attempted(lambda: pour(packing, file.parent), file.parent)
    outcome = records.PourOutcome(**vars(attempt), packing=packing, found=poured)
    coding.write(file, outcome)
    return outcome


def loosen_bed(bed: Bed, packing_file: Path, file: Path) -> records.LoosenOutcome:
    """Shake a bed loose, in the folder of ``bed.json``, and write that or a failed packing."""
    source = coding.read(records.PourOutcome, packing_file)
    poured = source.found
    if poured is None:
        attempt, loosened = _handed_on(source), None
    else:
        full = poured.spheres_full
        attempt, loosened = _attempted(
            lambda: loosen(bed, packing_file.parent, file.parent, full), file.parent
        )
    outcome = records.LoosenOutcome(**vars(attempt), bed=bed, found=loosened)
    coding.write(file, outcome)
    return outcome


def prepared_bed(bed: Bed, file: Path) -> records.LoosenOutcome:
    """Return the content of ``bed.json``; a bed that is not there is made, from its packing.

    The packing is in ``../../packing`` of its folder. Jobs that do so at the same time write the
    same bits.
    """
    if file.exists():
        return coding.read(records.LoosenOutcome, file)
    packing = file.parent.parent.parent / "packing" / bed.packing.label / "packing.json"
    if not packing.exists():
        pour_packing(bed.packing, packing)
    return loosen_bed(bed, packing, file)


def shake_run(run: Run, target: RunTarget, bed_file: Path, folder: Path) -> records.ShakeOutcome:
    """Shake a run in a folder; hand on the failure of its bed."""
    bed = prepared_bed(run.bed, bed_file)
    if bed.found is None:
        attempt, shaken = _handed_on(bed), None
    else:
        attempt, shaken = _attempted(lambda: shake(run, target, bed_file.parent, folder), folder)
    return records.ShakeOutcome(**vars(attempt), run=run, target=target, found=shaken)


def shake_seeds(case: Case, target: RunTarget, folder: Path) -> list[records.ShakeOutcome]:
    """Shake each seed of a case to a target; seeds that are apart continue.

    A bed can dwell in a state of motion that does not last, and look steady (100 Hz, 80 g,
    μ = 0.1: C_e = 1250 N s/m³ for 60 or 90 cycles, 190 ever after). Where two seeds are apart
    (`states.are_separated`), the shorter continues by half, until they agree or have run
    ``max_cycles``. What they leave is that of the case's own target.
    """
    beds = [folder / "bed" / run.bed.label / "bed.json" for run in case.runs]
    seeds = list(zip(case.runs, beds, case.folders(folder), strict=True))
    outcomes = [shake_run(run, target, bed, home) for run, bed, home in seeds]
    while True:
        shaken = [outcome.found for outcome in outcomes if outcome.found is not None]
        if len(shaken) < len(outcomes):
            break
        damping = []
        for (run, _, home), record in zip(seeds, shaken, strict=True):
            read = rows.read_shaken(run, home, record)
            damping.append(rows.estimates(run, read, record.mass_kg)[0])
        k = min(range(len(shaken)), key=lambda i: shaken[i].cycles)
        done = shaken[k].cycles
        if not seeds_disagree(damping) or done >= target.max_cycles:
            break
        longer = replace(target, min_cycles=min(target.max_cycles, math.ceil(1.5 * done)))
        run, bed, home = seeds[k]
        outcomes[k : k + 1] = _with_time_of([outcomes[k]], [shake_run(run, longer, bed, home)])
    return [replace(outcome, target=case.target) for outcome in outcomes]


def seeds_disagree(damping: Sequence[cycles.Estimate]) -> bool:
    """Return whether the range of values exceeds `states.MARGIN` and four errors."""
    ends = min(damping, key=lambda e: e.mean), max(damping, key=lambda e: e.mean)
    return bool(states.are_separated(*np.array([(end.mean, end.error) for end in ends]).ravel()))


def shake_case(case: Case, folder: Path) -> list[records.ShakeOutcome]:
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
        return _with_time_of(outcomes, shake_seeds(case.with_reserve, longer, folder))
    if first.max_cycles < target.max_cycles:
        longer = replace(target, min_cycles=first.min_cycles)
        outcomes = _with_time_of(outcomes, shake_seeds(case, longer, folder))
    return outcomes


def _with_time_of(
    earlier: Sequence[records.ShakeOutcome], later: Sequence[records.ShakeOutcome]
) -> list[records.ShakeOutcome]:
    """Return outcomes with the CPU time of those before, which are of the same runs."""
    spent = [outcome.solver_cpu_s for outcome in earlier] + [0.0] * (len(later) - len(earlier))
    return [
        replace(outcome, solver_cpu_s=round(outcome.solver_cpu_s + seconds, 2))
        for outcome, seconds in zip(later, spent, strict=True)
    ]


def first_target(case: Case) -> RunTarget:
    """Return the target of each run of a case before the seeds are compared with each other."""
    target = case.target
    if not case.state_cycles:
        return target
    largest = max(target.min_cycles, min(target.max_cycles, case.state_cycles))
    return replace(target, min_cycles=case.least_cycles, max_cycles=largest)


def has_states(case: Case, outcomes: Sequence[records.ShakeOutcome], folder: Path) -> bool:
    """Return whether the cells of the successful runs are in more than one state of motion."""
    estimates = []
    for run, run_folder, outcome in zip(case.runs, case.folders(folder), outcomes, strict=False):
        if outcome.found is not None:
            cells = rows.read_cells(run, run_folder, outcome.found)
            estimates += rows.cell_estimates(run, cells, outcome.found.mass_kg)
    means = np.array([estimate.damping for estimate in estimates])
    errors = np.array([estimate.error for estimate in estimates])
    return len(estimates) > 1 and len(states.states_of(means, errors)) > 1


def write_case(case: Case, folder: Path, file: Path) -> None:
    """Shake the runs of a case in ``results/coupon``, and write how each ended."""
    coding.write(file, records.CaseOutcome(tuple(shake_case(case, folder))))


def _attempted(
    action: Callable[[], Product], folder: Path
) -> tuple[records.Attempt, Product | None]:
    """Do it, twice if need be; a failure by the inputs is kept by its name.

    The first failure may be the machine's; the second counts. A stopped run continues from its
    last restart; what any other failure left, or what cannot be read, is removed.
    """
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    for attempts in (1, 2):
        product: Product | None = None
        status, message = records.OK, ""
        try:
            product = action()
        except (failures.SolverFailure, OSError) as failure:
            status, message = type(failure).__name__, str(failure)
            is_final = attempts == 2 and status not in failures.BY_INPUTS
            if is_final or isinstance(failure, failures.SolverMissing):
                raise
        if status == records.OK:
            break
        if attempts == 1:
            print(f"{message}; tried again", file=sys.stderr, flush=True)
            if status != failures.RunStopped.__name__:
                shutil.rmtree(folder, ignore_errors=True)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime
    attempt = records.Attempt(status, message, attempts, VERSION, round(max(spent, 0.0), 2))
    return attempt, product


def _handed_on(attempt: records.Attempt) -> records.Attempt:
    """Return the failure of the step before."""
    return records.Attempt(attempt.status, attempt.message, attempt.attempts, attempt.liggghts, 0.0)
