"""Dumps of LIGGGHTS as text: spheres, and lists of contacts.

Packings and beds are read by this code, so it enters their labels; see `pidpanel.coupon.packing`.
"""

import re

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.liggghts.failures import LogTruncated, NotFinite, ParticlesLost

_COUNT = re.compile(r"ITEM: NUMBER OF (?:ATOMS|ENTRIES)\n(\d+)\n")

POSITION = ("x", "y", "z")  # columns of a dump: centres [m]
# Columns of a dump: centres [m] and velocities [m/s].
POSITION_AND_VELOCITY = (*POSITION, "vx", "vy", "vz")


def read_dump(text: str, source: str, columns: tuple[str, ...] = POSITION) -> Array:
    """Read frames of a ``dump custom id <columns>``, (frames, atoms, len(columns)), by id.

    Raises
    ------
    LogTruncated, NotFinite, ParticlesLost
    """
    counts, table = read_frames(text, source, f"ATOMS id {' '.join(columns)}", len(columns) + 1)
    if not table.size or min(counts) != max(counts):
        raise LogTruncated(f"{source}: {len(counts)} frames, not all alike")
    frames = table.reshape(len(counts), counts[0], -1)
    frames = np.take_along_axis(frames, np.argsort(frames[:, :, :1], axis=1), axis=1)
    if (frames[:, :, 0] != np.arange(1, counts[0] + 1)).any():
        raise ParticlesLost(f"{source}: the ids are not 1 to {counts[0]}")
    return frames[:, :, 1:]


def read_frames(text: str, source: str, title: str, columns: int) -> tuple[list[int], Array]:
    """Read rows of each frame of a text dump with a title, and all of them, (n, columns)."""
    if not text.endswith("\n"):
        raise LogTruncated(f"{source}: cut in its last line")
    counts: list[int] = []
    bodies: list[str] = []
    last = -1
    for number, part in enumerate(text.split("ITEM: TIMESTEP\n")[1:]):
        head, mark, rest = part.partition(f"ITEM: {title}")
        count = _COUNT.search(head)
        if not mark or not count:
            raise LogTruncated(f"{source}, frame {number}: no head")
        step = head.partition("\n")[0]
        if not step.isdecimal() or int(step) <= last:
            raise LogTruncated(f"{source}, frame {number}: step {step!r} out of order")
        last = int(step)
        bodies.append(rest.partition("\n")[2])
        counts.append(bodies[-1].count("\n"))
        if counts[-1] != int(count[1]):
            raise LogTruncated(f"{source}, frame {number}: {counts[-1]} of {count[1]} rows")
    lines = "".join(bodies).splitlines()
    if not lines:
        return counts, np.empty((0, columns))
    try:
        table: Array = np.loadtxt(lines, float, comments=None, ndmin=2)
    except ValueError as error:
        ragged = "number of columns" in str(error)
        raise (LogTruncated if ragged else NotFinite)(f"{source}: {error}") from None
    if table.shape != (sum(counts), columns):
        raise LogTruncated(f"{source}: {table.shape}, not {sum(counts)} rows × {columns}")
    if not np.isfinite(table).all():
        raise NotFinite(f"{source}: a value is not finite")
    return counts, table
