"""Integrate the panel and the particles of a scenario: its name in, a record out."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupled.from_study import CoupledFiles, write_run
from pidpanel.script import run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take study, name, modes.nc, modal_force.nc, plate.nc, folder, output, bed.json of patches."""
    study, name, modes, modal_force, plate, folder, output, *beds = arguments
    files = CoupledFiles(Path(modes), Path(modal_force), Path(plate))
    started = [Path(bed) for bed in beds]
    write_run(load_study(study), files, name, started, Path(folder), Path(output))


if __name__ == "__main__":
    run(main)
