"""Gather the runs of a study, or those that a round of its design has chosen: ``cases.csv``."""

import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import from_study, summary
from pidpanel.study import load_any_study


def main(arguments: Sequence[str]) -> None:
    """Arguments: study file, results/coupon, JSON file of the round or "all", cases.csv."""
    study, folder, chosen, output = arguments
    round_file = None if chosen == "all" else Path(chosen)
    try:
        from_study.write_table(load_any_study(study), Path(folder), Path(output), round_file)
    except summary.CoverageMissed as missed:
        sys.exit(str(missed))


if __name__ == "__main__":
    main(sys.argv[1:])
