"""Every scenario in every reading of the damping: psd.nc, summary.csv, stress and radiation."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.response.from_study import PanelFiles, ResponseFiles, write_response
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, four files of the panel and the sound, damping, air, coupled or none."""
    study, modes, modal_force, plate, section, damping, air, coupled, *outputs = arguments
    files = PanelFiles(Path(modes), Path(modal_force), optional(air))
    made = ResponseFiles(*map(Path, outputs))
    read = (Path(plate), Path(section), optional(damping))
    write_response(load_study(study), files, *read, made, optional(coupled))


if __name__ == "__main__":
    run(main)
