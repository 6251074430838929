"""Shake runs of a long case for so long: a status out, and restarts for the next leg."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon.cases import Case
from pidpanel.coupon.coding import from_shared_json
from pidpanel.coupon.legs import shake_leg
from pidpanel.script import optional, run


def main(arguments: Sequence[str]) -> None:
    """Case, its runs, leg before or none, 1 for the last or 0, results/coupon, time [s]; status."""
    values, numbers, before, last, folder, seconds, output = arguments
    (case,) = map(Case.from_dict, from_shared_json(values))
    paths = optional(before), Path(folder), Path(output)
    runs = list(map(int, numbers.split(",")))
    shake_leg(case, runs, *paths, seconds=float(seconds), is_last=bool(int(last)))


if __name__ == "__main__":
    run(main)
