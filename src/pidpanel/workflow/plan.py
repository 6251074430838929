"""Plan of the workflow: a study, its LIGGGHTS runs, and the requests of its jobs."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import yaml

from pidpanel.check import check_machine, checked_study
from pidpanel.paths import COUPON, PACKAGE, SECTION, WORKFLOW, of_damper, study_path
from pidpanel.provenance import digests, locks
from pidpanel.provenance.job import JOB_SECONDS, STUDY
from pidpanel.provenance.owner import check_owner, write_owner
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.workflow.coupon import CouponRuns
from pidpanel.workflow.requests import Requests
from pidpanel.workflow.rules import Rule

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
        self.requests = Requests()
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
