"""The LIGGGHTS runs of a study: packings, beds, batches of cases, and legs of long ones.

What a job of them depends on is in its label, so none depends on the package: a request holds the
values that the job needs, and is new only where a batch is to be judged again.
"""

import math
from collections.abc import Iterable

from pidpanel.coupon import coding, finished
from pidpanel.coupon.attempts import JUDGING_VERSION
from pidpanel.coupon.batches import Batch, Part, batches_of, parts_of
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import run_memory
from pidpanel.coupon.from_study import cases_by_coupon, distinct
from pidpanel.coupon.packing import Packing
from pidpanel.paths import COUPON
from pidpanel.provenance import requests
from pidpanel.study import CouponStudy
from pidpanel.workflow.requests import Requests


class CouponRuns:
    """Packings, beds and batches of a study by their labels.

    Coupons of a study share their runs: a case of two of them runs once, to the accuracy of both.
    No batch has cases of two coupons, so a change of one leaves the batches of the others.

    Attributes
    ----------
    job_seconds
        Longest time of a job [s]; infinite without a limit.
    is_open
        Whether any that was requested is not complete.
    """

    def __init__(self, study: CouponStudy, job_requests: Requests, job_seconds: float) -> None:
        self.job_seconds = job_seconds
        self.is_open = False
        self._asked = job_requests
        self._swept = cases_by_coupon(study)
        self.batches: dict[str, Batch] = {}
        self.beds: dict[str, Bed] = {}
        self.packings: dict[str, Packing] = {}
        self._cases: dict[str, Case] = {}
        self._batch_of: dict[str, str] = {}
        for cases in distinct(self._swept).values():
            for batch in batches_of(cases, job_seconds):
                self._add(batch)

    def _add(self, batch: Batch) -> None:
        self.batches[batch.label] = batch
        for case in batch.cases:
            self._cases[case.label] = case
            self._batch_of[case.label] = batch.label
            self.add_beds(run.bed for run in case.runs)

    def add_beds(self, beds: Iterable[Bed]) -> None:
        """Make beds known that no case of the sweep has, and their packings."""
        for bed in beds:
            self.beds[bed.label] = bed
            self.packings[bed.packing.label] = bed.packing

    # ------------------------------------------------------------------ cases

    def swept(self, damper: str) -> list[str]:
        """Return the labels of the cases of a coupon."""
        return list(self._swept[damper])

    def outcomes(self, labels: Iterable[str]) -> list[str]:
        """Return the files of the batches of cases."""
        batches = dict.fromkeys(self._batch_of[label] for label in labels)
        return [str(COUPON / "batch" / f"{batch}.json") for batch in batches]

    # ------------------------------------------------------------------ requests

    def packing(self, label: str) -> str:
        """Return the file of the values of a packing."""
        return self._of_record("packing", label, self.packings[label])

    def bed(self, label: str) -> str:
        """Return the file of the values of a bed."""
        return self._of_record("bed", label, self.beds[label])

    def _of_record(self, kind: str, label: str, record: Packing | Bed) -> str:
        folder = COUPON / kind / label
        request = requests.request_of(folder)
        if self._asked.is_new(request):
            requests.ask(request, coding.encode(record), (), is_made=True)
            self.is_open |= not (folder / f"{kind}.json").exists()
        return str(request)

    def batch(self, label: str) -> str:
        """Return the file of the cases of a batch; new where what they left is not complete."""
        batch, request = self.batches[label], requests.request_of(COUPON / "batch" / label)
        if self._asked.is_new(request):
            is_open, faults = finished.changes(batch, COUPON)
            content = {**batch.content, "judging": JUDGING_VERSION}
            outcome = COUPON / "batch" / f"{label}.json"
            requests.ask(request, content, [outcome], is_made=not is_open)
            self._asked.report(faults)
            self.is_open |= is_open
        return str(request)

    def leg(self, case: str, part: int, leg: int) -> str:
        """Return the request of a leg of a part of a long case."""
        runs, _, legs = self.part(case, part)
        encoded = coding.encode(self._cases[case])
        values = {"case": encoded, "runs": runs, "is_last": leg + 1 == legs}
        return self._asked.job([_leg_file(case, part, leg)], values)

    # ------------------------------------------------------------------ files upstream

    def packing_of(self, bed: str) -> str:
        """Return the packing of a bed."""
        return str(COUPON / "packing" / self.beds[bed].packing.label / "packing.json")

    def beds_of_batch(self, label: str) -> list[str]:
        """Return the beds from which the runs of a batch start."""
        return bed_files(run.bed for case in self.batches[label].cases for run in case.runs)

    def legs_of_batch(self, label: str) -> list[str]:
        """Return the last leg of each part of a batch, where it is one long case."""
        return [
            _leg_file(case.label, number, part.legs - 1)
            for case in self.batches[label].cases
            for number, part in enumerate(parts_of(case, self.job_seconds))
        ]

    def beds_of_part(self, case: str, part: int) -> list[str]:
        """Return the beds of the runs of a part of a long case."""
        runs = self._cases[case].runs
        return bed_files(runs[number].bed for number in self.part(case, part).runs)

    def leg_before(self, case: str, part: int, leg: int) -> list[str]:
        """Return the leg before of the same runs; nothing before the first."""
        return [_leg_file(case, part, leg - 1)] if leg else []

    # ------------------------------------------------------------------ cost

    def part(self, case: str, number: int) -> Part:
        """Return a part of a long case."""
        return parts_of(self._cases[case], self.job_seconds)[number]

    def cost_of_batch(self, label: str) -> int:
        """Return the CPU time of a batch [s]; the longest go first."""
        return int(self.batches[label].cost)

    def cost_from_leg(self, case: str, part: int, leg: int) -> int:
        """Return the CPU time of a leg and those after it [s]."""
        return max(0, int(self.part(case, part).cost - (leg and leg * self.job_seconds)))

    def job_minutes(self, cost: float, attempt: int) -> int:
        """Return the time of a job on a cluster [min], longer where it was not enough."""
        return int(attempt * (5 + min(self.job_seconds, 2 * cost) / 60))

    def memory_of_batch(self, label: str, attempt: int) -> int:
        """Return the memory of a job that shakes a batch [MB]."""
        return attempt * _memory(case.point for case in self.batches[label].cases)

    def memory_of_case(self, label: str, attempt: int) -> int:
        """Return the memory of a job that shakes runs of a case [MB]."""
        return attempt * _memory([self._cases[label].point])

    @property
    def retries(self) -> int | None:
        """Number of times that a job out of time continues from its last restart."""
        return 50 if self.job_seconds < math.inf else None


def bed_files(beds: Iterable[Bed]) -> list[str]:
    """Return the files of beds, each once."""
    labels = dict.fromkeys(bed.label for bed in beds)
    return [str(COUPON / "bed" / label / "bed.json") for label in labels]


def _leg_file(case: str, part: int, leg: int) -> str:
    return str(COUPON / "leg" / case / f"{part}_{leg}.json")


def _memory(runs: Iterable[Run]) -> int:
    return max(int(run_memory(run) / 1e6) for run in runs)
