"""How a study would run on a cluster, simulated: use of the cores, critical path, files, bytes.

    python benchmarks/cluster.py [study] [--cores 1000] [--minutes 25] [--here] [--as-before]

The jobs are those that Snakemake plans with ``profiles/slurm``. What each takes is its estimate,
on an ordinary core (`runs.ORDINARY_STEP`) or, with ``--here``, on one of 2.5 GHz
(`estimate.USUAL_COSTS`); and the number of cycles of each run is drawn from those of 228 runs of
the study ``paper``. Jobs start the longest first, as soon as what they need is there and a core is
free. ``--as-before`` has each case in one job, cases of 120 s together, forty jobs to a group.
"""

from __future__ import annotations

import argparse
import heapq
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pidpanel.check import checked_study
from pidpanel.coupon.batches import STEP, batches_of, parts_of
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import (
    MISSED,
    USUAL_COSTS,
    Costs,
    bed_seconds,
    cycles_expected,
    run_steps,
    spheres_in,
    travel,
)
from pidpanel.coupon.from_study import distinct_cases

ROOT = Path(__file__).resolve().parents[1]

START = 30.0
"""From a free core to the first step [s]: Slurm, and Snakemake that reads the rules twice, which
takes 10 s each with 50 000 runs."""

LENGTHS = {
    60.0: ((1.0, 1.5, 2.25), (0.67, 0.24, 0.09)),
    200.0: ((1.0, 1.5, 2.25, 3.4, 7.7), (0.45, 0.31, 0.05, 0.12, 0.07)),
    math.inf: ((1.0, 1.5, 2.25, 3.4, 5.1, 7.7), (0.54, 0.14, 0.18, 0.09, 0.03, 0.02)),
}
"""Up to a frequency [Hz]: cycles over the least number, and shares of the runs; 42, 42 and 144 runs
of `paper.yaml` [1]."""

PER_RUN = {"start": (300, 43.0), "restart": (900, 340.0), "last spheres": (200, 68.0)}
PER_CYCLE, PER_CELL_CYCLE = 82.0, 29.0
OTHER, FILES = 18_000.0, 11
"""Bytes of the files of a run: a constant and for each sphere; of a cycle's rows; of decks, logs,
walls and records; how many files there are. Of the runs of `smoke.yaml`."""


@dataclass
class Job:
    """A job with what it waits for and what follows it."""

    seconds: float
    priority: float
    waits: int = 0
    follows: list[Job] = field(default_factory=list)

    def then(self, other: Job) -> None:
        self.follows.append(other)
        other.waits += 1


def simulated(jobs: list[Job], cores: int) -> tuple[float, float]:
    """Time until all jobs are done, and the longest chain of them [s]."""
    ready = [(-job.priority, id(job), job) for job in jobs if not job.waits]
    heapq.heapify(ready)
    running: list[tuple[float, int, Job]] = []
    now, longest, chain = 0.0, 0.0, {id(job): job.seconds for job in jobs if not job.waits}
    while ready or running:
        while ready and len(running) < cores:
            job = heapq.heappop(ready)[2]
            heapq.heappush(running, (now + job.seconds, id(job), job))
        now, _, job = heapq.heappop(running)
        longest = max(longest, chain[id(job)])
        for other in job.follows:
            so_far = chain[id(job)] + other.seconds
            chain[id(other)] = max(chain.get(id(other), 0.0), so_far)
            other.waits -= 1
            if not other.waits:
                heapq.heappush(ready, (-other.priority, id(other), other))
    return now, longest


