"""Which cases one process shakes, and which are so long that each of their seeds has its own.

Cheap cases share what a process costs. Where jobs have a time limit, a case that takes longer is
long: its seeds are shaken by jobs of their own (`Part`), each in legs (`attempts.shake_leg`).
"""

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pidpanel.coupon import coding, rows
from pidpanel.coupon.attempts import JUDGING_VERSION, check_sound
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import StepCost, run_steps, spheres_in
from pidpanel.coupon.liggghts.failures import BY_INPUTS, FileDamaged, SolverFailure
from pidpanel.coupon.records import LoosenOutcome, PourOutcome, ShakeOutcome, files_of
from pidpanel.coupon.runs import ORDINARY_STEP, last_file

# CPU time of LIGGGHTS for which a process is begun [s]; it costs 0.4 s itself, and Snakemake as
# much to look after it.
WORTH = 120.0

# Share of the longest time of a job that short runs are put together for [1]: no last job of many
# is long, and what a job costs Slurm and Snakemake is some per cent of it.
SHARE = 0.25

LONG = 0.3  # share of the longest time of a job from which a case is long [1]

# Cost on an ordinary core. It decides which cases share a process; no result depends on it.
STEP = StepCost(*ORDINARY_STEP)


@dataclass(frozen=True)
class Batch:
    """Cases that one process shakes, one after the other."""

    cases: tuple[Case, ...]

    @property
    def label(self) -> str:
        """``<cases>_<hash>``; the hash is that of the labels of the cases and their ends."""
        text = " ".join(f"{case.label}/{case.outcome}" for case in self.cases)
        return f"{len(self.cases)}_{hashlib.sha256(text.encode()).hexdigest()[:8]}"

    @property
    def cost(self) -> float:
        """CPU time that its cases will take on an ordinary core [s]."""
        return sum(map(expected_cost, self.cases))

    @property
    def content(self) -> dict[str, Any]:
        """Content of its file, for `read_cases`."""
        return {"cases": [coding.encode(case) for case in self.cases]}


def read_cases(file: Path) -> list[Case]:
    """Read the cases of the file of a batch."""
    content = json.loads(file.read_text(encoding="utf-8"))
    return [coding.decode(Case, values) for values in content["cases"]]


def expected_cost(case: Case) -> float:
    """Return the CPU time of a case on an ordinary core [s]."""
    return sum(run_cost(run, case) for run in case.runs)


def run_cost(run: Run, case: Case) -> float:
    """Return the CPU time of a run of a case on an ordinary core [s]."""
    return run_steps(run, case) * STEP.seconds(spheres_in(run.packing, run.fill_fraction))


class Part(NamedTuple):
    """Runs of a long case that a job shakes, one after the other, with their CPU time [s].

    Several jobs, its legs, share them. What they take beyond these the last one does when it is
    tried again.
    """

    runs: tuple[int, ...]
    cost: float
    legs: int


def parts_of(case: Case, job: float) -> list[Part]:
    """Return the parts of a case that takes longer than a job of ``job`` [s]; none of others."""
    costs = [run_cost(run, case) for run in case.runs]
    if sum(costs) <= LONG * job:
        return []
    parts: list[Part] = []
    numbers: list[int] = []
    for number in range(len(costs)):
        numbers.append(number)
        done = sum(costs[k] for k in numbers)
        if number + 1 == len(costs) or done + costs[number + 1] > SHARE * job:
            parts.append(Part(tuple(numbers), done, math.ceil(done / job)))
            numbers = []
    return parts


def batches_of(cases: Iterable[Case], job: float = math.inf) -> Iterator[Batch]:
    """Put neighbours in the sweep together until they are worth a process.

    Parameters
    ----------
    job
        Longest time of a job [s]; `SHARE` of it is worth a job, and a long case is alone.
    """
    worth = SHARE * job if job < math.inf else WORTH
    group: list[Case] = []
    cost = 0.0
    for case in cases:
        expected = expected_cost(case)
        if group and (cost >= worth or cost + expected > LONG * job):
            yield Batch(tuple(group))
            group, cost = [], 0.0
        group.append(case)
        cost += expected
    if group:
        yield Batch(tuple(group))


def compare_results(batch: Batch, folder: Path) -> tuple[bool, list[str]]:
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
