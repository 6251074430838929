"""The first answer of `make run`: a study with the damping of the atlas alone, in seconds."""

import sys
from pathlib import Path

from pidpanel.check import checked_study
from pidpanel.constants import ATLAS
from pidpanel.paths import study_path
from pidpanel.provenance import durable
from pidpanel.study import Study, StudyError, load_study
from pidpanel.study.writing import text_of, values_of, with_changes
from pidpanel.workflow.in_process import compute, is_up_to_date

FURTHER_KEYS = {
    "coupled",
    "table",
    "interpolation",
    "apparent_mass",
}  # keys of other damping models


def first_study(file: Path, results: Path) -> Path | None:
    """Write a study without its simulated damping; None if it has none, or no atlas."""
    study = checked_study(file)
    if not isinstance(study, Study) or ATLAS not in study.readings:
        return None
    if not (study.coupons or study.is_coupled):
        return None
    name = f"{study.name}_first"
    values = with_changes(values_of(file), {"damping.readings": [ATLAS]})
    for key in FURTHER_KEYS & set(values["damping"]):
        del values["damping"][key]
    results.mkdir(parents=True, exist_ok=True)
    path = results / f"{name}.yaml"
    durable.write_text(path, text_of({"name": name, **values}))
    return path


def main(name: str, jobs: str) -> int:
    """Compute the first answer, and print its page; return the exit code."""
    results = Path("results")
    try:
        path = first_study(study_path(name).resolve(), results)
        if path is None:
            return 0
    except StudyError:  # the run itself reports it
        return 0
    try:
        study = load_study(path)
    except StudyError as error:
        print(f"no first answer: {error}", file=sys.stderr)
        return 0
    if not is_up_to_date(study, Path.cwd()):
        compute(study, path.resolve(), Path.cwd(), int(jobs))
    print(f"first answer, from the atlas: {(results / study.name / 'report.html').absolute()}")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
