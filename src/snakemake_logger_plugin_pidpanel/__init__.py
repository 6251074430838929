"""Progress of a run and the time left, in one line; all else as Snakemake writes it.

Snakemake writes ten lines for each job, which hides what matters among hundreds of coupons. This
logger (``snakemake --logger pidpanel``) keeps errors, logs of failed jobs, the table of jobs and
warnings as they are. It replaces the rest by a bar on a terminal, or elsewhere by a line per
minute, with how far long jobs have come by their own logs. The full log is in ``.snakemake/log``.
"""

import os
import sys
import tempfile
import threading
import time
from logging import ERROR, WARNING, LogRecord
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from pidpanel.progress import last_line, time_left

JOB_BY_JOB = {
    LogEvent.JOB_INFO,
    LogEvent.JOB_STARTED,
    LogEvent.JOB_FINISHED,
    LogEvent.SHELLCMD,
    LogEvent.GROUP_INFO,
    LogEvent.PROGRESS,
}
CHATTER = ("Select jobs to execute", "Execute ")
SECONDS_BETWEEN_LINES = 60.0
SECONDS_BETWEEN_LOOKS = 5.0  # after which the logs of the jobs that run are looked at


def said_last(log: Path) -> str:
    """Return how far a job has come: the last line of its log, if that tells the time left."""
    last = last_line(log)
    return "".join(filter(str.isprintable, last)) if last.endswith(" left") else ""


def find_cache() -> None:
    """Give Snakemake another folder for its cache where that of the home folder cannot be written.

    It makes one before it reads anything of a workflow; this module is imported before that.
    """
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    there = next((folder for folder in (home, *home.parents) if folder.exists()), home)
    try:
        tempfile.TemporaryFile(dir=there).close()
    except OSError:
        other = Path(tempfile.gettempdir()) / f"pidpanel-cache-{os.getuid()}"
        other.mkdir(mode=0o700, exist_ok=True)
        os.environ["XDG_CACHE_HOME"] = str(other)
        print(f"{home}: cannot be written; Snakemake keeps its cache in {other}", file=sys.stderr)


find_cache()


class LogHandler(LogHandlerBase):
    """Snakemake's own filter and formatter, with messages about single jobs drawn as progress."""

    writes_to_stream = True
    writes_to_file = False
    has_filter = False
    has_formatter = False
    needs_rulegraph = False

    def __post_init__(self) -> None:
        """Prepare the bar; Snakemake calls this once its settings are known."""
        settings = self.common_settings
        self.console = Console(
            stderr=not settings.stdout, no_color=settings.nocolor, highlight=False, soft_wrap=True
        )
        self.bar = Progress(
            TextColumn("{task.completed} of {task.total} jobs"),
            BarColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            TextColumn("{task.fields[running]}"),
            console=self.console,
            disable=not self.console.is_terminal,
            transient=True,
        )
        self.started = self.last_line = time.monotonic()
        self.jobs: dict[int, tuple[str, list[Path]]] = {}
        self.said = ""
        self.ended = threading.Event()
        self.looking = threading.Thread(target=self._look, daemon=True)

    def emit(self, record: LogRecord) -> None:
        """Write one message of Snakemake, or advance the bar."""
        try:
            event = getattr(record, "event", None)
            if event is LogEvent.RUN_INFO and not self.common_settings.dryrun:
                self._start(record.stats.get("total", 0))  # type: ignore[attr-defined]
            elif event is LogEvent.PROGRESS:
                self._advance(record.done, record.total)  # type: ignore[attr-defined]
            elif event is LogEvent.JOB_INFO:
                logs = [Path(log) for log in record.log or ()]  # type: ignore[attr-defined]
                self.jobs[record.jobid] = (record.rule_name, logs)  # type: ignore[attr-defined]
            elif event in (LogEvent.JOB_FINISHED, LogEvent.JOB_ERROR):
                number = getattr(record, "job_id", getattr(record, "jobid", None))
                self.jobs.pop(number, None)  # type: ignore[arg-type]
            if self._is_shown(record, event):
                style = {ERROR: "red", WARNING: "yellow"}.get(record.levelno, "")
                self.console.print(Text(self.format(record), style=style))
        except Exception:
            self.handleError(record)

    def close(self) -> None:
        """Remove the bar from the terminal."""
        self.ended.set()
        self.bar.stop()
        super().close()

    def _is_shown(self, record: LogRecord, event: LogEvent | None) -> bool:
        settings = self.common_settings
        if settings.verbose or settings.dryrun or record.levelno >= WARNING:
            return True
        if event is LogEvent.SHELLCMD:
            return settings.printshellcmds
        return event not in JOB_BY_JOB and not record.getMessage().startswith(CHATTER)

    def _start(self, total: int) -> None:
        self.started = self.last_line = time.monotonic()
        self.said = f"0 of {total} jobs"
        self.bar.start()
        if not self.looking.is_alive():
            self.looking.start()
        if not self.bar.tasks:
            self.bar.add_task("", total=total, left="", running="")

    def _advance(self, done: int, total: int) -> None:
        now = time.monotonic()
        left = f"{time_left(now - self.started, done, total)} left"
        self.said = f"{done} of {total} jobs, {left}"
        for task in self.bar.task_ids:  # a checkpoint may have added jobs to the total
            self.bar.update(task, completed=done, total=total, left=left)
        if self.bar.disable and (now - self.last_line > SECONDS_BETWEEN_LINES or done == total):
            self.last_line = now
            self.console.print(self.said)

    def _look(self) -> None:
        """Tell how far the jobs have come that run for long, until all ends."""
        while not self.ended.wait(SECONDS_BETWEEN_LOOKS):
            running = list(self.jobs.values())
            told = [
                f"{rule}: {said}" for rule, logs in running for said in map(said_last, logs) if said
            ]
            for task in self.bar.task_ids:
                self.bar.update(task, running="; ".join(told))
            silent = time.monotonic() - self.last_line
            if told and self.bar.disable and silent > SECONDS_BETWEEN_LINES:
                self.last_line = time.monotonic()
                self.console.print("; ".join([self.said, *told]))
