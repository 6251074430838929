"""Shake one run: its values as JSON and its bed in, ``run.json`` with its fellows out."""

import json
import sys
from pathlib import Path

from pidpanel.coupon import runs
from pidpanel.coupon.cases import Run

if __name__ == "__main__":
    values, start, output = sys.argv[1:]
    run = Run.from_dict(json.loads(values))
    outcome = runs.attempt_shake(run, Path(start), Path(output).parent)
    Path(output).write_text(json.dumps(outcome, indent=1) + "\n")
