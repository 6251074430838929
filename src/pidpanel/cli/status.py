"""Show what is done, failed and left, stage by stage.

It also works while the study runs, from any shell.
"""

import argparse
from pathlib import Path


def call(args: argparse.Namespace) -> int:
    from pidpanel.cli import progress
    from pidpanel.cli.snakemake import is_running, jobs_left
    from pidpanel.study import load_any_study
    from pidpanel.workflow.in_process import is_alone, is_up_to_date

    study = load_any_study(args.study)
    folder: Path = args.directory
    results = folder / "results"
    if not results.is_dir():
        print(f"{study.name}: nothing is done; {results.absolute()} does not exist")
        return 1
    is_done = is_alone(study) and is_up_to_date(study, folder.absolute())
    left = {} if is_done else jobs_left(args.study, folder)
    runs = is_running(folder)
    failed = [] if runs else progress.failed(folder, study.name, left)
    cases = progress.cases_of(study, results / "coupon")
    state = "running" if runs else "complete" if not left else "not complete"
    print(f"{study.name}: {state}; {(results / study.name).absolute()}")
    if cases.total:
        print(f"cases: {cases}")
    for stage in progress.stages(study, left):
        print(stage)
    for line in failed:
        print(line)
    return 1 if left or failed else 0
