"""Runs the rules of a study without LIGGGHTS in forks of this process.

Snakemake takes seconds before its first job, and each of its jobs imports the same libraries. Here
a job is a fork of a process that has imported them. What runs is decided as Snakemake decides it,
by the requests and the time stamps; jobs, files and failures are the same, and each accepts what
the other made. Of Snakemake's own records none is written.
"""

import contextlib
import gc
import importlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NoReturn

from pidpanel.paths import WORKFLOW
from pidpanel.progress import CORES
from pidpanel.provenance import durable
from pidpanel.provenance.job import arguments_of, run
from pidpanel.workflow.plan import Plan
from pidpanel.workflow.rules import Rule


def run_rules(plan: Plan, rules: Mapping[str, Rule], jobs: int) -> bool:
    """Run the rules of a study that have to run, in the working folder.

    Parameters
    ----------
    rules
        Rules by name, each after those whose results it reads.
    jobs
        Number of parallel jobs.

    Returns
    -------
    bool
        Whether none failed. Those that need no result of a failed one are run.
    """
    files = {name: plan.request(rule) for name, rule in rules.items()}
    plan.begin()
    due = _due(rules, files)
    log = Path(plan.results("run.log"))
    log.write_text("", encoding="utf-8")
    if not due:
        print("Nothing to be done: all files are present and up to date.", file=sys.stderr)
        return True
    sys.path.insert(0, str(WORKFLOW))
    calls = _Calls(plan, {name: rules[name] for name in due}, files)
    try:
        while calls.waiting or calls.running:
            ready = calls.ready()[: jobs - len(calls.running)]
            for name in ready:
                calls.start(name, max(1, jobs // (len(ready) + len(calls.running))))
            # while they run, what the next ones import
            for name in calls.waiting:
                importlib.import_module(f"scripts.{name}")
            calls.wait(log)
    except KeyboardInterrupt:
        calls.stop()
        raise
    return not calls.failed


def _inputs(rule: Rule) -> Iterator[str]:
    for files in rule.input.values():
        yield from [files] if isinstance(files, str) else files


def _due(rules: Mapping[str, Rule], files: Mapping[str, str]) -> list[str]:
    """Return the rules whose output is missing or older than an input, and all after them."""
    due: list[str] = []
    updated: set[str] = set()
    for name, rule in rules.items():
        times = [_modified(file) for file in rule.output.values()]
        newest = max(_modified(file) or 0 for file in (files[name], *_inputs(rule)))
        is_new = not updated.isdisjoint(_inputs(rule))
        if is_new or None in times or newest > min(time or 0 for time in times):
            due.append(name)
            updated.update(rule.output.values())
    return due


def _modified(file: str) -> float | None:
    try:
        return os.stat(file).st_mtime
    except OSError:
        return None


class _Calls:
    """Jobs that wait, run, and have failed."""

    def __init__(self, plan: Plan, rules: Mapping[str, Rule], requests: Mapping[str, str]) -> None:
        self.plan, self.rules, self.requests = plan, rules, requests
        self.waiting = list(rules)
        self.failed: list[str] = []
        self.running: dict[int, tuple[str, float]] = {}

    def ready(self) -> list[str]:
        """Return those that wait for no other."""
        unmade = {*self.waiting, *(name for name, _ in self.running.values())}
        awaited = {file for name in unmade for file in self.rules[name].output.values()}
        return [name for name in self.waiting if awaited.isdisjoint(_inputs(self.rules[name]))]

    def start(self, name: str, cores: int) -> None:
        """Fork a job, which may use up to ``cores`` cores."""
        rule = self.rules[name]
        self.waiting.remove(name)
        importlib.import_module(f"scripts.{name}")
        for file in (*rule.output.values(), rule.log):
            Path(file).parent.mkdir(parents=True, exist_ok=True)
        self.discard(name)
        # by the age of its benchmark file Snakemake would find a job too old
        durable.discard(Path(self.plan.results(f"benchmark/{name}.tsv")))
        sys.stdout.flush()
        sys.stderr.flush()
        gc.freeze()  # what is imported is no garbage: the job need not look for any there
        # Ctrl-C would be lost in what Python calls around a fork
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            process = os.fork()
            if process == 0:
                _work(name, rule, self.requests[name], cores)
            self.running[process] = (name, time.monotonic())
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

    def discard(self, name: str) -> None:
        """Remove what a job has made."""
        for file in self.rules[name].output.values():
            durable.discard(Path(file))

    def wait(self, log: Path) -> None:
        """Wait until a job ends; what a failed one made is removed, what waits for it given up."""
        process, status = os.waitpid(-1, 0)
        name, begun = self.running.pop(process)
        if status:
            self._fail(name, log)
            return
        seconds = time.monotonic() - begun
        left = len(self.waiting) + len(self.running)
        done = len(self.rules) - len(self.failed) - left
        print(f"{done} of {len(self.rules)} jobs: {name}, {seconds:.0f} s", file=sys.stderr)

    def _fail(self, name: str, log: Path) -> None:
        rule = self.rules[name]
        self.failed.append(name)
        self.discard(name)
        lost = set(rule.output.values())
        for follower in list(self.waiting):
            if not lost.isdisjoint(_inputs(self.rules[follower])):
                self.waiting.remove(follower)
                self.failed.append(follower)
                lost.update(self.rules[follower].output.values())
        text = f"Error in rule {name}:\n    log: {rule.log} (check log file(s) for error details)\n"
        with log.open("a", encoding="utf-8") as stream:
            stream.write(text)
        messages = Path(rule.log).read_text(encoding="utf-8", errors="replace")
        print(text + messages, end="", file=sys.stderr)

    def stop(self) -> None:
        """End the jobs that run, after Ctrl-C, which has reached them where it came from a key."""
        for process in self.running:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGINT)
        for process, (name, _) in self.running.items():
            _, status = os.waitpid(process, 0)
            if status:
                self.discard(name)


def _work(name: str, rule: Rule, request: str, cores: int) -> NoReturn:
    """Run a job in the fork that this is, as a script of the workflow, and end."""
    status = 1
    try:
        log = os.open(rule.log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        os.dup2(log, sys.stderr.fileno())
        os.environ[CORES] = str(cores)
        files = {"input": {**rule.input, "request": request}, "output": rule.output}
        sys.argv = [f"{name}.py", *arguments_of(**files, params=rule.params)]
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        run(importlib.import_module(f"scripts.{name}").main)
        status = 0
    except SystemExit as end:
        print(end.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
