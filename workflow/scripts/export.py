"""Files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.response.from_study import write_export
from pidpanel.script import run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, modes.nc, psd.nc, summary.csv; folder."""
    study, *files = arguments
    write_export(load_study(study), *map(Path, files))


if __name__ == "__main__":
    run(main)
