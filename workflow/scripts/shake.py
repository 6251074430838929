"""Shake the cases of a batch: their values as JSON in, a folder for each run and its status out."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts
from pidpanel.coupon.cases import Case


def main(arguments: Sequence[str]) -> None:
    """Arguments: values of the cases, results/coupon, the file of statuses."""
    values, folder, output = arguments
    cases = [Case.from_dict(case) for case in json.loads(values)]
    attempts.shake_cases(cases, Path(folder), Path(output))


if __name__ == "__main__":
    main(sys.argv[1:])
