"""Shake the cases of a batch: their values as JSON in, a folder for each run and its status out."""

import json
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts
from pidpanel.coupon.cases import Case
from pidpanel.script import run


def main(arguments: Sequence[str]) -> None:
    """Take the values of the cases, results/coupon, the hash of the code; write their statuses."""
    values, folder, code, output = arguments
    cases = [Case.from_dict(case) for case in json.loads(values)]
    attempts.shake_cases(cases, Path(folder), Path(output), code)


if __name__ == "__main__":
    run(main)
