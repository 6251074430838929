"""Spheres as LIGGGHTS dumped them.

Packings and beds are read by this code, so it enters their labels; see `pidpanel.coupon.packing`.
"""

import re

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.liggghts.failures import LogTruncated, NotFinite, ParticlesLost

POSITION = ("x", "y", "z")  # columns of a dump: centres [m]
# Columns of a dump: centres [m] and velocities [m/s].
POSITION_AND_VELOCITY = (*POSITION, "vx", "vy", "vz")


def read_dump(text: str, source: str, columns: tuple[str, ...] = POSITION) -> Array:
    """Frames of a ``dump custom id <columns>``, (frames, atoms, len(columns)) sorted by id.

    Raises
    ------
    LogTruncated, NotFinite, ParticlesLost
    """
    if not text.endswith("\n"):
        raise LogTruncated(f"{source}: cut in its last line")
    frames = [
        _frame(part, f"{source}, frame {number}", columns)
        for number, part in enumerate(text.split("ITEM: TIMESTEP\n")[1:])
    ]
    if not frames or any(frame.shape != frames[0].shape for frame in frames):
        raise LogTruncated(f"{source}: {len(frames)} frames, not all alike")
    return np.array(frames)


def _frame(text: str, where: str, columns: tuple[str, ...]) -> Array:
    head, _, body = text.partition(f"ITEM: ATOMS id {' '.join(columns)} \n")
    stated = re.search(r"ITEM: NUMBER OF ATOMS\n(\d+)\n", head)
    lines = [line.split() for line in body.splitlines()]
    if not body or not stated or len(lines) != int(stated[1]):
        raise LogTruncated(f"{where}: {len(lines)} of {stated[1] if stated else '?'} spheres")
    if any(len(line) != len(columns) + 1 for line in lines):
        raise LogTruncated(f"{where}: not {len(columns) + 1} columns in every line")
    try:
        table = np.array([[float(value) for value in line] for line in lines])
    except ValueError as error:
        raise NotFinite(f"{where}: {error}") from None
    if not np.isfinite(table).all():
        raise NotFinite(f"{where}: a value is not finite")
    table = table[np.argsort(table[:, 0])]
    if (table[:, 0] != np.arange(1, len(table) + 1)).any():
        raise ParticlesLost(f"{where}: the ids are not 1 to {len(table)}")
    return table[:, 1:]
