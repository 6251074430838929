"""Pour, loosen and shake as jobs: each is tried twice, and what became of it is written down.

A failure is an outcome with a name, so that a sweep continues and its coverage decides. A packing
or a bed that is missing or is not as it was left is made again where it is needed.
"""

import contextlib
import json
import math
import os
import resource
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from pidpanel.coupon import coding, cycles, records, rows, states
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case, RunTarget
from pidpanel.coupon.liggghts import deck, failures
from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.coupon.packing import Packing
from pidpanel.coupon.preparation import BED_FILE, PACKING_FILE, loosen, pour
from pidpanel.coupon.runs import Continues, shake, time_limit
from pidpanel.progress import with_progress
from pidpanel.provenance import durable
from pidpanel.provenance.locks import exclusive_lock

Product = TypeVar("Product")
Outcome = TypeVar("Outcome", bound=records.PourOutcome | records.LoosenOutcome)

# Version of the algorithms that decide from its rows whether a run is steady, long enough or in
# several states, and its errors. With another version every run is evaluated again from its rows.
JUDGING_VERSION = 1


def pour_packing(packing: Packing, file: Path) -> records.PourOutcome:
    """Pour a packing, in the folder of ``packing.json``, and write that."""
    with exclusive_lock(_lock(file.parent)):
        attempt, poured = _attempted(lambda: pour(packing, file.parent), file.parent)
        files = records.files_of(file.parent, (PACKING_FILE,) if poured else ())
        outcome = records.PourOutcome(**vars(attempt), packing=packing, found=poured, files=files)
        coding.write(file, outcome)
    return outcome


def loosen_bed(bed: Bed, packing_file: Path, file: Path) -> records.LoosenOutcome:
    """Shake a bed loose, in the folder of ``bed.json``, and write that or a failed packing."""
    pour_again = partial(pour_packing, bed.packing)
    source = _sound(records.PourOutcome, "packing", bed.packing, packing_file, pour_again)
    poured = source.found
    with exclusive_lock(_lock(file.parent)):
        if poured is None:
            attempt, loosened = _handed_on(source), None
        else:
            full = poured.spheres_full
            attempt, loosened = _attempted(
                lambda: loosen(bed, packing_file.parent, file.parent, full), file.parent
            )
        files = records.files_of(file.parent, (BED_FILE, deck.WALLS_FILE) if loosened else ())
        outcome = records.LoosenOutcome(**vars(attempt), bed=bed, found=loosened, files=files)
        coding.write(file, outcome)
    return outcome


def _lock(folder: Path) -> Path:
    """Return the lock for writing a folder, next to it."""
    return folder.with_name(f".{folder.name}.lock")


def sound_bed(bed: Bed, file: Path) -> records.LoosenOutcome:
    """Return the content of ``bed.json``; a bed with changed files is made again.

    The same spheres to the last bit, so that jobs that do so at the same time do no harm. Its
    packing is looked for in ``../../packing`` of its folder.
    """
    packing = file.parent.parent.parent / "packing" / bed.packing.label / "packing.json"
    return _sound(records.LoosenOutcome, "bed", bed, file, partial(loosen_bed, bed, packing))


def _sound(
    kind: type[Outcome],
    key: str,
    expected: Packing | Bed,
    file: Path,
    make: Callable[[Path], Outcome],
) -> Outcome:
    """Return the record of a file; ``make`` repeats a damaged step in a scratch folder."""
    try:
        outcome = coding.read(kind, file)
        records.check_same(getattr(outcome, key), expected, file)
        check_sound(outcome, file)
    except failures.SolverFailure as failure:
        if file.exists():
            print(f"{failure}; made again", file=sys.stderr)
        file.parent.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".again_", dir=file.parent.parent) as scratch:
            outcome = make(Path(scratch) / "made" / file.name)
            _take(Path(scratch) / "made", file.parent, (*outcome.files, file.name))
    return outcome


def check_sound(outcome: records.PourOutcome | records.LoosenOutcome, file: Path) -> None:
    """Refuse what is not as it was left, and a failure that need not come again."""
    if outcome.status != records.OK and outcome.status not in failures.BY_INPUTS:
        raise failures.RunFailed(outcome.status, f"{file}: {outcome.status}")
    records.check_files(file.parent, outcome.files)


