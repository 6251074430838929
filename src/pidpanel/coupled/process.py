"""Work in a process of its own, which may abort, hang or be killed without taking the caller along.

LIGGGHTS as a library ends its process on an error and cannot be interrupted. The child tells how
far it is; silence, or more time than it was given, ends it.
"""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from pidpanel.coupon.liggghts.failures import RunStopped

Found = TypeVar("Found")
Progress = Callable[[float], None]
"""Takes the share of the work that is done [1]."""

LAST_WORDS = 2000
"""Characters of the child's output that a failure repeats."""


def in_child(
    work: Callable[[Progress], Found],
    what: str,
    *,
    silence_s: float,
    limit_s: float,
    progress: Progress = lambda _: None,
) -> Found:
    """Do work in a child and return what it found.

    Parameters
    ----------
    work
        Told how to tell its progress, which it does often.
    what
        Name of the work, for messages.
    silence_s
        Longest time without a word [s].
    limit_s
        Longest time in all [s].
    progress
        Is told what the child tells.

    Raises
    ------
    RunStopped
        If the child ends without a result, says nothing or takes too long; with its last words.
    """
    # the state of the caller as it is; nothing that runs in threads is in use here
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    with tempfile.TemporaryFile() as said:
        child = context.Process(target=_work, args=(work, there, said.fileno(), os.getpid()))
        child.start()
        there.close()
        begun = time.monotonic()
        try:
            while True:
                left = limit_s - (time.monotonic() - begun)
                if not here.poll(max(min(silence_s, left), 0.0)):
                    reason = "time limit" if left <= silence_s else "no word for"
                    seconds = limit_s if left <= silence_s else silence_s
                    raise RunStopped(f"{what}: {reason} {seconds:.0f} s")
                kind, value = here.recv()
                if kind == "found":
                    found: Found = value
                    return found
                if kind == "failed":
                    raise value
                progress(value)
        except EOFError:
            child.join()
            said.seek(0)
            words = said.read()[-LAST_WORDS:].decode(errors="replace").strip()
            errors = [line for line in words.splitlines() if "ERROR" in line]
            last = (errors or words.splitlines() or ["no message"])[0 if errors else -1]
            raise RunStopped(f"{what}: exit status {child.exitcode}: {last}") from None
        finally:
            child.kill()
            child.join()
            here.close()


def _work(work: Callable[[Progress], Any], to: Connection, said: int, parent: int) -> None:
    faulthandler.disable()  # that of the caller would tell of an abort on the caller's screen
    os.dup2(said, 1)
    os.dup2(said, 2)

    def progress(share: float) -> None:
        if os.getppid() != parent:
            os._exit(1)
        to.send(("progress", share))

    try:
        to.send(("found", work(progress)))
    except Exception as error:
        to.send(("failed", error))
    to.close()
    # what the library leaves open is not to be taken down step by step
    os._exit(0)
