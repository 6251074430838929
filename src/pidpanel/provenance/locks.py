"""Locks of what two processes must not write at the same time, and the end of orphans."""

import contextlib
import fcntl
import os
import select
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO

# Variable with the number of the Snakemake process of this machine for which scripts run.
WORKFLOW_PROCESS = "PIDPANEL_WORKFLOW_PROCESS"

RUNNING = ".running"  # file in a folder of results that the workflow locks


@contextlib.contextmanager
def exclusive_lock(path: Path) -> Iterator[None]:
    """Wait until no other process holds the lock of a file, which stays, and hold it.

    It ends with the process that holds it, however that ends. On a file system without locks
    nothing is waited for.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+", encoding="ascii") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            holder = file.read().strip() or "another process"
            print(f"{path}: waiting for {holder}, which writes the same files", file=sys.stderr)
            fcntl.flock(file, fcntl.LOCK_EX)
        except OSError:
            yield
            return
        file.truncate(0)
        file.write(f"process {os.getpid()} on {os.uname().nodename}")
        file.flush()
        yield


def hold(folder: Path) -> IO[str] | None:
    """Lock a folder of results for the workflow of this process; None if another process has it.

    The lock ends with the process, however that ends, so there is nothing to unlock by hand. On a
    file system without locks the file is open but not locked.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = (folder / RUNNING).open("a", encoding="ascii")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.close()
        return None
    except OSError:
        pass
    return lock


def end_with(parent: int) -> None:
    """End this process at once when another one ends, and with it what was started by it."""
    try:
        handle = os.pidfd_open(parent)
    except (OSError, AttributeError):
        return
    if parent not in _ancestors():
        os.close(handle)
        return

    def watch() -> None:
        select.select([handle], [], [])
        print(f"process {parent}, for which this ran, has ended", file=sys.stderr, flush=True)
        os.kill(os.getpid(), signal.SIGKILL)

    threading.Thread(target=watch, daemon=True).start()


def _ancestors() -> list[int]:
    """Return numbers of the processes from which this one descends."""
    processes = [os.getppid()]
    while processes[-1] > 1:
        try:
            status = Path(f"/proc/{processes[-1]}/stat").read_text(errors="replace")
        except OSError:
            break
        # the name of the program, in brackets, may hold anything
        processes.append(int(status.rpartition(")")[2].split()[1]))
    return processes
