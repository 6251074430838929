"""Regenerate the report of a study if it is out of date, and print its path."""

import argparse

from pidpanel.cli.parser import add_directory, add_study

HELP = "Regenerate the report of a study, and open it."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_study(parser)
    add_directory(parser)
    parser.add_argument(
        "--again", action="store_true", help="regenerate it even if it is up to date"
    )
    parser.add_argument("--open", action="store_true", help="open it in the browser")


def call(args: argparse.Namespace) -> int:
    import webbrowser

    from pidpanel.cli.results import make
    from pidpanel.study import Study, load_any_study

    study = load_any_study(args.study)
    rule = "report" if isinstance(study, Study) else "coupon_report"
    page = make(study, args, "report.html", rule, force=args.again).absolute()
    print(page)
    if args.open:
        webbrowser.open(page.as_uri())
    return 0
