"""Gather the runs of a study, or those a round of its design has chosen, into ``cases.csv``."""

import json
import sys
from pathlib import Path

from pidpanel.coupon.cases import cases_of
from pidpanel.coupon.summary import summarise, write_cases
from pidpanel.study import load_any_study

if __name__ == "__main__":
    study_path, coupon_folder, chosen, output = sys.argv[1:]
    study = load_any_study(study_path)
    cases, last = cases_of(study.coupon), True
    if chosen != "all":
        design = json.loads(Path(chosen).read_text())
        cases, last = [c for c in cases if c.label in design["cases"]], design["new"] == 0
    rows = [summarise(case, case.outcomes(Path(coupon_folder))) for case in cases]
    write_cases(rows, Path(output))
    bad = [row for row in rows if row["status"] != "ok"]
    good = (len(rows) - len(bad)) / len(rows)
    if last and good < study.coupon.accuracy.coverage:
        for row in bad:
            print(f"{row['case']}: {row['status']}: {row['message']}", file=sys.stderr)
        sys.exit(
            f"{good:.1%} of the cases stand; coupon.accuracy.coverage wants "
            f"{study.coupon.accuracy.coverage:.1%}"
        )
