"""Shake one run: its values and target as JSON and its bed in, ``<target>.json`` out."""

import json
import sys
from pathlib import Path

from pidpanel.coupon import runs
from pidpanel.coupon.cases import Run, Target

if __name__ == "__main__":
    values, target, start, output = sys.argv[1:]
    folder = Path(output).parent
    outcome = runs.attempt_shake(
        Run.from_dict(json.loads(values)), Target(**json.loads(target)), Path(start), folder
    )
    folder.mkdir(parents=True, exist_ok=True)
    Path(output).write_text(json.dumps(outcome, indent=1) + "\n")
