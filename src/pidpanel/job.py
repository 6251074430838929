"""A job of Snakemake: its study, its log, failures in one line, its end with Snakemake.

A script imports this first: before what takes memory, and before numpy, which takes the number of
its threads from the environment. More than one changes bits.
"""

import contextlib
import ctypes
import errno
import gc
import os
import pickle
import select
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

# Variable with the number of the Snakemake process of this machine for which scripts run.
WORKFLOW_PROCESS = "PIDPANEL_WORKFLOW_PROCESS"

# Errors that are no fault of pidpanel.
MACHINE_ERRORS = {
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO,
    errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE,
}  # fmt: skip

# M_MMAP_MAX and M_TRIM_THRESHOLD [bytes] of glibc: memory of arrays is used again for the next
# ones. Handed back to the system, its pages are cleared each time: a tenth of the CPU time of the
# response of a wing, more of that of a large one. It stays with the process until that ends.
MALLOPT = {-4: 0, -1: 256 << 20}

# Messages of an import without memory for its library.
NOT_LOADED = ("failed to map segment", "cannot allocate memory", "Cannot allocate memory")


@contextlib.contextmanager
def started(snakemake: Any) -> Iterator[Any]:
    """Write to the log of a job; give its study and files; known failures end it with one line.

    An error of a class of pidpanel, or of the machine, is printed as one line; any other keeps its
    traceback. The job ends when Snakemake does, however that ends.
    """
    from pidpanel.progress import CORES
    from pidpanel.provenance.files import Files

    gc.enable()
    log = os.open(str(snakemake.log), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    os.dup2(log, sys.stderr.fileno())
    os.environ[CORES] = str(snakemake.threads)
    if parent := os.environ.get(WORKFLOW_PROCESS):
        end_with(int(parent))
    keep_memory()
    try:
        # packed, so that nothing of it is imported before this module
        study = pickle.loads(snakemake.config["study"])
        yield study, Files(snakemake.input), Files(snakemake.output)
    except KeyboardInterrupt:  # who pressed Ctrl-C knows why
        sys.exit(130)
    except Exception as error:
        message = one_line(error)
        if message is None:
            raise
        sys.exit(message)


def folders(snakemake: Any, *names: str) -> list[Path | None]:
    """Return folders among the parameters of a job; None for one that a study has not."""
    paths = (snakemake.params[name] for name in names)
    return [None if path is None else Path(path) for path in paths]


def one_line(error: Exception) -> str | None:
    """Return a failure that has a name as one line; None for a bug."""
    if is_of_memory(error):
        return f"not enough memory ({error or 'no further word'})"
    if isinstance(error, OSError) and error.errno in MACHINE_ERRORS:
        return f"{error.filename or 'a file'}: {error.strerror}"
    return str(error) if type(error).__module__.startswith("pidpanel.") else None


def keep_memory() -> None:
    """Set `MALLOPT`, where the C library is glibc."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in MALLOPT.items():
            mallopt(parameter, value)


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


def is_of_memory(error: BaseException) -> bool:
    """Return whether an error means too little memory, also for loading a library.

    Examples
    --------
    >>> is_of_memory(ImportError("libm.so.6: failed to map segment from shared object"))
    True
    >>> is_of_memory(ImportError("No module named 'gmsh'"))
    False
    """
    if isinstance(error, ImportError):
        return any(words in str(error) for words in NOT_LOADED)
    if isinstance(error, RuntimeError):
        return "can't start new thread" in str(error)
    return isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM


def _memory_hook(kind: type[BaseException], error: BaseException, trace: TracebackType) -> None:
    """Report too little memory for the imports of a job in one line."""
    if is_of_memory(error):
        print(f"not enough memory ({error or 'no further word'})"[:500], file=sys.stderr)
    else:
        sys.__excepthook__(kind, error, trace)


def prepare() -> None:
    """Prepare the process of a script, whose imports follow."""
    for library in ("OMP", "OPENBLAS", "GOTO", "MKL", "NUMEXPR"):  # Snakemake sets `threads`
        os.environ[f"{library}_NUM_THREADS"] = "1"
    sys.excepthook = _memory_hook  # type: ignore[assignment]
    gc.disable()  # until it has started: a tenth of the time of its imports


if hasattr(sys.modules["__main__"], "snakemake"):  # a script of Snakemake, as it begins
    prepare()
