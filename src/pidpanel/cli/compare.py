"""Compare the results of two studies at the same points and in the same scenarios.

Differences larger than twice their standard error are listed. The page has tables, PSDs and maps.
The arguments are studies or folders of results, results/<study>.
"""

import argparse
from pathlib import Path


def call(args: argparse.Namespace) -> int:
    from pidpanel.report.comparison import comparison_lines, read_side, write_comparison

    results = args.directory / "results"
    first, second = (read_side(*_folder(name, results)) for name in (args.a, args.b))
    if first.name == second.name:  # the same study in two folders
        first, second = first._replace(name=str(args.a)), second._replace(name=str(args.b))
    for line in comparison_lines(first, second):
        print(line)
    if args.page is not None:
        write_comparison(first, second, args.page)
        print(args.page.absolute())
    return 0


def _folder(name: Path, results: Path) -> tuple[Path, list[str]]:
    """Return the folder that a study, or itself, names, and its scenarios without errors."""
    from pidpanel.paths import study_path
    from pidpanel.provenance.links import check_links
    from pidpanel.provenance.owner import check_owner
    from pidpanel.report.from_study import partly_known
    from pidpanel.study import StudyError, load_study

    unknown: list[str] = []
    if name.is_dir():
        check_links(name)
        folder = name.absolute()
    elif (file := study_path(str(name))).is_file():
        study = load_study(file)
        check_owner(study, file, results)
        folder, unknown = results / study.name, partly_known(study)
    else:
        raise StudyError(f"{name}: must be a study or the folder of its results")
    if not (folder / "response" / "summary.csv").is_file():
        raise StudyError(f"{folder}: has no response/summary.csv; run the study first")
    return folder, unknown
