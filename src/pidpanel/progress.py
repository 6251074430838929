"""Long computations in parallel, with progress in the log."""

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from datetime import timedelta
from pathlib import Path
from typing import Any, TypeVar

from pidpanel.job import end_with

T = TypeVar("T")
Result = TypeVar("Result")

# Environment variable with the number of cores of a stage. No result depends on it.
CORES = "PIDPANEL_CORES"

SECONDS_BETWEEN_LINES = 20.0  # shortest time between two lines of a log [s]

END_OF_LOG = 4096  # bytes read at the end of a log


def time_left(elapsed: float, done: int, total: int) -> timedelta:
    """Return the remaining time at the mean pace so far, in whole seconds.

    Examples
    --------
    >>> str(time_left(60.0, 10, 40))
    '0:03:00'
    """
    return timedelta(seconds=round(elapsed * (total - done) / done))


def with_progress(items: Sequence[T], noun: str) -> Iterator[T]:
    """Yield items, and print progress to stderr if it takes long.

    Parameters
    ----------
    items
        Items of about equal cost.
    noun
        Name of the items in the plural.
    """
    start = last = time.monotonic()
    for done, item in enumerate(items):
        time_now = time.monotonic()
        if done and time_now - last >= SECONDS_BETWEEN_LINES:
            last = time_now
            left = time_left(time_now - start, done, len(items))
            print(f"{done} of {len(items)} {noun}, {left} left", file=sys.stderr, flush=True)
        yield item


def last_line(log: Path) -> str:
    """Return the last line of a log that is not empty; an empty text if there is no log."""
    try:
        with log.open("rb") as file:
            file.seek(max(0, log.stat().st_size - END_OF_LOG))
            text = file.read().decode("utf-8", "replace")
    except OSError:
        return ""
    return next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "")


def map_in_forks(function: Callable[[T], Result], items: Sequence[T]) -> Iterator[Result]:
    """Yield the function of each item, computed in forks if the stage has several cores.

    Parameters
    ----------
    function
        Function of an item. It runs in a fork: side effects are lost, the result is pickled.
    items
        Numbers or slices of about equal cost.

    Examples
    --------
    >>> list(map_in_forks(abs, [-1, 2]))
    [1, 2]
    """
    cores = min(int(os.environ.get(CORES, "1")), len(items))
    if cores < 2:
        yield from map(function, items)
        return
    context = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(cores, context, _begin, (function, os.getpid())) as pool:
        yield from pool.map(_call, items)


_work: list[Callable[[Any], Any]] = []  # the function of this fork


def _begin(function: Callable[[Any], Any], parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its forks
    os.environ[CORES] = "1"
    end_with(parent)
    _work[:] = [function]


def _call(item: Any) -> Any:
    return _work[0](item)
