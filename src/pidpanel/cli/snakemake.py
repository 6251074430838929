"""Snakemake in its own process: run, stop, and list remaining jobs."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pidpanel.cli.workflow_process import COUNTS
from pidpanel.paths import PROFILE, SNAKEFILE

PROCESS = "pidpanel.cli.workflow_process"  # module that is Snakemake's process

LEAST_SPACE = 20e6  # space that the smallest study takes on the disk [byte]

LEAST_MEMORY = 800e6  # addresses that Snakemake takes with the smallest study, twice as many [byte]


class RunError(RuntimeError):
    """Why nothing could be run."""


class MachineError(RuntimeError):
    """A missing part of the machine: LIGGGHTS, a writable folder, space on the disk."""


def command(study: Path, folder: Path, options: Sequence[str]) -> list[str]:
    """Return the command that runs a study in a folder.

    Snakemake evaluates Python in a profile, and without another would take ``profiles/default`` of
    the working folder, whoever put it there. A profile among the options takes the place of ours.

    Targets come first of the options: some options of Snakemake take all that follows them.
    """
    # that of the Python which runs this, whatever is on the PATH or in the working folder
    snakemake = [sys.executable, "-P", "-m", PROCESS]
    profile = ["--workflow-profile", str(PROFILE)]
    places = ["--snakefile", SNAKEFILE, "--directory", folder.absolute()]
    return [
        *snakemake, *profile, *options, *map(str, places), "--configfile", str(study.absolute())
    ]  # fmt: skip


def run_workflow(study: Path, folder: Path, jobs: int, options: Sequence[str]) -> int:
    """Run Snakemake on a study; return the exit code of ``pidpanel``.

    Ctrl-C ends Snakemake, which ends its jobs; this waits for it.
    """
    release(folder)
    process = subprocess.Popen(command(study, folder, [*options, f"-j{jobs}"]))
    interrupted = False
    while True:
        try:
            status = process.wait()
            break
        except KeyboardInterrupt:
            interrupted = True
            process.send_signal(signal.SIGINT)  # `kill -INT` reaches this process alone
    if interrupted:
        raise KeyboardInterrupt
    if status:
        check_space(folder / "results")
    return 1 if status else 0


def check_space(results: Path) -> None:
    """Refuse to go on with a full disk."""
    free = shutil.disk_usage(results).free
    if free < LEAST_SPACE:
        raise MachineError(
            f"{results}: the disk is full, {free / 1e6:.0f} MB are free; free some and run the "
            "same command again"
        )


def check_memory() -> None:
    """Refuse a limit on the memory of a process with which Snakemake cannot begin."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < LEAST_MEMORY:
        raise MachineError(
            f"the memory of a process is limited to {limit / 1e6:.0f} MB (ulimit -v); at least "
            f"{LEAST_MEMORY / 1e6:.0f} MB are needed"
        )


def jobs_left(study: Path, folder: Path, *targets: str) -> dict[str, int]:
    """Return how many jobs of each rule are to be run, from a dry run of Snakemake."""
    options = [*targets, "--dry-run", "--quiet", "all", "--nolock", "-j1"]
    with tempfile.NamedTemporaryFile() as counts:
        environment = {**os.environ, "NO_COLOR": "1", COUNTS: counts.name}
        call = command(study, folder, options)
        done = subprocess.run(call, capture_output=True, text=True, check=False, env=environment)
        stats = json.loads(counts.read() or b"{}")
    if done.returncode:
        last = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        raise RunError(f"{study}: {last[-1].strip() if last else 'no message'}")
    return {rule: count for rule, count in stats.items() if rule not in ("all", "total")}


def is_running(folder: Path) -> bool:
    """Return whether a process of this machine runs Snakemake in a folder: it has its log open."""
    logs = str((folder / ".snakemake" / "log").resolve())
    for handle in Path("/proc").glob("[0-9]*/fd/*"):
        with contextlib.suppress(OSError):
            if os.readlink(handle).startswith(logs):
                return True
    return False


def release(folder: Path) -> None:
    """Unlock a folder whose Snakemake was killed, as ``snakemake --unlock`` does."""
    locks = folder / ".snakemake" / "locks"
    if any(locks.glob("*.lock")) and not is_running(folder):
        print(f"{folder}: unlocked, since no process runs Snakemake here any more", file=sys.stderr)
        shutil.rmtree(locks)
