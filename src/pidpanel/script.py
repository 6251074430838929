"""What every script of the workflow does besides its one call."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from pidpanel import durable, made
from pidpanel.locks import WORKFLOW_PROCESS, alone, end_with

MADE, TO = "--made", "--to"
"""Before the file that says what a script rests on, and before the files that it makes."""

OF_THE_MACHINE = {
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO,
    errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE,
}  # fmt: skip
"""Errors that are no fault of pidpanel."""

MALLOPT = {-4: 0, -1: 256 << 20}
"""M_MMAP_MAX and M_TRIM_THRESHOLD [bytes] of glibc: memory of arrays is used again for the next
ones. Handed back to the system, its pages are cleared each time: a tenth of the CPU time of the
response of a wing, more of that of a large one. It stays with the process until that ends."""

NOT_LOADED = ("failed to map segment", "cannot allocate memory", "Cannot allocate memory")
"""What an import says where there is no memory for its library."""


def run(main: Callable[[Sequence[str]], None]) -> None:
    """Call a script with the arguments of the process; a failure of ours ends it in one line.

    An error whose class is defined in pidpanel says what is wrong, and so does one of the machine;
    any other keeps its traceback. Files that are named after `TO` take their places when the script
    has ended, whole; their hashes are then written beside what is named after `MADE`.

    Parameters
    ----------
    main
        The script's function of its arguments.
    """
    if parent := os.environ.get(WORKFLOW_PROCESS):
        end_with(int(parent))
    _keep_memory()
    try:
        _run(main, sys.argv[1:])
    except KeyboardInterrupt:  # who pressed Ctrl-C knows why
        sys.exit(130)
    except OSError as error:
        if error.errno not in OF_THE_MACHINE:
            raise
        sys.exit(f"{error.filename or sys.argv[0]}: {error.strerror}")
    except Exception as error:
        if is_of_memory(error):
            sys.exit(f"{sys.argv[0]}: not enough memory ({error or 'no further word'})")
        if not type(error).__module__.startswith("pidpanel."):
            raise
        sys.exit(str(error))


def _keep_memory() -> None:
    """Set `MALLOPT`, where the C library is glibc."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in MALLOPT.items():
            mallopt(parameter, value)


def _run(main: Callable[[Sequence[str]], None], arguments: Sequence[str]) -> None:
    if MADE not in arguments:
        main(arguments)
        return
    end = arguments.index(MADE)
    rests = Path(arguments[end + 1])
    outputs = arguments[end + 3 :]
    with alone(rests.with_suffix(".lock")):
        with ExitStack() as stack:
            drafts = {
                path: str(stack.enter_context(durable.replacing(Path(path))))
                for path in outputs
                if path in arguments[:end]
            }
            main([drafts.get(argument, argument) for argument in arguments[:end]])
        made.write_sums(rests, outputs)


def tell_of_memory() -> None:
    """Let a process that has too little memory for its imports say so in one line."""
    before = sys.excepthook

    def hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if is_of_memory(error):
            print(f"{sys.argv[0]}: not enough memory ({error or 'no further word'})"[:500],
                  file=sys.stderr)  # fmt: skip
        else:
            before(kind, error, trace)

    sys.excepthook = hook


def is_of_memory(error: BaseException) -> bool:
    """Whether an error is one of too little memory, that of a library that is loaded too.

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


def optional(path: str) -> Path | None:
    """Return a path of the command line, or None where it says ``none``."""
    return None if path == "none" else Path(path)
