"""How far each reading of a study is from its coupled runs: verdict.csv."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.report.verdict_files import write_verdict
from pidpanel.script import run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take study, psd.nc, the summary and third octaves of the coupled runs; write verdict.csv."""
    study, *paths = arguments
    write_verdict(load_study(study), *map(Path, paths))


if __name__ == "__main__":
    run(main)
