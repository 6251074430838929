"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.response.from_study import PanelFiles
from pidpanel.response.results import write_maps
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, modes.nc, modal_force.nc, air.nc or none, plate, left_out, psd; maps, folder."""
    study, modes, modal_force, air, *others = arguments
    files = PanelFiles(Path(modes), Path(modal_force), optional(air))
    write_maps(load_study(study), files, *map(Path, others))


if __name__ == "__main__":
    run(main)
