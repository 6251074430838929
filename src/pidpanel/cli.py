"""Check a study, estimate how long its LIGGGHTS runs take, or run it with Snakemake."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.check import checked_study
from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import cpu_seconds, random_seconds
from pidpanel.coupon.from_study import cases_of, distinct_cases
from pidpanel.coupon.liggghts.failures import SolverFailure
from pidpanel.coupon.liggghts.trust import TRUST
from pidpanel.coupon.probe import probe
from pidpanel.paths import SNAKEFILE
from pidpanel.response.random_rounds import expected_legs
from pidpanel.study import CouponStudy, Study, StudyError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``pidpanel``.

    Parameters
    ----------
    arguments
        Those of the command line by default.

    Returns
    -------
    int
        Exit status: 0, that of Snakemake, or 2 for a mistake, which is printed to stderr.
    """
    given = _parser().parse_args(arguments)
    if given.trust_deck:
        os.environ[TRUST] = "1"
    try:
        study = checked_study(given.study)
        if given.command == "run":
            return _run(given.study, given.jobs)
        if given.command == "estimate":
            print(_estimate(study, given.results, given.jobs))
        else:
            print(_summary(study))
    except (StudyError, SolverFailure) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    study = argparse.ArgumentParser(add_help=False)
    study.add_argument("study", type=Path, help="YAML file of the study")
    study.add_argument(
        "--trust-deck",
        action="store_true",
        help="let decks of your own start programs and write any file, as LIGGGHTS can",
    )
    jobs = argparse.ArgumentParser(add_help=False)
    jobs.add_argument(
        "-j", "--jobs", type=_positive, default=2, help="jobs to run at the same time (default: 2)"
    )
    parser = argparse.ArgumentParser(prog="pidpanel", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")
    check = "Check a study and print what it would run."
    run = "Run a study with Snakemake."
    estimate = "Estimate how long the LIGGGHTS runs of a study take, from a few short ones."
    commands.add_parser("check", parents=[study], help=check, description=check)
    commands.add_parser("run", parents=[study, jobs], help=run, description=run)
    command = commands.add_parser(
        "estimate", parents=[study, jobs], help=estimate, description=estimate
    )
    command.add_argument(
        "--results",
        type=Path,
        default=Path("results"),
        help="folder of the results; runs that it holds are not counted (default: results)",
    )
    return parser


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{number}: must be at least 1")
    return number


def _run(path: Path, jobs: int) -> int:
    """Run Snakemake on a study; return its exit status."""
    snakemake = Path(sys.executable).with_name("snakemake")
    return subprocess.call([snakemake, "-s", SNAKEFILE, f"-j{jobs}", "--configfile", path])


def _cases(study: CouponStudy) -> list[Case]:
    """Return every case of all coupons of a study once."""
    return [case for cases in distinct_cases(study).values() for case in cases]


def _summary(study: CouponStudy) -> str:
    """Return how many cases, runs and scenarios a study has."""
    cases = _cases(study)
    summary = f"{study.name}: {len(cases)} coupon cases, {sum(len(c.runs) for c in cases)} runs"
    if isinstance(study, Study):
        if not study.scenarios:
            return f"{summary}; the bare panel alone"
        readings = ", ".join(study.readings)
        summary += f"; {len(study.all_scenarios())} scenarios with damping from {readings}"
        unused = [name for name in study.dampers if name not in study.used_dampers]
        if unused:
            summary += f"; not used: dampers {', '.join(unused)}"
    return summary


def _estimate(study: CouponStudy, results: Path, jobs: int) -> str:
    """Return how many cases of a study are still to be run, and how long that takes."""
    folder = results / "coupon"
    cases = _cases(study)
    left = [case for case in cases if not all(path.exists() for path in case.outcomes(folder))]
    coupled = ""
    if isinstance(study, Study) and study.is_coupled:
        # two seconds of imports that other studies do not need
        from pidpanel.coupled.from_study import coupled_runs, estimated_cpu_seconds

        minutes = estimated_cpu_seconds(study) / 60
        coupled = (
            f"; panel and particles together {len(coupled_runs(study))} runs, {minutes:.0f} min of "
            "CPU time or more"
        )
    legs, rounds = expected_legs(study, results)
    if not left and not legs:
        return (
            f"{study.name}: no LIGGGHTS runs left, {len(cases)} coupon cases are complete{coupled}"
        )
    costs = probe(left or cases_of(study.random_coupons()[0][2]))
    seconds = cpu_seconds(left, costs, folder) + random_seconds(legs, rounds, costs, folder)
    driven = f" and {len(legs)} packings to drive at random, in {rounds} rounds" if legs else ""
    return (
        f"{study.name}: {len(left)} of {len(cases)} coupon cases to run{driven}, about "
        f"{seconds / 60:.1f} min of CPU time, {seconds / jobs / 3600:.2f} h on {jobs} free cores"
        + coupled
    )
