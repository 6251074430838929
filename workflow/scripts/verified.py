"""Fail where a number of the verification misses its tolerance; else say how many there are."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.script import run
from pidpanel.verification.rows import confirm, read_rows


def main(arguments: Sequence[str]) -> None:
    """Take the file for the verdict and the files of rows."""
    verdict, *files = map(Path, arguments)
    text = confirm([row for file in files for row in read_rows(file)])
    verdict.write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    run(main)
