"""Regenerate the report of a study if it is out of date, and print its path."""

import argparse


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
