"""What the records of panel and particles tell: tables of all scenarios."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupled.from_study import CoupledFiles, write_coupled
from pidpanel.script import run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take study, modes.nc, modal_force.nc, plate.nc, four tables and the records."""
    study, modes, modal_force, plate, *paths = arguments
    files = CoupledFiles(Path(modes), Path(modal_force), Path(plate))
    summary, bands, impedance, psd, *records = map(Path, paths)
    write_coupled(load_study(study), files, records, summary, bands, impedance, psd)


if __name__ == "__main__":
    run(main)
