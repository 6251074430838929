"""The page of a study of the coupon alone and its figures."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.report.write import write_coupon_page
from pidpanel.script import run


def main(arguments: Sequence[str]) -> None:
    """Take the study, its cases and the runs of the coupon; write the page and its figures."""
    study, table, coupon, page, figures = map(Path, arguments)
    write_coupon_page(study, table, coupon, page, figures)


if __name__ == "__main__":
    run(main)
