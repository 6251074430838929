"""Pour one packing: its values as JSON in, ``packing.json`` and its other files out."""

import json
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts
from pidpanel.coupon.packing import Packing
from pidpanel.script import run


def main(arguments: Sequence[str]) -> None:
    """Take the values of the packing; write packing.json."""
    values, output = arguments
    attempts.pour_packing(Packing.from_dict(json.loads(values)), Path(output))


if __name__ == "__main__":
    run(main)
