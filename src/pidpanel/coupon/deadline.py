"""How long this process may go on: a run that takes longer stops where another process resumes it.

On a cluster a job has so much time and no more. A run can stop where it leaves a restart
(`runs.CHECKPOINT`), which is at the same cycles whether or not anything stops there, so that its
numbers do not depend on how long its jobs were.
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
