"""From cases.csv to the surface (.nc, .csv), the constants of the law, and the forms compared."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.damping.from_study import write_damping
from pidpanel.script import run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, name of the damper, cases.csv; surface.nc, surface.csv, law.csv, forms.csv."""
    study, damper, *files = arguments
    write_damping(load_study(study), damper, *map(Path, files))


if __name__ == "__main__":
    run(main)
