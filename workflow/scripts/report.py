"""The page of a study with a panel and its figures: report.html, report/*.png."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.report.write import write_study_page
from pidpanel.script import run


def main(arguments: Sequence[str]) -> None:
    """Take the study, its results and the runs of the coupon."""
    write_study_page(*map(Path, arguments))


if __name__ == "__main__":
    run(main)