def _take(source: Path, folder: Path, names: Iterable[str]) -> None:
    """Move files into a folder, each at one stroke, as old as what they take the place of."""
    folder.mkdir(exist_ok=True)
    for name in names:
        with contextlib.suppress(FileNotFoundError):  # else Snakemake would make all that follows
            age = (folder / name).stat()
            os.utime(source / name, ns=(age.st_atime_ns, age.st_mtime_ns))
        (source / name).replace(folder / name)


def shake_run(run: Run, target: RunTarget, bed_file: Path, folder: Path) -> records.ShakeOutcome:
    """Shake a run in a folder; hand on the failure of its bed."""
    bed = sound_bed(run.bed, bed_file)
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


def shake_cases(cases: Sequence[Case], folder: Path, file: Path) -> None:
    """Shake all seeds of some cases in ``results/coupon``; write how each ended.

    One process for all of them: what Python imports is paid once.
    """
    ended = {}
    for case in with_progress(cases, "cases"):
        with exclusive_lock(folder / case.label / ".lock"):
            outcomes = shake_case(case, folder)
            paths = case.with_reserve.outcomes(folder)
            for path, outcome in zip(paths, outcomes, strict=False):
                spent = round(outcome.solver_cpu_s + _spent(path), 2)
                coding.write(path, replace(outcome, seeds=len(outcomes), solver_cpu_s=spent))
                ended[str(path.parent.relative_to(folder))] = outcome.status
            for path in paths[len(outcomes) :]:  # of an earlier version that needed them
                path.unlink(missing_ok=True)
    durable.write_text(
        file, json.dumps({"judging": JUDGING_VERSION, "ended": ended}, indent=1) + "\n"
    )


def _spent(file: Path) -> float:
    """Return the CPU time that earlier calls spent on a run [s]: this one goes on from there."""
    try:
        return coding.read(records.ShakeOutcome, file).solver_cpu_s
    except failures.SolverFailure:
        return 0.0


def _attempted(
    action: Callable[[], Product], folder: Path
) -> tuple[records.Attempt, Product | None]:
    """Do it, twice if need be; a failure is kept by its name.

    The first failure may be the machine's; the second is reported. A stopped run continues from
    its last restart; a folder with damaged files is set aside; what any other failure left is
    removed.
    """
    attempts = 0
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    while True:
        attempts += 1
        product: Product | None = None
        status, message = records.OK, ""
        try:
            product = action()
        except failures.SolverMissing:
            raise
        except failures.SolverFailure as failure:
            status, message = type(failure).__name__, str(failure)
        except OSError as error:
            status, message = failures.FilesFailed.__name__, f"{folder}: {error}"
        if status == records.OK or attempts == 2:
            end = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime
            return records.Attempt(
                status, message, attempts, VERSION, round(max(spent, 0.0), 2)
            ), product
        if status in failures.DAMAGED:
            durable.set_aside(folder, message)
        elif status != failures.RunStopped.__name__:
            print(f"{message}; tried again", file=sys.stderr)
            shutil.rmtree(folder, ignore_errors=True)


def _handed_on(attempt: records.Attempt) -> records.Attempt:
    """Return the failure of the step before."""
    return records.Attempt(attempt.status, attempt.message, attempt.attempts, attempt.liggghts, 0.0)


# Status of a leg whose runs go on in the next one, and of one that leaves nothing to do.
CONTINUES, DONE = "continues", "done"


def shake_leg(
    request: Path, previous: Path | None, folder: Path, file: Path, *, seconds: float
) -> None:
    """Shake the runs of a request one after the other, for so long; write how the leg ended.

    The seeds of a long case are shaken by several jobs, its legs. A leg goes on from the restart
    that the one before left, and ends in time with the status `CONTINUES`, or with `DONE`: whether
    a run failed is for the case to find. That runs were shared out changes none of their numbers:
    they go cycle by cycle, and a restart after any of them changes no bit.
    """
    values = json.loads(request.read_text(encoding="utf-8"))
    case = coding.decode(Case, values["case"])
    status = CONTINUES
    if previous is not None:
        status = json.loads(previous.read_text(encoding="utf-8"))["status"]
    if status == CONTINUES:
        try:
            with time_limit(seconds):
                target, folders = first_target(case), case.folders(folder)
                for number in values["runs"]:
                    run = case.runs[number]
                    bed = folder / "bed" / run.bed.label / "bed.json"
                    shake_run(run, target, bed, folders[number])
            status = DONE
        except Continues:
            if values["is_last"]:
                raise
    durable.write_text(file, json.dumps({"status": status}) + "\n")
