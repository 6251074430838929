"""The sound of a study: spectrum.csv, modal_force.nc and, where it is asked for, air.nc."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.panel.basis_files import read_basis
from pidpanel.script import run
from pidpanel.sound.from_study import write_sound
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take the study, modes.nc and the files to write."""
    study, modes, *files = arguments
    write_sound(load_study(study), read_basis(Path(modes)), *map(Path, files))


if __name__ == "__main__":
    run(main)
