"""Print the LIGGGHTS deck of a case, or list the cases of a study.

A case is given by its label, as in results/coupon, or by --at, which selects the case nearest to a
fill fraction, a frequency [Hz] and an acceleration [g].
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from pidpanel.cli.parser import add_study

if TYPE_CHECKING:  # numpy is slow to import
    from pidpanel.coupon.cases import Case

HELP = "Print the LIGGGHTS deck of a case, or list the cases."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_study(parser)
    parser.add_argument("case", nargs="?", help="label of the case, or its beginning")
    parser.add_argument(
        "--at",
        nargs=3,
        type=float,
        metavar=("FILL", "HZ", "G"),
        help="the case nearest to these values",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the packing (default: 1)")


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from pidpanel.check import checked_study
    from pidpanel.coupon.from_study import distinct_cases
    from pidpanel.study import StudyError

    study = checked_study(args.study)
    cases = {case.label: case for batch in distinct_cases(study).values() for case in batch}
    if not cases:
        raise StudyError(f"{args.study}: runs no LIGGGHTS, because no coupon is simulated")
    if args.case is None and args.at is None:
        for label, case in cases.items():
            print(label, _describe(case), sep="\t")
        return 0
    chosen = _nearest(cases, args.at) if args.case is None else _named(cases, args.case)
    seeds = {run.packing.seed: run for run in chosen.with_reserve.runs}
    if args.seed not in seeds:
        raise StudyError(
            f"--seed {args.seed}: must be one of {', '.join(map(str, seeds))} for {chosen.label}"
        )
    print(seeds[args.seed].deck_text(), end="")
    return 0


def _describe(case: Case) -> str:
    r, f, gamma = _point(case)
    return f"r = {r:g}, {f:g} Hz, {gamma:.4g} g"


def _point(case: Case) -> tuple[float, float, float]:
    from pidpanel.constants import STANDARD_GRAVITY

    run = case.point
    return run.fill_fraction, run.drive.frequency, run.drive.acceleration / STANDARD_GRAVITY


def _nearest(cases: dict[str, Case], point: tuple[float, float, float]) -> Case:
    """Return the case nearest in the fill and in the logarithms of frequency and acceleration."""
    import math

    from pidpanel.study import StudyError

    fill, frequency, gamma = point
    if not (math.isfinite(fill) and frequency > 0 and gamma > 0):
        raise StudyError("--at: must be a fill fraction, and a frequency and a Γ above 0")

    def distance(case: Case) -> float:
        r, f, g = _point(case)
        return math.hypot(r - fill, math.log10(f / frequency), math.log10(g / gamma))

    return min(cases.values(), key=distance)


def _named(cases: dict[str, Case], name: str) -> Case:
    from pidpanel.study import StudyError

    matches = [case for label, case in cases.items() if label == name or label.startswith(name)]
    exact = cases.get(name)
    if exact is not None:
        return exact
    if len(matches) == 1:
        return matches[0]
    count = "no case" if not matches else f"{len(matches)} cases"
    raise StudyError(f"{name}: {count} with this label; omit the label to list the cases")
