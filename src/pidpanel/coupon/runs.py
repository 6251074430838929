"""Shake a run to its required accuracy, in ``results/coupon/<case>/s<seed>``.

The folder holds all cycles of the run so far: their rows, a restart at the last of them, and
``state.json`` with the valid contents of the files. A target that requires more continues from
there; one that requires less reads the rows that it would have run itself. The energy balance is
measured where a target is met, and kept for each target; where it is missing, the run
is repeated to there. So a study gives the same numbers, to the last bit, whatever ran before.
"""

import contextlib
import math
import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pidpanel.coupon import geometry, rows, window
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import RunTarget
from pidpanel.coupon.liggghts import output
from pidpanel.coupon.liggghts.failures import ParticlesLost, RunStopped
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.preparation import read_bed, write_start
from pidpanel.coupon.records import End, RunState, Shaken, check_files
from pidpanel.provenance import durable


class Continues(Exception):
    """The time is over; another process goes on from the restart that was left."""


class _Deadline:
    end = math.inf  # on the monotonic clock [s]


@contextlib.contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Let runs stop in time, for this process as a whole.

    On a cluster a job has so much time and no more. A run can stop where it leaves a restart
    (`CHECKPOINT`), which is at the same cycles whether or not anything stops there, so that its
    numbers do not depend on how long its jobs were.

    Parameters
    ----------
    seconds
        Time from now [s]; infinite for no limit.
    """
    previous = _Deadline.end
    _Deadline.end = min(previous, time.monotonic() + seconds)
    try:
        yield
    finally:
        _Deadline.end = previous


def check_time(longest: float) -> None:
    """Stop where what comes next would take too long.

    Parameters
    ----------
    longest
        Time of the next stretch of the run [s].

    Raises
    ------
    Continues
        If the deadline is before its end.
    """
    if time.monotonic() + longest > _Deadline.end:
        raise Continues(f"stopped {longest:.0f} s before the time limit; the next job continues")


REPEAT_FOLDER = "again"  # folder below that of a run in which it is repeated to an earlier end


def last_file(cycles: int) -> str:
    """Return the name of the file of the spheres after the cycles in which a run met a target.

    Its columns are `output.POSITION_AND_VELOCITY`.
    """
    return f"at_{cycles}.dump"


# CPU time of a step, and of it for each sphere, by which work is divided [s]: that of a core which
# is one to four times slower than those of today.
ORDINARY_STEP = 15e-6, 0.35e-6

# Longest time between two restarts on such a core [s], but never less than a cycle. A run goes
# cycle by cycle, so that a restart after any of them changes no bit of it.
CHECKPOINT = 600.0


def shake(run: Run, target: RunTarget, bed_folder: Path, folder: Path) -> Shaken:
    """Shake one run until its error target or its last cycle: files in ``folder``.

    ``shake_<leg>.in`` runs again under ``liggghts -in``; ``cycles_<leg>.txt`` are the rows,
    ``shake_<leg>.log`` the log, ``at_<cycles>.dump`` the spheres where it met a target.

    Raises
    ------
    SolverFailure
        If the run fails; the class is the reason.
    """
    state = _resumed(run, target, folder) or _begun(run, bed_folder, folder)
    solver: Liggghts | None = None
    with contextlib.ExitStack() as stack:
        while True:
            done, good = _judged(run, target, state, folder)
            if done <= state.cycles:
                break
            if solver is None:
                solver = stack.enter_context(_started(run, state, folder))
                state = replace(state, legs=(*state.legs, 0))
            begun = time.monotonic()
            stop = done
            if run.deck is None:  # a restart need not hold all of a deck of the user's own
                stop = min(done, state.cycles + cycles_between_restarts(run, state.spheres))
            state = _continued(solver, run, state, folder, stop)
            if run.deck is None:
                check_time(time.monotonic() - begun)
        end = _end_at(state, done)
        if end is None:
            home = folder
            if solver is None and done == state.cycles and run.deck is None:
                solver = stack.enter_context(_started(run, state, folder))
            elif solver is None:
                # it ends before the last restart, or a restart need not hold all of the deck:
                # LIGGGHTS runs to there from nothing, to the same bits
                home = folder / REPEAT_FOLDER
                fresh = _begun(run, bed_folder, home)
                solver = stack.enter_context(_started(run, fresh, home))
                _continued(solver, run, replace(fresh, legs=(0,)), home, done)
            end = _ended(solver, run, state, done, home, folder)
            state = state.ended(end, window.BALANCE_VERSION)
            state.write(folder)
            shutil.rmtree(folder / REPEAT_FOLDER, ignore_errors=True)
    return Shaken(
        cycles=done,
        legs=state.legs,
        spheres=state.spheres,
        mass_kg=state.mass,
        ended_by="accuracy" if good else "max_cycles",
        balance=end.balance,
    )


def ordinary_step(spheres: float) -> float:
    """Return the CPU time of a step of spheres by which work is divided [s]."""
    return ORDINARY_STEP[0] + ORDINARY_STEP[1] * spheres


def cycles_between_restarts(run: Run, spheres: int) -> int:
    """Return the cycles between two restarts of a run with given spheres."""
    return max(1, int(CHECKPOINT / (ordinary_step(spheres) * run.steps_per_cycle)))


def _judged(run: Run, target: RunTarget, state: RunState, folder: Path) -> tuple[int, bool]:
    """Return the cycles that a target takes, and whether its error is met in them.

    As far as rows are there: more cycles than the state has are still to be run.
    """
    smallest = rows.smallest_error(run, state.mass)
    count = target.min_cycles
    while count <= state.cycles:
        read = rows.read_rows(run, folder, state.legs, count)
        rows.check_physics(run, read, state.mass, folder)
        estimate, _ = rows.estimates(run, read, state.mass)
        allowed = max(target.relative_error * abs(estimate.mean), smallest)
        good = estimate.error <= allowed and rows.is_steady(estimate, count)
        if good or count >= target.max_cycles:
            return count, good
        count = min(target.max_cycles, math.ceil(1.5 * count))
    return count, False


def _end_at(state: RunState, done: int) -> End | None:
    """Return the end of the run after ``done`` cycles; None if missing or of another version."""
    if state.balance_version != window.BALANCE_VERSION:
        return None
    return next((end for end in state.ends if end.cycles == done), None)


def _ended(solver: Liggghts, run: Run, state: RunState, done: int, home: Path, folder: Path) -> End:
    """Write the spheres as they are and measure the energy balance, after the last cycle."""
    last = last_file(done)
    solver.dump(last, output.POSITION_AND_VELOCITY)
    balance = None
    if run.lists_contacts:
        balance = window.measure_balance(solver, run, state, home)
    solver.finish(solver.instant().step, state.spheres)
    durable.sync(home / last)
    (home / last).replace(folder / last)
    return End(done, balance)


def _resumed(run: Run, target: RunTarget, folder: Path) -> RunState | None:
    """Return the state of a folder from which the run can continue."""
    state = RunState.read(folder)
    if state is None or state.run != run.identity:
        return None
    # rows that a killed process wrote after its last restart are ignored
    for file_of in rows.files_of_rows(run):
        path = folder / file_of(len(state.legs))
        lines = rows.rows_text(path).splitlines(keepends=True)
        if len(lines) > 2 + state.legs[-1]:
            durable.write_text(path, "".join(lines[: 2 + state.legs[-1]]))
    # a deck of the user's own may hold what no restart keeps: all of it is there, or none
    if run.deck is not None and _judged(run, target, state, folder)[0] > state.cycles:
        return None
    return state


def _begun(run: Run, bed_folder: Path, folder: Path) -> RunState:
    """Return the state of a folder with the start files of a run."""
    spheres = read_bed(bed_folder)
    write_start(folder, run.packing, spheres, bed_folder)
    mass = float(geometry.masses(spheres[:, 3], run.packing.density).sum())
    return RunState(run.identity, len(spheres), mass, (), (), 0, {}).with_files(folder)


def _started(run: Run, state: RunState, folder: Path) -> Liggghts:
    """Return LIGGGHTS at the last cycle of a state, ready for a new leg."""
    check_files(folder, {name: state.files.get(name, "") for name in state.start_files})
    leg = len(state.legs) + 1
    text = run.deck_text(leg, state.restart or None)
    solver = Liggghts(folder, f"shake_{leg}")
    solver.read_deck(text)
    return solver


def _continued(solver: Liggghts, run: Run, state: RunState, folder: Path, cycles: int) -> RunState:
    """Run to a cycle and leave a restart there: the state then."""
    added = cycles - state.cycles
    longer = replace(state, legs=(*state.legs[:-1], state.legs[-1] + added))
    reached = solver.run_cycles(added, run.steps_per_cycle, longer.restart)
    last = (run.cycles_before + cycles) * run.steps_per_cycle
    if reached.step != last:
        raise RunStopped(f"{solver.log}: at step {reached.step}, not {last}")
    if reached.spheres != state.spheres:
        raise ParticlesLost(f"{solver.log}: {reached.spheres} spheres of {state.spheres}")
    row_files = (folder / file_of(len(state.legs)) for file_of in rows.files_of_rows(run))
    durable.sync(folder / longer.restart, *row_files)
    longer = longer.with_files(folder)
    longer.write(folder)
    if state.restart:
        (folder / state.restart).unlink(missing_ok=True)
    return longer
