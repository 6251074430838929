"""Run a study. Only changed results are computed again.

Snakemake runs it. A study without LIGGGHTS runs in this process, in seconds, unless options follow.
Each accepts the results of the other.

A stopped run resumes with the same command. Options after `--` go to Snakemake, such as `--
--workflow-profile profiles/slurm`.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # slow to import
    from pidpanel.study import CouponStudy, Study


def call(args: argparse.Namespace) -> int:
    from pidpanel.cli.snakemake import check_memory

    check_memory()  # before what takes it is imported
    os.environ["OMP_NUM_THREADS"] = "1"  # for jobs that are forks of this process
    # pages that numpy has freed are slow to come again
    os.environ["NUMPY_MADVISE_HUGEPAGE"] = "0"
    from pidpanel.check import check_machine, checked_study
    from pidpanel.cli.snakemake import MachineError, check_space, run
    from pidpanel.provenance.owner import check_owner
    from pidpanel.study import Study, StudyError

    study = checked_study(args.study)
    results = args.directory / "results"
    args.directory.mkdir(parents=True, exist_ok=True)
    try:
        check_machine(study, results)
    except StudyError as error:
        raise MachineError(str(error)) from None
    if results.is_symlink():
        print(f"{results}: is a link; results go to {results.resolve()}", file=sys.stderr)
    check_owner(study, args.study, results)
    check_space(results)
    options = [*(["--dry-run"] if args.dry_run else []), *args.further]
    if isinstance(study, Study) and not (options or study.coupons or study.is_coupled):
        status = run_forked(study, args.study, args.directory, args.jobs)
    else:
        status = run(args.study, args.directory, args.jobs, options)
    if status or args.dry_run:
        return status
    page = results / study.name / "report.html"
    if page.exists():
        print(page.absolute())
    return told_of_machine(study, results)


def run_forked(study: Study, file: Path, folder: Path, jobs: int) -> int:
    """Run a study without LIGGGHTS in this process; return the exit code."""
    from pidpanel.cli.snakemake import check_space
    from pidpanel.workflow.fork_runner import run_rules
    from pidpanel.workflow.plan import Plan
    from pidpanel.workflow.rules import panel_rules

    path = file.resolve()
    with contextlib.chdir(folder):
        plan = Plan(study, path)
        if run_rules(plan, panel_rules(plan, study), jobs):
            return 0
        check_space(Path("results"))
        return 1


def told_of_machine(study: CouponStudy, results: Path) -> int:
    """Say how many cases the machine has cost, if any; return the exit code."""
    from pidpanel.cli.progress import cases_of

    cases = cases_of(study, results / "coupon")
    if not cases.of_machine:
        return 0
    print(
        f"{study.name}: cases: {cases}; the same command tries {cases.of_machine} of them again",
        file=sys.stderr,
    )
    return 1
