"""Pour one packing: its values as JSON in, ``packing.json`` and its other files out."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon import attempts
from pidpanel.coupon.cases import Packing


def main(arguments: Sequence[str]) -> None:
    """Arguments: values of the packing, packing.json."""
    values, output = arguments
    attempts.pour_packing(Packing.from_dict(json.loads(values)), Path(output))


if __name__ == "__main__":
    main(sys.argv[1:])
