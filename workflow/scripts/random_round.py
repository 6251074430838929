"""The next round of the random drive: how to shake every coupon, or that enough is known."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.response.from_study import PanelFiles
from pidpanel.response.random_rounds import write_round
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, modes.nc, modal_force.nc, air.nc or none, folder, number; round and impedance."""
    study, modes, modal_force, air, folder, number, output, impedance = arguments
    files = PanelFiles(Path(modes), Path(modal_force), optional(air))
    paths = Path(output), Path(impedance)
    write_round(load_study(study), files, Path(folder), int(number), *paths)


if __name__ == "__main__":
    run(main)
