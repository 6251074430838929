"""Pour one packing: its values as JSON in, ``packing.json`` with its fellows out."""

import json
import sys
from pathlib import Path

from pidpanel.coupon import runs
from pidpanel.coupon.cases import Packing

if __name__ == "__main__":
    values, output = sys.argv[1:]
    outcome = runs.attempt_pour(Packing.from_dict(json.loads(values)), Path(output).parent)
    Path(output).write_text(json.dumps(outcome, indent=1) + "\n")
