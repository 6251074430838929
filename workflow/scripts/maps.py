"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.response.from_study import PanelFiles, write_maps
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, modes, modal force, air or none, plate, left_out, psd, coupled or none; outputs."""
    study, modes, modal_force, air, plate, left_out, psd, coupled, *outputs = arguments
    files = PanelFiles(Path(modes), Path(modal_force), optional(air))
    read = (Path(plate), Path(left_out), Path(psd), optional(coupled))
    write_maps(load_study(study), files, *read, *map(Path, outputs))


if __name__ == "__main__":
    run(main)
