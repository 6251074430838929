"""Write the files for other programs.

The files are CSV with units, third octaves, Nastran TABRND1 and TABDMP1, and UFF 58. They are in
results/<study>/response/export; --to copies them to another folder.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pidpanel.cli.parser import add_directory, add_study

HELP = "Write the files for other programs, such as Nastran tables."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_study(parser)
    add_directory(parser)
    parser.add_argument("--to", type=Path, metavar="FOLDER", help="folder to copy them to")


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    import shutil

    from pidpanel.cli.results import make
    from pidpanel.owner import check_owner
    from pidpanel.study import load_study

    study = load_study(args.study)
    check_owner(study, args.study, args.directory / "results")
    folder = make(args.study, args.directory, f"results/{study.name}/response/export", "export")
    if args.to is not None:
        args.to.mkdir(parents=True, exist_ok=True)
        ours = shutil.ignore_patterns(".*")  # Snakemake's time stamp
        folder = Path(shutil.copytree(folder, args.to, dirs_exist_ok=True, ignore=ours))
    for path in sorted(folder.glob("[!.]*")):
        print(path)
    return 0
