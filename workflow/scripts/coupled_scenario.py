"""Integrate the panel and the particles of a scenario until its rms accelerations are known."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupled.from_study import CoupledFiles, write_scenario
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, label, modes.nc, modal_force.nc, plate.nc, air.nc or none, store; folder, output."""
    study, label, modes, modal_force, plate, air, *paths = arguments
    files = CoupledFiles(Path(modes), Path(modal_force), Path(plate), optional(air))
    write_scenario(load_study(study), files, label, *map(Path, paths))


if __name__ == "__main__":
    run(main)
