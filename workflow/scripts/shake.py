"""Shake the cases of a batch: their values as JSON in, a folder for each run and its status out."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts, deadline
from pidpanel.coupon.cases import Case
from pidpanel.coupon.coding import from_shared_json
from pidpanel.script import run


def main(arguments: Sequence[str]) -> None:
    """Take the cases, results/coupon, the hash of the code, the time [s]; write the statuses."""
    values, folder, code, seconds, output = arguments
    cases = [Case.from_dict(case) for case in from_shared_json(values)]
    with deadline.limit(float(seconds)):
        attempts.shake_cases(cases, Path(folder), Path(output), code)


if __name__ == "__main__":
    run(main)
