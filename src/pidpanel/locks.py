"""Two processes that must not write the same files at the same time, and orphans that must not."""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def alone(path: Path) -> Iterator[None]:
    """Wait until no other process holds a lock, and hold it.

    It ends with the process that holds it, however that ends. On a file system without locks
    nothing is waited for.

    Parameters
    ----------
    path
        File of the lock, which stays.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+", encoding="ascii") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            holder = file.read().strip() or "another process"
            print(f"{path}: waits for {holder}, which writes the same files", file=sys.stderr)
            fcntl.flock(file, fcntl.LOCK_EX)
        except OSError:
            yield
            return
        file.truncate(0)
        file.write(f"process {os.getpid()} on {os.uname().nodename}")
        file.flush()
        yield


def end_with(parent: int) -> None:
    """End this process at once when another one ends, and with it what was started by it.

    Parameters
    ----------
    parent
        Number of a process of this machine; nothing is done if it cannot be watched.
    """
    try:
        handle = os.pidfd_open(parent)
    except (OSError, AttributeError):
        return

    def watch() -> None:
        select.select([handle], [], [])
        print(f"process {parent}, for which this ran, has ended", file=sys.stderr, flush=True)
        os.kill(os.getpid(), signal.SIGKILL)

    threading.Thread(target=watch, daemon=True).start()
