"""What the records of panel and particles tell: tables of all scenarios."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupled.from_study import CoupledFiles, CoupledTables, write_coupled
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take study, modes.nc, modal_force.nc, plate.nc, air.nc or none, tables, estimates."""
    study, modes, modal_force, plate, air, *paths = arguments
    files = CoupledFiles(Path(modes), Path(modal_force), Path(plate), optional(air))
    count = len(CoupledTables._fields)
    tables, estimates = map(Path, paths[:count]), map(Path, paths[count:])
    write_coupled(load_study(study), files, list(estimates), CoupledTables(*tables))


if __name__ == "__main__":
    run(main)
