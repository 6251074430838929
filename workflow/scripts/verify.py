"""Compute one case of a stage that has a known reference: its rows as CSV."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.script import run
from pidpanel.verification.rows import verify, write_rows


def main(arguments: Sequence[str]) -> None:
    """Take the stage, the case and the file of rows."""
    stage, case, rows = arguments
    write_rows(Path(rows), verify(stage, case))


if __name__ == "__main__":
    run(main)
