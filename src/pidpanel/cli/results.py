"""Results that are made from others which are complete."""

import argparse
from pathlib import Path

from pidpanel.cli.snakemake import RunError, jobs_left, run
from pidpanel.study import CouponStudy
from pidpanel.workflow.in_process import compute, is_alone, is_up_to_date


def make(
    study: CouponStudy, args: argparse.Namespace, name: str, rule: str, *, force: bool = False
) -> Path:
    """Return the path of a result that one rule makes; make it where it is out of date.

    The arguments are those of a command: the file of the study and the folder with its results.
    """
    folder, target = args.directory.absolute(), f"results/{study.name}/{name}"
    if is_alone(study) and not force and is_up_to_date(study, folder):
        return args.directory / target
    left = jobs_left(args.study, folder, target)
    if is_alone(study) and (left or force):
        compute(study, args.study.resolve(), folder, 1)
        return args.directory / target
    unfinished = {name: count for name, count in left.items() if name != rule}
    if unfinished:
        named = ", ".join(f"{count} × {name}" for name, count in unfinished.items())
        raise RunError(
            f"{folder / target}: jobs before it are not done: {named}; use pidpanel run first"
        )
    if left or force:
        options = [target, "--quiet", "progress", "rules", *(["--forcerun", rule] if force else [])]
        if run(args.study, folder, 1, options):
            raise RunError(f"{folder / target}: failed; see above")
    return args.directory / target
