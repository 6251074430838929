"""Propose layouts of dampers within the mass budget of a study, and regenerate its report.

The section `optimise` of the study has the budget and what may be chosen.
"""

from __future__ import annotations

import argparse

from pidpanel.cli import run
from pidpanel.cli.parser import add_directory, add_jobs, add_study

HELP = "Propose layouts of dampers within a mass budget."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_study(parser)
    add_jobs(parser)
    add_directory(parser)
    parser.set_defaults(dry_run=False)


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from pidpanel.check import checked_study
    from pidpanel.study import Study, StudyError

    study = checked_study(args.study)
    if not isinstance(study, Study) or study.optimise is None:
        raise StudyError(f"{args.study}: optimise: missing; the section has the mass budget")
    return run.call(args)
