"""Watch one run of a coupon for some cycles: ``film.nc``, for the animation on the page."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.report.films import write_film
from pidpanel.script import run
from pidpanel.study import load_any_study


def main(arguments: Sequence[str]) -> None:
    """Study, name of the damper, its cases.csv, results/coupon; film.nc."""
    study, damper, table, folder, output = arguments
    write_film(load_any_study(study), damper, Path(table), Path(folder), Path(output))


if __name__ == "__main__":
    run(main)
