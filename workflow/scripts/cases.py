"""Gather the runs of a coupon, or those that a round of its design has chosen: ``cases.csv``."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon.from_study import write_table
from pidpanel.script import optional, run
from pidpanel.study import load_any_study


def main(arguments: Sequence[str]) -> None:
    """Study, name of the damper, results/coupon, JSON file of the round or none; cases.csv."""
    study, damper, folder, chosen, output = arguments
    write_table(load_any_study(study), damper, Path(folder), Path(output), optional(chosen))


if __name__ == "__main__":
    run(main)