class Plan:
    """The jobs of the coupons of a study.

    Parameters
    ----------
    cases
        By coupon.
    costs
        Of a step, and of a pour.
    job
        Longest time of a job [s]; infinite for one job a case.
    """

    def __init__(self, cases: dict[str, tuple[Case, ...]], costs: Costs, job: float) -> None:
        self.costs, self.rng, self.limit = costs, np.random.default_rng(1), job
        self.jobs: list[Job] = []
        self.solver = 0.0
        self.longest = 0.0
        self.files, self.bytes, self.runs = 0, 0.0, 0
        of_packing: dict[str, dict[str, Bed]] = {}
        for of_coupon in cases.values():
            for run in (run for case in of_coupon for run in case.runs):
                of_packing.setdefault(run.packing.label, {})[run.bed.label] = run.bed
        beds: dict[str, Job] = {}
        for packing, own in of_packing.items():
            seconds = bed_seconds(own.values(), costs, Path("/nonexistent"))
            beds[packing] = self._job(START + seconds, math.inf)
            self.solver += seconds
        groups: list[Job] = []
        for of_coupon in cases.values():
            for batch in batches_of(of_coupon, job):
                parts = [(case, part) for case in batch.cases for part in parts_of(case, job)]
                if parts:
                    ends = []
                    for case, part in parts:
                        runs = [case.runs[number] for number in part.runs]
                        self.longest = max(self.longest, self._expected(runs, case))
                        took = sum(self._taken(run, case) for run in runs)
                        ends.append((self._legs(took, part.cost), runs))
                    last = self._job(START + 1, 1)
                    for one, runs in ends:
                        self._after_beds(one, runs, beds)
                        one.then(last)
                else:
                    runs = [(run, case) for case in batch.cases for run in case.runs]
                    took = sum(self._taken(run, case) for run, case in runs)
                    expected = sum(self._expected([run], case) for run, case in runs)
                    self.longest = max(self.longest, expected)
                    one = self._legs(took, batch.cost) if job < math.inf else Job(took, batch.cost)
                    if job < math.inf:
                        self.jobs += [one]
                        self._after_beds(one, [run for run, _ in runs], beds)
                    else:
                        groups.append(one)
        if job == math.inf:  # forty at a time, one after the other on the cores they ask for
            for k in range(0, len(groups), 40):
                self.jobs.append(Job(START + max(g.seconds for g in groups[k : k + 40]), 1))
        self.jobs = list({id(one): one for one in self.jobs}.values())

    def _job(self, seconds: float, priority: float) -> Job:
        self.jobs.append(Job(seconds, priority))
        return self.jobs[-1]

    def _legs(self, took: float, priority: float) -> Job:
        """Legs in a row as one job: each ends in time, and begins anew."""
        legs = max(1, math.ceil(took / self.limit))
        return self._job(took + legs * START, priority)

    def _after_beds(self, job: Job, runs: list[Run], beds: dict[str, Job]) -> None:
        """A job waits for its packings: each is one job, with all its beds one after the other."""
        for packing in dict.fromkeys(run.packing.label for run in runs):
            beds[packing].then(job)

    def _expected(self, runs: list[Run], case: Case) -> float:
        return sum(
            run_steps(run, case)
            * self.costs.step.seconds(spheres_in(run.packing, run.fill_fraction), travel(run))
            for run in runs
        )

    def _taken(self, run: Run, case: Case) -> float:
        """Time of a run with a number of cycles that is drawn, and what it leaves."""
        lengths, shares = next(v for f, v in LENGTHS.items() if run.drive.frequency < f)
        ratio = self.rng.choice(lengths, p=shares)
        cycles = min(case.target.max_cycles, cycles_expected(run, case) / MISSED * ratio)
        took = self._expected([run], case) * cycles / cycles_expected(run, case)
        spheres = spheres_in(run.packing, run.fill_fraction)
        self.runs += 1
        self.files += FILES
        self.bytes += OTHER + sum(fixed + each * spheres for fixed, each in PER_RUN.values())
        self.bytes += cycles * (PER_CYCLE + PER_CELL_CYCLE * run.cells_listed)
        self.solver += took
        return took


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", nargs="?", default=ROOT / "workflow/studies/paper_full.yaml")
    parser.add_argument("--cores", type=int, default=1000)
    parser.add_argument("--minutes", type=float, default=25.0)
    parser.add_argument("--here", action="store_true")
    parser.add_argument("--as-before", action="store_true")
    given = parser.parse_args()
    cases = distinct_cases(checked_study(Path(given.study)))
    costs = Costs(STEP, 0.024, 2e-3)
    if given.here:
        costs = USUAL_COSTS
    plan = Plan(cases, costs, math.inf if given.as_before else 60 * given.minutes)
    count = len(plan.jobs)
    makespan, chain = simulated(plan.jobs, given.cores)
    use = plan.solver / given.cores / makespan
    print(
        f"{plan.runs} runs, {plan.solver / 3600:.0f} CPU-h in LIGGGHTS, {count} jobs, the longest "
        f"expected to take {plan.longest / 60:.0f} min\n{given.cores} cores: {makespan / 60:.1f} "
        f"min, {use:.0%} of them in use; critical path {chain / 60:.1f} min\n"
        f"{plan.files} files, {plan.bytes / 1e9:.1f} GB"
    )


if __name__ == "__main__":
    main()
