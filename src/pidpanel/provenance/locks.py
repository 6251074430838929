"""Two processes that must not write the same files at the same time, and orphans that must not."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import select
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO

WORKFLOW_PROCESS = "PIDPANEL_WORKFLOW_PROCESS"
"""Variable with the number of the Snakemake process of this machine for which scripts run."""

RUNNING = ".running"
"""File in a folder of results that the workflow locks."""


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
            if not _end_orphan(holder):
                print(f"{path}: waiting for {holder}, which writes the same files", file=sys.stderr)
            fcntl.flock(file, fcntl.LOCK_EX)
        except OSError:
            yield
            return
        file.truncate(0)
        file.write(_holder(os.getpid(), os.environ.get(WORKFLOW_PROCESS, "")))
        file.flush()
        yield


def _holder(process: int, workflow: str) -> str:
    return f"process {process} on {os.uname().nodename}" + (f" for {workflow}" if workflow else "")


def _end_orphan(holder: str) -> bool:
    """End a stopped job of this machine whose workflow was killed: it cannot end itself."""
    words = re.fullmatch(r"process (\d+) on .* for (\d+)", holder)
    if words is None or holder != _holder(int(words[1]), words[2]):
        return False
    process, workflow = int(words[1]), int(words[2])
    try:
        command = Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
        # a script, or a fork of the command
        is_job = any(
            word.startswith(b"scripts.") or word.endswith(b"/pidpanel") for word in command
        )
        if Path(f"/proc/{workflow}").exists() or not is_job or workflow in _ancestors(process):
            return False
        os.kill(process, signal.SIGKILL)
    except OSError:
        return False
    print(f"process {process}: left by a run that was killed; ended", file=sys.stderr, flush=True)
    return True


def is_running(results: Path) -> bool:
    """Whether a workflow runs in a folder of results."""
    for file in results.glob(f"*/{RUNNING}"):
        with file.open("a", encoding="ascii") as lock, contextlib.suppress(OSError):
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return True
    return False


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


def _ancestors(process: int | None = None) -> list[int]:
    """Numbers of the processes from which one descends, this one by default."""
    processes = [os.getppid() if process is None else process]
    while processes[-1] > 1:
        try:
            status = Path(f"/proc/{processes[-1]}/stat").read_text(errors="replace")
        except OSError:
            break
        # the name of the program, in brackets, may hold anything
        processes.append(int(status.rpartition(")")[2].split()[1]))
    return processes
