"""Shake one bed loose: its values as JSON and its packing in, ``bed.json`` and its files out."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts
from pidpanel.coupon.cases import Bed


def main(arguments: Sequence[str]) -> None:
    """Arguments: values of the bed, packing.json, bed.json."""
    values, packing, output = arguments
    attempts.loosen_bed(Bed.from_dict(json.loads(values)), Path(packing), Path(output))


if __name__ == "__main__":
    main(sys.argv[1:])
