"""Work in a process of its own, which may abort, hang or be killed without taking the caller along.

LIGGGHTS as a library ends its process on an error and cannot be interrupted. The child reports its
progress; silence, or more CPU time than it was given, ends it. Wall time is not limited, since the
machine may be busy.
"""

import faulthandler
import math
import multiprocessing
import os
import resource
import signal
import tempfile
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from pidpanel.coupon.liggghts.failures import RunStopped

Result = TypeVar("Result")
Progress = Callable[[float], None]  # takes the share of the work that is done [1]

LAST_WORDS = 2000  # characters of the child's output that a failure repeats


def in_child(
    work: Callable[[Progress], Result],
    name: str,
    *,
    silence_s: float,
    cpu_limit_s: float,
    progress: Progress = lambda _: None,
) -> Result:
    """Do work in a child and return what it found."""
    # the state of the caller as it is; nothing that runs in threads is in use here
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    with tempfile.TemporaryFile() as output:
        arguments = (work, sender, output.fileno(), os.getpid(), cpu_limit_s)
        child = context.Process(target=_work, args=arguments)
        child.start()
        sender.close()
        try:
            while True:
                if not receiver.poll(silence_s):
                    raise RunStopped(f"{name}: no progress for {silence_s:.0f} s")
                kind, value = receiver.recv()
                if kind == "found":
                    return value
                if kind == "failed":
                    raise value
                progress(value)
        except EOFError:
            child.join()
            if child.exitcode == -signal.SIGXCPU:
                limit = f"more than {cpu_limit_s:.0f} s of CPU time"
                raise RunStopped(f"{name}: {limit}") from None
            output.seek(max(0, output.seek(0, os.SEEK_END) - LAST_WORDS))
            words = output.read().decode(errors="replace").strip("\0 \n")
            errors = [line for line in words.splitlines() if "ERROR" in line]
            last = (errors or words.splitlines() or ["no message"])[0 if errors else -1]
            raise RunStopped(f"{name}: exit status {child.exitcode}: {last}") from None
        finally:
            child.kill()
            child.join()
            receiver.close()


def _work(
    work: Callable[[Progress], Any], to: Connection, output: int, parent: int, cpu_limit_s: float
) -> None:
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    soft = math.ceil(cpu_limit_s)
    if hard != resource.RLIM_INFINITY:
        soft = min(soft, hard)
    resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))
    faulthandler.disable()  # that of the caller would print an abort to the caller's screen
    os.dup2(output, 1)
    os.dup2(output, 2)

    def progress(share: float) -> None:
        if os.getppid() != parent:
            os._exit(1)
        os.ftruncate(output, 0)  # LIGGGHTS prints at every run, and would fill the disk
        to.send(("progress", share))

    try:
        to.send(("found", work(progress)))
    except Exception as error:
        to.send(("failed", error))
    to.close()
    # what the library leaves open is not to be taken down step by step
    os._exit(0)
