"""Gather the runs of a study, or those that a round of its design has chosen: ``cases.csv``."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon.from_study import write_table
from pidpanel.script import optional, run
from pidpanel.study import load_any_study


def main(arguments: Sequence[str]) -> None:
    """Take the study, results/coupon and the JSON file of the round or none; write cases.csv."""
    study, folder, chosen, output = arguments
    write_table(load_any_study(study), Path(folder), Path(output), optional(chosen))


if __name__ == "__main__":
    run(main)
