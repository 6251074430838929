"""The first answer of `make run`: a study with the damping of the atlas alone, in seconds."""

import sys
from pathlib import Path

from pidpanel.check import checked_study
from pidpanel.paths import study_path
from pidpanel.provenance import durable
from pidpanel.study import Study, StudyError, load_study
from pidpanel.study.base import as_tuple
from pidpanel.study.writing import text_of, values_of
from pidpanel.workflow.in_process import compute, is_up_to_date


def first_study(file: Path, results: Path) -> Path | None:
    """Write a study with the scenarios of the atlas alone.

    Returns None if it has none, or nothing else is simulated.
    """
    study = checked_study(file)
    if not isinstance(study, Study) or not (study.coupons or study.is_coupled):
        return None
    atlas = set(study.beds("atlas"))
    values, scenarios = values_of(file), {}
    for name, family in study.families.items():
        dampers = [damper for damper in as_tuple(family.damper) if damper in atlas]
        if dampers:
            scenarios[name] = {**values["scenarios"][name], "damper": dampers}
    if not scenarios:
        return None
    values = {key: value for key, value in values.items() if key not in ("damping", "measurements")}
    values["response"] = {k: v for k, v in values.get("response", {}).items() if k != "maps"}
    values["scenarios"] = scenarios
    name = f"{study.name}_first"
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
