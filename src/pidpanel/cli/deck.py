"""Print the LIGGGHTS deck of a case, or list the cases of a study.

A case is given by its label, as in results/coupon; without a label, all cases are listed with their
fill fraction, frequency and acceleration.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # numpy is slow to import
    from pidpanel.coupon.cases import Case


def call(args: argparse.Namespace) -> int:
    from pidpanel.check import checked_study
    from pidpanel.coupon.from_study import distinct_cases
    from pidpanel.study import StudyError

    study = checked_study(args.study)
    cases = {case.label: case for batch in distinct_cases(study).values() for case in batch}
    if not cases:
        raise StudyError(f"{args.study}: runs no LIGGGHTS, because no coupon is simulated")
    if args.case is None:
        for label, case in cases.items():
            run = case.point
            size = f"{run.drive.frequency:g} Hz, {run.drive.gamma:.4g} g"
            print(f"{label}\tr = {run.fill_fraction:g}, {size}")
        return 0
    chosen = _named(cases, args.case)
    seeds = {run.packing.seed: run for run in chosen.with_reserve.runs}
    if args.seed not in seeds:
        raise StudyError(
            f"--seed {args.seed}: must be one of {', '.join(map(str, seeds))} for {chosen.label}"
        )
    print(seeds[args.seed].deck_text(), end="")
    return 0


def _named(cases: dict[str, Case], name: str) -> Case:
    from pidpanel.study import StudyError

    if name in cases:
        return cases[name]
    matches = [case for label, case in cases.items() if label.startswith(name)]
    if len(matches) == 1:
        return matches[0]
    count = "no case" if not matches else f"{len(matches)} cases"
    raise StudyError(f"{name}: {count} with this label; omit the label to list the cases")
