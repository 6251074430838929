"""Estimate the computing time of each stage, on a core of 2.5 GHz."""

import argparse
from pathlib import Path

from pidpanel.cli.parser import add_directory, add_jobs, add_study

HELP = "Estimate how long a study takes, stage by stage."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_study(parser)
    add_jobs(parser)
    add_directory(parser)
    parser.add_argument(
        "--results",
        type=Path,
        help=(
            "folder with results; existing runs are not counted (default: results in --directory)"
        ),
    )


def call(args: argparse.Namespace) -> int:
    from pidpanel.check import checked_study
    from pidpanel.cli.study_overview import estimate

    results = args.results or args.directory / "results"
    print(estimate(checked_study(args.study), results, args.jobs))
    return 0
