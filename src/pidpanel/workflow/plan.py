"""Plan of the workflow: a study, its LIGGGHTS runs, and the requests of its jobs."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import yaml

from pidpanel.check import check_machine, checked_study
from pidpanel.coupon import coding
from pidpanel.coupon.attempts import JUDGING_VERSION
from pidpanel.coupon.batches import Batch, Part, batches_of, compare_results, parts_of
from pidpanel.coupon.bed import Bed
from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import run_memory
from pidpanel.coupon.from_study import cases_by_coupon, distinct
from pidpanel.coupon.packing import Packing
from pidpanel.paths import COUPON, PACKAGE, SECTION, WORKFLOW, of_damper, study_path
from pidpanel.provenance import digests, locks, requests
from pidpanel.provenance.job import JOB_SECONDS, STUDY
from pidpanel.provenance.owner import check_owner, write_owner
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.workflow.rules import Rule


class CouponRuns:
    """Packings, beds and batches of a study by their labels.

    Coupons of a study share their runs: a case of two of them runs once, to the accuracy of both.
    No batch has cases of two coupons, so a change of one leaves the batches of the others. What a
    job depends on is in its label, so none depends on the package: a request holds the values that
    the job needs, and is new only where a batch is to be judged again.

    Attributes
    ----------
    job_seconds
        Longest time of a job [s]; infinite without a limit.
    is_open
        Whether any that was requested is not complete.
    """

    def __init__(self, study: CouponStudy, queue: requests.Requests, job_seconds: float) -> None:
        self.job_seconds = job_seconds
        self.is_open = False
        self._asked = queue
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
            is_open, faults = compare_results(batch, COUPON)
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
        cases = self.batches[label].cases
        return max(self.memory_of_case(case.label, attempt) for case in cases)

    def memory_of_case(self, label: str, attempt: int) -> int:
        """Return the memory of a job that shakes runs of a case [MB]."""
        return attempt * int(run_memory(self._cases[label].point) / 1e6)

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


# Keys of a configuration that are not of a study.
SETTINGS = frozenset({"study", "job_minutes", "container"})


def has_study(config: Mapping[str, Any]) -> bool:
    """Return whether a configuration names a study or is one."""
    return "study" in config or bool(config.keys() - SETTINGS)


def study_file(config: Mapping[str, Any], files: Sequence[str | Path]) -> Path:
    """Return the file of the study that a configuration names or is."""
    if "study" in config:
        name = str(config["study"])
        if values := sorted(config.keys() & Study.model_fields.keys() - SETTINGS):
            raise StudyError(f"{name}: {values[0]}: {ONE_FILE}")
        return study_path(name).resolve()
    keys = sorted(config.keys() - SETTINGS)
    if keys and not files:
        raise StudyError(f"--config {keys[0]}: {NO_VALUE}")
    if not keys:
        raise StudyError(
            "no study: snakemake --configfile study.yaml, or its name in config/config.yaml"
        )
    file = Path(files[-1])
    with file.open(encoding="utf-8") as stream:
        written = yaml.safe_load(stream) or {}
    for key in config.keys() - SETTINGS | written.keys():
        if config.get(key) != written.get(key):
            raise StudyError(f"{file}: {key}: {ONE_FILE}")
    return file.resolve()


ONE_FILE = (
    "the configuration has another value than the file of the study; a study is one file: change "
    "the value there instead of --config or a further --configfile"
)

NO_VALUE = (
    "not a setting, and a study is one file: change the value there, and name the file with "
    "--configfile, --config study=… or in config/config.yaml"
)


RESULTS = COUPON.parent


class WorkflowRunning(RuntimeError):
    """Another process runs the workflow on the same results."""


class Plan:
    """A study that the workflow runs."""

    def __init__(self, study: CouponStudy, file: Path, job_seconds: float = math.inf) -> None:
        """Plan a study that was read from a file and checked, in the working folder."""
        self._file, self.study = file, study
        self.requests = requests.Requests()
        self.runs = CouponRuns(study, self.requests, job_seconds)
        self._locks: list[IO[str]] = []
        self._set_environment()

    @classmethod
    def read(cls, config: Mapping[str, Any], files: Sequence[str | Path]) -> Plan:
        """Read the study that a configuration is; see `study_file`.

        Raises
        ------
        StudyError, OwnerError
            If the study, the machine or the results have faults, with a line for each.
        """
        file = study_file(config, files)
        study = checked_study(file)
        check_machine(study, RESULTS)
        check_owner(study, file, RESULTS)
        return cls(study, file, 60 * float(config.get("job_minutes", "inf")))

    def _set_environment(self) -> None:
        """Set the variables with which jobs run."""
        # jobs are many and short, so what they import is compiled once
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ.update(
            {
                "PATH": f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}",
                "PYTHONPATH": f"{WORKFLOW}:{PACKAGE.parent}",
                # nothing is imported from the working folder
                "PYTHONSAFEPATH": "1",
                "OMP_NUM_THREADS": "1",
                STUDY: str(self._file),
                JOB_SECONDS: str(self.runs.job_seconds),
                # jobs end with this process
                locks.WORKFLOW_PROCESS: str(os.getpid()),
            }
        )

    @property
    def has_panel(self) -> bool:
        """Whether the study has a panel."""
        return isinstance(self.study, Study)

    def results(self, name: str) -> str:
        """Return a file of the study."""
        return str(RESULTS / self.study.name / name)

    def files(self, stage: str, **names: str) -> dict[str, str]:
        """Return files in the folder of a stage."""
        return {key: self.results(f"{stage}/{name}") for key, name in names.items()}

    def damper_file(self, stage: str, damper: str, name: str) -> str:
        """Return a file of one coupon in the folder of a stage."""
        return str(of_damper(Path(self.results(stage)), damper, name))

    def section(self, *names: str, without: Any = None) -> str:
        """Return the digest of sections of the study, or of all."""
        included = set(names) or None
        return digests.values_digest(self.study.model_dump(include=included, exclude=without))

    def coupon(self, damper: str = SECTION) -> str:
        """Return the digest of one coupon: no other one runs again when it changes."""
        return digests.values_digest(self.study.coupons[damper].model_dump())

    def request(self, rule: Rule) -> str:
        """Return the request of a rule, new where its job has to run."""
        return self.requests.quick(list(rule.output.values()), rule.values)

    def begin(self) -> None:
        """Take the results for the jobs that follow.

        Raises
        ------
        WorkflowRunning
            If another process runs the workflow on them.
        """
        if not self.requests.is_main:
            return
        folders = [Path(self.results(""))]
        if self.runs.is_open:
            folders.append(COUPON)
        for folder in folders:
            lock = locks.hold(folder)
            if lock is None:
                raise WorkflowRunning(f"{folder}: another process runs the workflow here")
            self._locks.append(lock)
        write_owner(self.study, self._file, RESULTS)
        self.requests.begin()
