"""Results that are made from others which are complete."""

import argparse
from pathlib import Path

from pidpanel.cli.snakemake import RunError, jobs_left, run
from pidpanel.provenance.owner import check_owner
from pidpanel.study import CouponStudy


def make(
    study: CouponStudy, args: argparse.Namespace, name: str, rule: str, *, force: bool = False
) -> Path:
    """Return the path of a result that one rule makes; make it where it is out of date.

    The arguments are those of a command: the file of the study and the folder with its results.
    """
    folder, target = args.directory, f"results/{study.name}/{name}"
    check_owner(study, args.study, folder / "results")
    left = jobs_left(args.study, folder, target)
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
    return folder / target
