"""A run of panel and particles in pieces, each resumed from the state that the last one left."""

import faulthandler
import math
import multiprocessing
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar

from pidpanel.arrays import Array
from pidpanel.coupled.beds import StartedBed, cpu_per_interval, deck_of, spheres_of
from pidpanel.coupled.checkpoints import Checkpoint, ends_of_pieces, identity_of
from pidpanel.coupled.integration import Balance, Integration, Rows
from pidpanel.coupon.liggghts.deck import WALLS_FILE, without_comments
from pidpanel.coupon.liggghts.failures import RunStopped
from pidpanel.coupon.liggghts.library import load_library
from pidpanel.coupon.preparation import BED_FILE

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
    """Do work in a child process, which may abort, hang or be killed, and return what it found.

    LIGGGHTS as a library ends its process on an error and cannot be interrupted. The child reports
    its progress; silence, or more CPU time than it was given, ends it. Wall time does not count:
    the machine may be busy.
    """
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


SILENCE_S = 300.0  # longest time without a finished row [s of wall time], which takes milliseconds

# CPU time that a piece may take over its estimate, and at least [s].
LIMIT_PER_ESTIMATE, LIMIT_AT_LEAST_S = 20.0, 600.0

# Estimated CPU time of a piece [s]: the most that a stopped run repeats. The pieces of a run are
# always the same.
PIECE_S = 8.0

# Version of the algorithms that integrate a run: `integration`, `beds` and
# `coupon.liggghts.library`. A change of the bits of a run needs a new number; runs are then
# integrated again.
INTEGRATION_VERSION = 1


def integrated(
    name: str, run: Integration, start: Array, beds: Sequence[StartedBed], folder: Path
) -> tuple[Rows, Balance]:
    """Return the rows of a run and their balance, from its last checkpoint on."""
    row_s = cpu_per_row(run, [bed.spheres for bed in beds])
    identity = run_identity(run, start, beds)
    done = Checkpoint.read(folder, identity) or Checkpoint((), run.begin(start))
    seconds = (run.rows - done.state.row) * row_s
    print(
        f"{name}: {sum(bed.spheres for bed in beds)} spheres, "
        f"{run.rows * run.intervals_per_row * run.interval:.2f} s in "
        f"{run.rows * run.intervals_per_row * run.substeps} steps"
        + (f", resumed at {done.state.row / run.rows:.0%}" if done.state.row else "")
        + f", about {seconds:.0f} s of CPU time",
        file=sys.stderr,
    )
    folder.mkdir(parents=True, exist_ok=True)
    report = _Report(name, done.state.row / run.rows)
    rows_of_piece = max(1, round(PIECE_S / row_s))
    for end in ends_of_pieces(done.state.row, run.rows, rows_of_piece):
        work = _piece(run, done, beds, end, folder)
        try:
            piece = _limited(work, name, report)
        except RunStopped as error:
            # a failure of the machine is over, one of the run comes again
            print(f"{error}; tried again", file=sys.stderr)
            piece = _limited(work, name, report)
        done = replace(piece, rows=(*done.rows, *piece.rows))
        done.write(folder, identity)
    return Rows.joined(done.rows), run.balance(done.state)


def cpu_per_row(run: Integration, spheres: Sequence[int]) -> float:
    """Return the CPU time of a row with given numbers of spheres on each patch [s]."""
    interval = sum(cpu_per_interval(count, run.substeps) for count in spheres)
    return run.intervals_per_row * interval


def _limited(work: Callable[[Progress], Checkpoint], name: str, report: Progress) -> Checkpoint:
    limit = max(LIMIT_AT_LEAST_S, LIMIT_PER_ESTIMATE * PIECE_S)
    return in_child(work, name, silence_s=SILENCE_S, cpu_limit_s=limit, progress=report)


def _piece(
    run: Integration, checkpoint: Checkpoint, beds: Sequence[StartedBed], end: int, folder: Path
) -> Callable[[Progress], Checkpoint]:
    """Return the work from a checkpoint to a row; it returns the new rows alone."""

    def work(progress: Progress) -> Checkpoint:
        with tempfile.TemporaryDirectory() as temporary:
            library = load_library()
            restarts = checkpoint.restarts or [None for _ in beds]
            particles = [
                spheres_of(library, bed, run.time_step, Path(temporary) / str(k), restart)
                for k, (bed, restart) in enumerate(zip(beds, restarts, strict=True))
            ]
            for spheres, force in zip(particles, checkpoint.forces, strict=False):
                spheres.restore_forces(force)
            rows, state = run.advance(
                particles, checkpoint.state, end, lambda row: progress((row + 1) / run.rows)
            )
            forces = tuple(spheres.forces() for spheres in particles)
            written = []
            for k, spheres in enumerate(particles):
                draft = Path(temporary) / f"{k}.restart"
                spheres.write_restart(draft)
                written.append(Path(shutil.copy(draft, folder / f"{k}_at_{end}.restart")))
            return Checkpoint((rows,), state, tuple(written), forces)

    return work


def run_identity(run: Integration, start: Array, beds: Sequence[StartedBed]) -> str:
    """Return a hash of all that the bits of a run depend on."""
    modal, nowhere = run.modal, {"walls_file": Path("walls"), "data_file": Path("spheres")}
    return identity_of(
        INTEGRATION_VERSION,
        *(modal.angular_frequency, modal.damping_ratio, modal.modal_mass),
        *(run.at_cells, run.at_points),
        *(run.patch_area, run.cell_area, run.force, start),
        *(run.time_step, run.substeps, run.intervals_per_row, run.settled),
        *(without_comments(deck_of(b, run.time_step, nowhere)) for b in beds),
        *((b.folder / name).read_text() for b in beds for name in (BED_FILE, WALLS_FILE)),
    )


class _Report:
    """Prints every tenth of a run, with the time that is left."""

    def __init__(self, name: str, done: float) -> None:
        self._name, self._begun, self._done = name, time.monotonic(), done
        self._reported = int(10 * done)

    def __call__(self, share: float) -> None:
        if int(10 * share) > self._reported:
            self._reported = int(10 * share)
            per_share = (time.monotonic() - self._begun) / (share - self._done)
            left = per_share * (1 - share)
            print(f"{self._name}: {100 * share:.0f} %, {left:.0f} s left", file=sys.stderr)
