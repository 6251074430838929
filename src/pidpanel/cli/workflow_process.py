"""Snakemake, which Ctrl-C ends without a traceback wherever it is.

Started as ``python -m pidpanel.cli.workflow_process`` with the arguments of ``snakemake``. While
jobs run, Snakemake ends them first; that they failed then is no news.
"""

import logging
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

from pidpanel.provenance.locks import WORKFLOW_PROCESS


def interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
    """Say nothing more, and stop."""
    logging.disable(logging.CRITICAL)
    raise KeyboardInterrupt


def main() -> None:
    """Run Snakemake; exit with its code, or with 130 after Ctrl-C."""
    # no job of a workflow that this process, or one above it, has planned
    os.environ.pop(WORKFLOW_PROCESS, None)
    try:
        # a process in the background ignores Ctrl-C, and so it stays
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, interrupt)
        from snakemake.cli import main as snakemake

        sys.argv[0] = "snakemake"
        snakemake()
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
