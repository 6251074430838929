"""Time limit of this process: a run that takes longer stops where another process resumes it.

On a cluster the time of a job is limited. A run can stop where it writes a restart
(`runs.CHECKPOINT`). That is at the same cycles whether or not it stops there, so its results do not
depend on the length of its jobs.
"""

import contextlib
import math
import time
from collections.abc import Iterator


class Continues(Exception):
    """The time is over; another process goes on from the restart that was left."""


class _Deadline:
    end = math.inf  # on the monotonic clock [s]


@contextlib.contextmanager
def limit(seconds: float) -> Iterator[None]:
    """Let runs stop in time, for this process as a whole.

    Parameters
    ----------
    seconds
        Time from now [s]; infinite for no limit.
    """
    previous = _Deadline.end
    _Deadline.end = min(previous, time.monotonic() + seconds)
    try:
        yield
    finally:
        _Deadline.end = previous


def check(longest: float) -> None:
    """Stop where what comes next would take too long.

    Parameters
    ----------
    longest
        Time of the next stretch of the run [s].

    Raises
    ------
    Continues
        If the deadline is before its end.
    """
    if time.monotonic() + longest > _Deadline.end:
        raise Continues(f"stopped {longest:.0f} s before the time limit; the next job continues")
