"""Readers for the output of LIGGGHTS: cycle rows, log, dumps.

Nothing is accepted silently. LIGGGHTS exits 0 after a SIGTERM and after too few insertions,
writes a footer that claims all steps, and leaves cut rows after a SIGKILL. So a run is accepted
only if the marks, the rows and the atom counts agree.
"""

import re
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.balance import Contacts
from pidpanel.coupon.liggghts.failures import LogTruncated, NotFinite, ParticlesLost, RunStopped

_COUNT = re.compile(r"ITEM: NUMBER OF (?:ATOMS|ENTRIES)\n(\d+)\n")

POSITION = ("x", "y", "z")  # columns of a dump: centres [m]
# Columns of a dump: centres [m] and velocities [m/s].
POSITION_AND_VELOCITY = (*POSITION, "vx", "vy", "vz")


def read_dump(text: str, source: str, columns: tuple[str, ...] = POSITION) -> Array:
    """Read frames of a ``dump custom id <columns>``, (frames, atoms, len(columns)), by id.

    Packings and beds are read by this code, so it enters their labels; see
    `pidpanel.coupon.packing`.

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
    table = _table("".join(bodies).splitlines(), source, columns)
    if len(table) != sum(counts):
        raise LogTruncated(f"{source}: {len(table)} of {sum(counts)} rows")
    return counts, table


def _table(lines: list[str], source: str, columns: int, first: int = 1) -> Array:
    """Return the numbers of lines, (n, columns), the first of them with a number in its file."""
    if not lines:
        return np.empty((0, columns))
    try:
        table: Array = np.loadtxt(lines, float, comments=None, ndmin=2)
    except ValueError as error:
        kind = LogTruncated if "number of columns" in str(error) else NotFinite
        place = re.search(r" at row (\d+)", str(error))
        line = first + int(place[1]) if place else first
        raise kind(f"{source}:{line}: {error}") from None
    if table.shape[1] != columns:
        raise LogTruncated(f"{source}:{first}: {table.shape[1]} of {columns} columns")
    if (wrong := ~np.isfinite(table).all(axis=1)).any():
        raise NotFinite(f"{source}:{first + int(np.argmax(wrong))}: a value is not finite")
    return table


# Columns of the cycle file that the shake deck writes: momentum [kg m/s] (its product with sin ωt
# and cos ωt, and itself), energies [J] and the height of the centre of mass [m]; means of a cycle.
CYCLE_COLUMNS = "step p_sin p_cos p_mean kinetic_energy rotational_energy height".split()


# Columns of a frame of the energy balance, SI.
MOTION = (
    *POSITION_AND_VELOCITY,
    *("omegax", "omegay", "omegaz", "fx", "fy", "fz", "tqx", "tqy", "tqz"),
)


# First lines of the file of cycle rows.
CYCLES_HEADER = (
    "# Time-averaged data for fix cycle",
    "# TimeStep v_p_sin v_p_cos v_p c_ke c_rot v_zc",
)


def cells_header(cells: int) -> tuple[str, str]:
    """Return the header of the file of rows by cell: momentum times sin ωt and cos ωt of each."""
    names = " ".join(f"v_p{cell}_sin v_p{cell}_cos" for cell in range(1, cells + 1))
    return "# Time-averaged data for fix cycle_cells", f"# TimeStep {names}"


def read_cycles(
    text: str,
    source: str,
    steps_per_cycle: int,
    cycles: int,
    cycles_before: int = 0,
    header: tuple[str, str] = CYCLES_HEADER,
) -> Array:
    """Read the rows of a cycle file, SI: columns `CYCLE_COLUMNS`, or those of another header.

    The step column must be 1, 2, …, ``cycles`` times the steps of a cycle, after the cycles that
    an earlier process ran. The source is the name of the file for messages.

    Raises
    ------
    LogTruncated, NotFinite
        If rows are missing or not finite, with file, line and text.
    """
    if text and not text.endswith("\n"):
        raise LogTruncated(f"{source}: cut in its last line, {text.rsplit(chr(10), 1)[-1]!r}")
    lines = text.splitlines()
    if lines[:2] != list(header):
        raise LogTruncated(f"{source}:1: header {lines[:2]!r} instead of {list(header)!r}")
    columns = len(header[1].split()) - 1
    rows = _table(lines[2:], source, columns, first=3)
    steps = steps_per_cycle * (cycles_before + 1 + np.arange(len(rows)))
    if (wrong := rows[:, 0] != steps).any():
        row = int(np.argmax(wrong))
        raise LogTruncated(f"{source}:{row + 3}: step {rows[row, 0]:g} instead of {steps[row]}")
    if len(rows) != cycles:
        raise LogTruncated(f"{source}: {len(rows)} of {cycles} cycles")
    return rows


# The line that `process.Liggghts` makes LIGGGHTS print when a command is done.
MARK = re.compile(r"^MARK step (\d+) atoms (\d+) value (\S+)$")

_TROUBLE = re.compile(
    r"^(ERROR\b.*|.*Forced restart written.*|.*[Ll]ost atoms.*|.*Less insertions.*)$"
)


def check_log(text: str, source: str, *, last_step: int, atoms: int) -> None:
    """Accept a log only if its last mark is at ``last_step`` with all ``atoms``."""
    marks = []
    for number, line in enumerate(text.splitlines(), 1):
        trouble = _TROUBLE.match(line)
        if trouble:
            lost = ("tom" in line and "ost" in line) or "insertions" in line
            raise (ParticlesLost if lost else RunStopped)(f"{source}:{number}: {line}")
        mark = MARK.match(line)
        if mark:
            marks.append((int(mark[1]), int(mark[2]), number))
    if not marks:
        raise LogTruncated(f"{source}: no mark; the deck did not run to an end")
    for _, count, number in marks:
        if count != atoms:
            raise ParticlesLost(f"{source}:{number}: {count} spheres of {atoms}")
    step, _, number = marks[-1]
    if step != last_step:
        raise RunStopped(f"{source}:{number}: last mark at step {step}, not {last_step}")


# What LIGGGHTS 3.8.0 writes before the values of a frame of a binary dump on one rank.
_BINARY_HEADER = np.dtype(
    [
        ("step", "<i8"),
        ("atoms", "<i8"),
        ("triclinic", "<i4"),
        ("boundary", "<i4", 6),
        ("box", "<f8", 6),
        ("columns", "<i4"),
        ("processes", "<i4"),
        ("values", "<i4"),
    ]
)


class SphereMotion(NamedTuple):
    """Motion of every sphere in each frame."""

    # (frames, spheres, 3) [m], [m/s], [rad/s], [N], [N m]
    position: Array
    velocity: Array
    spin: Array
    force: Array
    torque: Array


def read_motion(content: bytes, source: str, *, spheres: int) -> SphereMotion:
    """Read the binary dump of the energy balance."""
    table = read_binary_dump(content, source, atoms=spheres, columns=1 + len(MOTION))
    return SphereMotion(*(table[:, :, 3 * part + 1 : 3 * part + 4] for part in range(5)))


def contact_columns(compute: str, *, with_wall: bool, rolling: bool) -> str:
    """Return the columns of the dump of a compute that lists contacts; see `read_contacts`.

    ``pair/gran/local`` gives the two ids, ``wall/gran/local`` the mesh, the triangle and the id;
    then follow the force and, for rolling friction, the torque.
    """
    ids = (2, 3) if with_wall else (1, 2)
    values = (*ids, 4, 5, 6, 7, 8, 9) if rolling else (*ids, 4, 5, 6)
    return " ".join(f"c_{compute}[{k}]" for k in values)


def read_contacts(
    text: str, source: str, *, frames: int, ids: tuple[int, int], with_wall: bool, rolling: bool
) -> Contacts:
    """Read the local dump of contacts between spheres or with walls."""
    counts, table = read_frames(text, source, "ENTRIES", 8 if rolling else 5)
    if len(counts) != frames:
        raise LogTruncated(f"{source}: {len(counts)} of {frames} frames")
    frame = np.repeat(np.arange(frames), counts)
    left, right = table[:, 0].astype(int), table[:, 1].astype(int)
    # the wall's triangle comes first and counts from 0, ids of spheres from 1
    first, second = (right - 1, left) if with_wall else (left - 1, right - 1)
    is_complete = (table[:, 0] == left) & (table[:, 1] == right)
    in_range = (first >= 0) & (first < ids[0]) & (second >= 0) & (second < ids[1])
    if not (is_complete & in_range).all():
        worst = int(np.argmin(is_complete & in_range))
        raise ParticlesLost(
            f"{source}: contact {worst + 1} of {table[worst, 0]:g} with {table[worst, 1]:g}; there "
            f"are {ids[0]} spheres and {ids[1]} partners"
        )
    return Contacts(frame, first, second, table[:, 2:5], table[:, 5:8] if rolling else None)


def read_binary_dump(content: bytes, source: str, *, atoms: int, columns: int) -> Array:
    """Return the frames of a ``dump custom <file>.bin`` sorted by id, (frames, atoms, columns).

    The first column is the id.
    """
    frame = np.dtype([("head", _BINARY_HEADER), ("table", "<f8", (atoms, columns))])
    if not content or len(content) % frame.itemsize:
        raise LogTruncated(
            f"{source}: {len(content)} bytes, not a multiple of {frame.itemsize} for {atoms} "
            f"spheres and {columns} columns"
        )
    frames = np.frombuffer(content, frame)
    head = frames["head"]
    if (head["atoms"] != atoms).any():
        raise ParticlesLost(f"{source}: {head['atoms'].min()} spheres of {atoms}")
    if (head["columns"] != columns).any() or (np.diff(head["step"]) <= 0).any():
        raise LogTruncated(f"{source}: frames out of order or of other columns")
    table = np.array(frames["table"])
    if not np.isfinite(table).all():
        raise NotFinite(f"{source}: a value is not finite")
    if (table[:, :, 0] != np.arange(1, atoms + 1)).any():
        raise ParticlesLost(f"{source}: the ids are not 1 to {atoms}")
    return table
