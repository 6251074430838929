"""Seeds of a long case, shaken by several jobs one after the other: their legs.

A leg goes on from the restart that the one before left, and ends in time with the status
`CONTINUES`, or with `DONE`: whether a run failed is for the case to find. That runs were shared out
changes none of their numbers: they go cycle by cycle, and a restart after any of them changes no
bit.
"""

import json
from pathlib import Path

from pidpanel.coupon import attempts, coding, deadline
from pidpanel.coupon.cases import Case

# Status of a leg whose runs go on in the next one, and of one that leaves nothing to do.
CONTINUES, DONE = "continues", "done"


def shake_leg(
    request: Path, previous: Path | None, folder: Path, file: Path, *, seconds: float
) -> None:
    """Shake the runs of a request one after the other, for so long; write how the leg ended."""
    values = json.loads(request.read_text(encoding="utf-8"))
    case = coding.decode(Case, values["case"])
    status = CONTINUES
    if previous is not None:
        status = json.loads(previous.read_text(encoding="utf-8"))["status"]
    if status == CONTINUES:
        try:
            with deadline.limit(seconds):
                target, folders = attempts.first_target(case), case.folders(folder)
                for number in values["runs"]:
                    run = case.runs[number]
                    bed = folder / "bed" / run.bed.label / "bed.json"
                    attempts.shake_run(run, target, bed, folders[number])
            status = DONE
        except deadline.Continues:
            if values["is_last"]:
                raise
    file.write_text(json.dumps({"status": status}) + "\n", encoding="utf-8")
