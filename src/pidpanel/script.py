"""What every script of the workflow does besides its one call."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from pidpanel import durable, made
from pidpanel.locks import alone, end_with

WORKFLOW_PROCESS = "PIDPANEL_WORKFLOW_PROCESS"
"""Variable with the number of the Snakemake process of this machine for which scripts run."""

MADE, TO = "--made", "--to"
"""Before the file that says what a script rests on, and before the files that it makes."""

OF_THE_MACHINE = {
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO,
    errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE,
}  # fmt: skip
"""Errors that are no fault of pidpanel."""

MALLOPT = {-3: 32 << 20, -1: 256 << 20}
"""M_MMAP_THRESHOLD and M_TRIM_THRESHOLD of glibc [bytes]: memory of arrays up to 32 MB is used
again for the next ones. Handed back to the system, its pages are cleared each time, a tenth of the
CPU time of the response of a wing."""


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
    except MemoryError as error:
        sys.exit(f"{sys.argv[0]}: not enough memory ({error or 'no further word'})")
    except OSError as error:
        if error.errno not in OF_THE_MACHINE:
            raise
        sys.exit(f"{error.filename or sys.argv[0]}: {error.strerror}")
    except Exception as error:
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


def optional(path: str) -> Path | None:
    """Return a path of the command line, or None where it says ``none``."""
    return None if path == "none" else Path(path)
