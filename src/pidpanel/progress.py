"""How far a long stage has come, in its log: a line now and then, with the time that is left."""

import sys
import time
from collections.abc import Iterator, Sequence
from datetime import timedelta
from typing import TypeVar

T = TypeVar("T")

SECONDS_BETWEEN_LINES = 20.0


def time_left(elapsed: float, done: int, total: int) -> timedelta:
    """Return the time that the rest takes at the mean pace so far, in whole seconds.

    Examples
    --------
    >>> str(time_left(60.0, 10, 40))
    '0:03:00'
    """
    return timedelta(seconds=round(elapsed * (total - done) / done))


def tracked(
    items: Sequence[T], noun: str, seconds_between_lines: float = SECONDS_BETWEEN_LINES
) -> Iterator[T]:
    """Yield items, and print to stderr how many are done where they take long.

    Parameters
    ----------
    items
        To be worked on, of about equal cost.
    noun
        Their name in the plural.
    seconds_between_lines
        Shortest time between two lines [s].
    """
    start = last = time.monotonic()
    for done, item in enumerate(items):
        time_now = time.monotonic()
        if done and time_now - last >= seconds_between_lines:
            last = time_now
            left = time_left(time_now - start, done, len(items))
            print(f"{done} of {len(items)} {noun}, {left} left", file=sys.stderr, flush=True)
        yield item
