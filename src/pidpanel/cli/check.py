"""Report the mistakes of a study, one per line, or print what it would run."""

import argparse

from pidpanel.cli.parser import add_study

HELP = "Check a study and print what it would run."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_study(parser)


def call(args: argparse.Namespace) -> int:
    from pidpanel.check import checked_study
    from pidpanel.cli.study_overview import overview

    print(overview(checked_study(args.study)))
    return 0
