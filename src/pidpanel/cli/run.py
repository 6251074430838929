"""Run a study. Only changed results are computed again.

Snakemake runs it. A study without LIGGGHTS runs in this process, in seconds, unless options follow.

A stopped run resumes with the same command. Options after `--` go to Snakemake, such as `--
--workflow-profile profiles/slurm`.
"""

import argparse
import os
import sys


def call(args: argparse.Namespace) -> int:
    from pidpanel.cli.snakemake import check_memory

    check_memory()  # before what takes it is imported
    os.environ["OMP_NUM_THREADS"] = "1"
    # pages that numpy has freed are slow to come again
    os.environ["NUMPY_MADVISE_HUGEPAGE"] = "0"
    from pidpanel.check import check_machine, checked_study
    from pidpanel.cli.snakemake import MachineError, check_space, run
    from pidpanel.study import StudyError
    from pidpanel.workflow.in_process import compute, is_alone, is_up_to_date

    study = checked_study(args.study)
    folder, results = args.directory.absolute(), args.directory / "results"
    folder.mkdir(parents=True, exist_ok=True)
    options = [*(["--dry-run"] if args.dry_run else []), *args.further]
    if not args.dry_run:
        try:
            check_machine(study, results)
        except StudyError as error:
            raise MachineError(str(error)) from None
        if results.is_symlink():
            print(f"{results}: is a link; results go to {results.resolve()}", file=sys.stderr)
        check_space(results)
    status = 0
    if not options and is_alone(study):
        if is_up_to_date(study, folder):
            print("Nothing to be done: all files are present and up to date.", file=sys.stderr)
        else:
            compute(study, args.study.resolve(), folder, args.jobs)
    else:
        status = run(args.study, folder, args.jobs, options)
    page = results / study.name / "report.html"
    if not (status or args.dry_run) and page.exists():
        print(page.absolute())
    return status
