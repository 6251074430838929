"""Report the mistakes of a study, one per line, or print what it would run.

The time is that of the LIGGGHTS runs that are not yet there, on a core of 2.5 GHz.
"""

import argparse


def call(args: argparse.Namespace) -> int:
    from pidpanel.check import checked_study
    from pidpanel.cli.study_overview import overview

    print(overview(checked_study(args.study), args.directory / "results"))
    return 0
