"""List unused results, and remove them with `--yes`.

These are packings, beds and runs of another version of pidpanel, of LIGGGHTS or of a deck, and
damaged files that were set aside (`.broken`). Results of studies are never removed.
"""

from __future__ import annotations

import argparse

from pidpanel.cli.parser import add_directory

HELP = "List results that no study uses any more, and remove them."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_directory(parser)
    parser.add_argument("--yes", action="store_true", help="remove it")


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from pidpanel import durable
    from pidpanel.coupon.older import older, size_of, size_text
    from pidpanel.locks import is_running

    results = args.directory / "results"
    leftover = older(results / "coupon")
    broken = sorted(path for path in results.rglob(f"*{durable.BROKEN}"))
    unused = [*leftover.folders, *broken]
    for path in unused:
        why = "damaged, set aside" if path in broken else "of another version"
        print(f"{path}: {why}, {size_text(size_of(path))}")
    size = size_text(sum(map(size_of, unused)))
    if not unused:
        print(f"{results}: nothing to remove")
    elif not args.yes:
        print(f"{results}: {len(unused)} unused, {size}; pidpanel clean --yes removes them")
    elif is_running(results):
        print(f"{results}: a study is running here, so nothing is removed")
        return 1
    else:
        for path in unused:
            durable.discard(path)
        print(f"{results}: {len(unused)} removed, {size}")
    return 0
