"""Shake the cases of a batch, every seed of them: labels, targets and runs in, states out.

One process for all of them: what Python imports is paid once. How a run ended stands in
``<case>/s<seed>/<target>.json``, its bed in ``bed``.
"""

import json
import sys
from pathlib import Path

from pidpanel.coupon import runs
from pidpanel.coupon.cases import Run, Target

if __name__ == "__main__":
    batch, folder, output = json.loads(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])
    states = {}
    for case in batch:
        target = Target(**case["target"])
        case_runs = [Run.from_dict(values) for values in case["runs"]]
        beds = [folder / "bed" / run.bed.label / "bed.json" for run in case_runs]
        folders = [folder / case["case"] / f"s{run.packing.seed}" for run in case_runs]
        outcomes = runs.attempt_case(case_runs, target, beds, folders)
        for own, outcome in zip(folders, outcomes, strict=True):
            own.mkdir(parents=True, exist_ok=True)
            (own / f"{target.label}.json").write_text(json.dumps(outcome, indent=1) + "\n")
            states[f"{case['case']}/{own.name}"] = outcome["status"]
    output.write_text(json.dumps(states, indent=1) + "\n")
