"""Mesh and modes of the panel of a study: modes, mesh, section and matrices."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.panel.from_study import write_panel
from pidpanel.script import run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take the study; modes.nc, modes.csv, modes.vtu, mesh.msh, section.csv, plate.nc to write."""
    study, *files = arguments
    write_panel(load_study(study), *map(Path, files))


if __name__ == "__main__":
    run(main)
