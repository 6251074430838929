"""The next round of cases for a target: which to run, or that it is reached."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.response.from_study import PanelFiles
from pidpanel.sampling.from_study import write_round
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, modes.nc, modal_force.nc, air.nc or none, round and cases before or none; round."""
    study, modes, modal_force, air, before, cases, output = arguments
    files = PanelFiles(Path(modes), Path(modal_force), optional(air))
    write_round(load_study(study), files, optional(before), optional(cases), Path(output))


if __name__ == "__main__":
    run(main)
