"""Whether what runs have left is as they left it, so that what is not is made again."""

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from pidpanel.coupon import coding, rows
from pidpanel.coupon.attempts import JUDGING_VERSION, check_sound
from pidpanel.coupon.batches import Batch
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.liggghts.failures import BY_INPUTS, FileDamaged, SolverFailure
from pidpanel.coupon.records import LoosenOutcome, PourOutcome, ShakeOutcome, files_of
from pidpanel.coupon.runs import last_file


def changes(batch: Batch, folder: Path) -> tuple[bool, list[str]]:
    """Compare what is there in ``results/coupon`` with what a batch left.

    Returns whether it has to be shaken again (intact runs are only evaluated again), and a line
    with the file for each that is damaged, lost or reports a failure of the machine.
    """
    file = folder / "batch" / f"{batch.label}.json"
    if not file.exists():
        return True, []
    try:
        left = json.loads(file.read_bytes())
    except (OSError, ValueError, RecursionError) as error:
        return True, [f"{file}: {error}"]
    if not isinstance(left, dict) or left.get("judging") != JUDGING_VERSION:
        return True, []
    faults = [fault for case in batch.cases for fault in _faults_of_case(case, folder)]
    return bool(faults), list(dict.fromkeys(faults))


def _faults_of_case(case: Case, folder: Path) -> Iterator[str]:
    paths = case.with_reserve.outcomes(folder)
    count = len(case.runs)
    for number, (run, path) in enumerate(zip(case.with_reserve.runs, paths, strict=True)):
        if number >= count:
            return
        try:
            outcome = coding.read(ShakeOutcome, path)
            outcome.check_run(run, path)
            if outcome.target != case.target:
                raise FileDamaged(f"{path}: belongs to another target")
        except SolverFailure as failure:
            yield str(failure)
            continue
        count = max(count, outcome.seeds)
        yield from _faults_of_run(run, outcome, path.parent)
        if fault := _fault_of_bed(run.bed, folder):
            yield fault


def _faults_of_run(run: Run, outcome: ShakeOutcome, folder: Path) -> Iterator[str]:
    shaken = outcome.found
    if shaken is None:
        if outcome.status not in BY_INPUTS:
            yield f"{folder}: {outcome.status} in the last call, tried again"
        return
    try:
        if rows.digest(run, folder, shaken.legs, shaken.cycles) != shaken.rows_digest:
            yield f"{folder}: its rows have changed since they were written"
    except SolverFailure as failure:
        yield str(failure)
    last = last_file(shaken.cycles)
    if files_of(folder, [last])[last] != shaken.last_digest:
        yield f"{folder / last}: missing, damaged or changed since it was written"


@cache
def _fault_of_bed(bed: Bed, folder: Path) -> str:
    packing = folder / "packing" / bed.packing.label / "packing.json"
    bed_file = folder / "bed" / bed.label / "bed.json"
    try:  # deleted files are made again when they are needed
        if packing.exists():
            check_sound(coding.read(PourOutcome, packing), packing)
        if bed_file.exists():
            check_sound(coding.read(LoosenOutcome, bed_file), bed_file)
    except SolverFailure as failure:
        return str(failure)
    return ""
