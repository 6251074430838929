"""Shake one bed loose: its values as JSON and its packing in, ``bed.json`` and its files out."""

import json
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts
from pidpanel.coupon.bed import Bed
from pidpanel.script import run


def main(arguments: Sequence[str]) -> None:
    """Take the values of the bed and packing.json; write bed.json."""
    values, packing, output = arguments
    attempts.loosen_bed(Bed.from_dict(json.loads(values)), Path(packing), Path(output))


if __name__ == "__main__":
    run(main)
