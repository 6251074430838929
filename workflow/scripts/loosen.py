"""Shake one bed loose: its values as JSON and its packing in, ``bed.json`` with its fellows out."""

import json
import sys
from pathlib import Path

from pidpanel.coupon import runs
from pidpanel.coupon.cases import Bed

if __name__ == "__main__":
    values, packing, output = sys.argv[1:]
    bed = Bed.from_dict(json.loads(values))
    outcome = runs.attempt_loosen(bed, Path(packing), Path(output).parent)
    Path(output).write_text(json.dumps(outcome, indent=1) + "\n")
