"""Show what is done, failed and left, stage by stage.

It also works while the study runs, from any shell.
"""

import argparse
from pathlib import Path


def call(args: argparse.Namespace) -> int:
    from pidpanel.cli import progress
    from pidpanel.cli.snakemake import jobs_left
    from pidpanel.provenance.owner import check_owner
    from pidpanel.study import load_any_study

    study = load_any_study(args.study)
    folder: Path = args.directory
    results = folder / "results"
    if not results.is_dir():
        print(f"{study.name}: nothing is done; {results.absolute()} does not exist")
        return 1
    check_owner(study, args.study, results)
    left = jobs_left(args.study, folder)
    is_running = progress.is_running(results / study.name)
    failed = progress.failed(folder, study.name, left) if not is_running else []
    cases = progress.cases_of(study, results / "coupon")
    state = "running" if is_running else "complete" if not left else "not complete"
    print(f"{study.name}: {state}; {(results / study.name).absolute()}")
    if cases.total:
        print(f"cases: {cases}")
    for stage in progress.stages(study, left):
        print(stage)
    for line in failed:
        print(line)
    return 1 if left or failed else 0
