"""The page of the verification and its figures from the rows of all cases."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.script import run
from pidpanel.verification.page import write_verification_page


def main(arguments: Sequence[str]) -> None:
    """Take the page, the folder of its figures and the files of rows."""
    page, figures, *rows = map(Path, arguments)
    write_verification_page(rows, page, figures)


if __name__ == "__main__":
    run(main)
