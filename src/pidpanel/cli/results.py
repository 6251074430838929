"""Results that are made from others which are complete."""

from pathlib import Path

from pidpanel.cli.snakemake import RunError, jobs_left, run_workflow
from pidpanel.paths import study_path
from pidpanel.provenance.links import check_links
from pidpanel.report.comparison import Side, read_side
from pidpanel.report.from_study import partly_known
from pidpanel.study import CouponStudy, StudyError, load_study
from pidpanel.workflow.in_process import compute, is_alone, is_up_to_date


def make(
    study: CouponStudy, file: Path, directory: Path, name: str, rule: str, *, force: bool = False
) -> Path:
    """Return the path of a result that one rule makes; make it where it is out of date.

    The folder is the one that has ``results``.
    """
    folder, target = directory.absolute(), f"results/{study.name}/{name}"
    if is_alone(study) and not force and is_up_to_date(study, folder):
        return directory / target
    left = jobs_left(file, folder, target)
    if is_alone(study) and (left or force):
        compute(study, file.resolve(), folder, 1)
        return directory / target
    unfinished = {name: count for name, count in left.items() if name != rule}
    if unfinished:
        named = ", ".join(f"{count} × {name}" for name, count in unfinished.items())
        raise RunError(
            f"{folder / target}: jobs before it are not done: {named}; use pidpanel run first"
        )
    if left or force:
        options = [target, "--quiet", "progress", "rules", *(["--forcerun", rule] if force else [])]
        if run_workflow(file, folder, 1, options):
            raise RunError(f"{folder / target}: failed; see above")
    return directory / target


def side_of(name: Path, results: Path) -> Side:
    """Return the results that a comparison names: by their folder, or by their study."""
    unknown: list[str] = []
    if name.is_dir():
        check_links(name)
        folder = name.absolute()
    elif (file := study_path(str(name))).is_file():
        study = load_study(file)
        folder, unknown = results / study.name, partly_known(study)
    else:
        raise StudyError(f"{name}: must be a study or the folder of its results")
    if not (folder / "response" / "summary.csv").is_file():
        raise StudyError(f"{folder}: has no response/summary.csv; run the study first")
    return read_side(folder, unknown)
