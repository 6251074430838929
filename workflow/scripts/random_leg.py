"""Shake a coupon at random with the motion of its patch: a record of force and velocity."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.coupon.from_study import shake_random_leg
from pidpanel.random_round import RandomRound
from pidpanel.script import optional, run
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Study, round, label of the drive, seed, bed.json, record before or none; folder, record."""
    study, round_file, label, seed, bed, before, folder, output = arguments
    drive = RandomRound.read(Path(round_file)).drive(label)
    paths = Path(bed), optional(before), Path(output), Path(folder)
    shake_random_leg(load_study(study), drive, int(seed), *paths)


if __name__ == "__main__":
    run(main)
