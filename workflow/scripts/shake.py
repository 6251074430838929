"""Shake the runs of a case, one a seed: their values, target and beds in, their states out.

One process for all seeds: what Python imports is paid once.
"""

import json
import sys
from pathlib import Path

from pidpanel.coupon import runs
from pidpanel.coupon.cases import Run, Target

if __name__ == "__main__":
    values, target_values, output, *beds = sys.argv[1:]
    target = Target(**json.loads(target_values))
    states = {}
    for value, bed in zip(json.loads(values), beds, strict=True):
        run = Run.from_dict(value)
        folder = Path(output).parent / f"s{run.packing.seed}"
        outcome = runs.attempt_shake(run, target, Path(bed), folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{target.label}.json").write_text(json.dumps(outcome, indent=1) + "\n")
        states[folder.name] = outcome["status"]
    Path(output).write_text(json.dumps(states) + "\n")
