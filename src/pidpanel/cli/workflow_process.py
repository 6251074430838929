"""Snakemake, which Ctrl-C ends without a traceback wherever it is.

Started as ``python -m pidpanel.cli.workflow_process`` with the arguments of ``snakemake``. While
jobs run, Snakemake ends them first; that they failed then is no news.

Jobs of this machine start without Snakemake's limit of their rate: with one, each job that has
ended makes a look at the ready jobs more each second (snakemake/snakemake#3744), which takes as
much as LIGGGHTS after a few hundred.
"""

import json
import logging
import os
import signal
import sys
import tempfile
from pathlib import Path
from types import FrameType
from typing import NoReturn

from pidpanel.job import WORKFLOW_PROCESS

# Variable with a file for the numbers of the jobs of a dry run, by rule.
COUNTS = "PIDPANEL_COUNTS"


def write_counts(record: logging.LogRecord) -> bool:
    """Write the numbers of jobs by rule of a message of Snakemake that has them, as JSON."""
    if stats := getattr(record, "stats", None):
        Path(os.environ[COUNTS]).write_text(json.dumps(stats), encoding="utf-8")
    return True


def find_cache() -> None:
    """Give Snakemake another folder for its cache where that of the home folder is read-only."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    existing = next((folder for folder in (home, *home.parents) if folder.exists()), home)
    try:
        tempfile.TemporaryFile(dir=existing).close()
    except OSError:
        other = Path(tempfile.gettempdir()) / f"pidpanel-cache-{os.getuid()}"
        other.mkdir(mode=0o700, exist_ok=True)
        os.environ["XDG_CACHE_HOME"] = str(other)
        print(f"{home}: cannot be written; Snakemake keeps its cache in {other}", file=sys.stderr)


def interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
    """Say nothing more, and stop; a second Ctrl-C does not disturb the end of the jobs."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.disable(logging.CRITICAL)
    raise KeyboardInterrupt


def run_snakemake(arguments: list[str]) -> int:
    """Return the exit code of ``snakemake`` with some arguments."""
    find_cache()
    from snakemake.cli import args_to_api, parse_args
    from snakemake.exceptions import print_exception

    if COUNTS in os.environ:
        from snakemake.logging import logger

        logger.addFilter(write_counts)  # handlers are removed when Snakemake begins

    try:
        parser, parsed = parse_args(arguments)
        if parsed.executor in (None, "local"):
            parsed.max_jobs_per_timespan = None
        return 0 if args_to_api(parsed, parser) else 1
    except Exception as error:
        print_exception(error)
        return 1


def main() -> None:
    """Run Snakemake; exit with its code, or with 130 after Ctrl-C."""
    # no job of a workflow that this process, or one above it, has planned
    os.environ.pop(WORKFLOW_PROCESS, None)
    try:
        # a process in the background ignores Ctrl-C, and so it stays
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, interrupt)
        sys.argv[0] = "snakemake"
        sys.exit(run_snakemake(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)


if __name__ == "__main__":
    main()
