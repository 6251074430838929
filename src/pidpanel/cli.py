"""The command ``pidpanel``: a thin face on the workflow."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.check import checked_study
from pidpanel.coupon.cases import Case, cases_of
from pidpanel.coupon.estimate import cpu_seconds, probe
from pidpanel.coupon.liggghts.output import SolverFailure
from pidpanel.paths import SNAKEFILE
from pidpanel.study import Study, StudyError


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    parser = argparse.ArgumentParser(prog="pidpanel", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    check = commands.add_parser("check", help="read a study and say what it would run")
    check.add_argument("study", type=Path)
    run = commands.add_parser("run", help="run a study: snakemake with this study")
    run.add_argument("study", type=Path)
    run.add_argument("-j", "--jobs", type=int, default=2)
    guess = commands.add_parser("estimate", help="say how long the runs of LIGGGHTS will take")
    guess.add_argument("study", type=Path)
    guess.add_argument("-j", "--jobs", type=int, default=2)
    guess.add_argument("--results", type=Path, default=Path("results"))
    given = parser.parse_args(arguments)
    try:
        study = checked_study(given.study)
    except StudyError as error:
        print(error, file=sys.stderr)
        return 2
    if given.command == "run":
        snakemake = Path(sys.executable).with_name("snakemake")
        return subprocess.call(
            [snakemake, "-s", SNAKEFILE, f"-j{given.jobs}", "--configfile", given.study]
        )
    cases = cases_of(study.coupon) if study.coupon else ()
    if given.command == "estimate":
        try:
            print(_estimate(study.name, cases, given.results / "coupon", given.jobs))
        except SolverFailure as error:
            print(error, file=sys.stderr)
            return 2
        return 0
    what = f"{study.name}: {len(cases)} coupon cases, {sum(len(c.runs) for c in cases)} runs"
    if isinstance(study, Study):
        what += (
            f"; {len(study.all_scenarios())} scenarios in {len(study.damping.readings)} readings"
        )
    print(what)
    return 0


def _estimate(name: str, cases: Sequence[Case], results: Path, jobs: int) -> str:
    """What of the cases is still to be run, and how long it will take."""
    left = [case for case in cases if not all(path.exists() for path in case.outcomes(results))]
    if not left:
        return f"{name}: nothing left to run of {len(cases)} coupon cases"
    seconds = cpu_seconds(left, probe(left), results)
    wall = seconds / jobs
    return (
        f"{name}: {len(left)} of {len(cases)} coupon cases to run, about {seconds / 60:.1f} min "
        f"of CPU, {wall / 3600:.2f} hours on {jobs} free cores"
    )
