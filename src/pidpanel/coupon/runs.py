"""Shake a run until it is as certain as asked: what happens in ``results/coupon/<case>/s<seed>``.

The folder holds the run as far as it has ever gone: the rows of its cycles, a restart at the last
of them, and ``state.json``, which says what of the files counts. A target that asks for more
continues from there; one that asks for less reads the rows it would have run itself, so a study
gives the same numbers whatever ran before.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace
from pathlib import Path

from pidpanel.coupon import geometry, rows, window
from pidpanel.coupon.cases import Run, Target
from pidpanel.coupon.liggghts import deck, sphere_dump
from pidpanel.coupon.liggghts.failures import FileDamaged, ParticlesLost, RunStopped
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.preparation import read_bed, write_start
from pidpanel.coupon.records import Shaken, State, check_files, files_of

LAST_FILE = "last.dump"
"""Spheres at the end of a run, with the columns `sphere_dump.POSITION_AND_VELOCITY`."""


def shake(run: Run, target: Target, bed_folder: Path, folder: Path) -> Shaken:
    """Shake one run until its error target or its last cycle: files in ``folder``.

    ``shake_<leg>.in`` runs again under ``liggghts -in``; ``cycles_<leg>.txt`` are the rows,
    ``shake_<leg>.log`` the log, ``last.dump`` the spheres at the end.

    Raises
    ------
    SolverFailure
        Named after what went wrong.
    """
    state = _resumed(run, target, bed_folder, folder) or _begun(run, bed_folder, folder)
    solver: Liggghts | None = None
    with contextlib.ExitStack() as stack:
        while True:
            done, good = _judged(run, target, state, folder)
            if done <= state.cycles:
                break
            if solver is None:
                solver = stack.enter_context(_started(run, state, folder))
                state = replace(state, legs=(*state.legs, 0))
            state = _continued(solver, run, state, folder, done)
        if not _is_balanced(run, state) and solver is None:
            solver = stack.enter_context(_started(run, state, folder))
        if solver is not None:
            solver.dump(LAST_FILE, sphere_dump.POSITION_AND_VELOCITY)
            if not _is_balanced(run, state):
                least = rows.smallest_error(run, state.mass)
                balance = window.measure_balance(solver, run, state.spheres, least, folder)
                state = replace(state, balance=balance, balance_code=window.code())
                state.write(folder)
            solver.finish(solver.now().step, state.spheres)
    return Shaken(
        cycles=done,
        legs=state.legs,
        spheres=state.spheres,
        mass_kg=state.mass,
        ended_by="accuracy" if good else "max_cycles",
        balance=state.balance,
        rows_digest=rows.digest(run, folder, state.legs, done),
    )


def _judged(run: Run, target: Target, state: State, folder: Path) -> tuple[int, bool]:
    """Cycles that a target takes, and whether its error is met in them.

    As far as rows are there: more cycles than the state has are still to be run.
    """
    least = rows.smallest_error(run, state.mass)
    wanted = target.min_cycles
    while wanted <= state.cycles:
        read = rows.read_rows(run, folder, state.legs, wanted)
        rows.check_physics(run, read, state.mass, folder)
        found, _ = rows.estimates(run, read, state.mass)
        allowed = max(target.relative_error * abs(found.mean), least)
        good = found.error <= allowed and rows.is_steady(found, wanted)
        if good or wanted >= target.max_cycles:
            return wanted, good
        wanted = min(target.max_cycles, math.ceil(1.5 * wanted))
    return wanted, False


def _is_balanced(run: Run, state: State) -> bool:
    """Whether no energy balance is to be measured."""
    return state.balance_code == window.code() or not run.lists_contacts


def _resumed(run: Run, target: Target, bed_folder: Path, folder: Path) -> State | None:
    """The state of a folder from which the run can continue.

    Raises
    ------
    FileDamaged, RecordUnreadable, LogTruncated
        If its rows or its state are not those that were written; the run is begun anew then.
    """
    state = State.read(folder)
    if state is None or state.run != run.identity:
        return None
    # rows that a killed process wrote after its last restart do not count
    for file_of in rows.files_of_rows(run):
        path = folder / file_of(len(state.legs))
        lines = rows.rows_text(path).splitlines(keepends=True)
        if len(lines) > 2 + state.legs[-1]:
            path.write_text("".join(lines[: 2 + state.legs[-1]]))
    if rows.digest(run, folder, state.legs, state.cycles) != state.rows_digest:
        raise FileDamaged(f"{folder}: the rows of its cycles are not those that were written")
    _restore_start(run, state, bed_folder, folder)
    # a deck of the user's own may hold what no restart keeps: all of it is there, or none
    if run.deck is not None:
        complete = _judged(run, target, state, folder)[0] <= state.cycles
        return state if complete and _is_balanced(run, state) else None
    return state


def _restore_start(run: Run, state: State, bed_folder: Path, folder: Path) -> None:
    """Write the spheres and the walls of the start again where they are not what they were."""
    start = {name: state.files[name] for name in (deck.START_FILE, deck.WALLS_FILE)}
    if files_of(folder, start) != start:
        again = folder / "again"
        write_start(again, run.packing, read_bed(bed_folder), bed_folder)
        for name in start:
            (again / name).replace(folder / name)
        again.rmdir()
        check_files(folder, start)


def _begun(run: Run, bed_folder: Path, folder: Path) -> State:
    """The state of a folder with what a run starts from."""
    spheres = read_bed(bed_folder)
    write_start(folder, run.packing, spheres, bed_folder)
    mass = float(geometry.masses(spheres[:, 3], run.packing.density).sum())
    files = files_of(folder, (deck.START_FILE, deck.WALLS_FILE))
    return State(run.identity, len(spheres), mass, files=files)


def _started(run: Run, state: State, folder: Path) -> Liggghts:
    """LIGGGHTS at the last cycle of a state, about to begin a new leg."""
    check_files(folder, state.files)
    leg = len(state.legs) + 1
    text = run.deck_text(leg, state.restart or None)
    solver = Liggghts(folder, f"shake_{leg}")
    solver.read_deck(text)
    return solver


def _continued(solver: Liggghts, run: Run, state: State, folder: Path, wanted: int) -> State:
    """Run to a cycle and leave a restart there: the state then."""
    restart = f"at_{wanted}.restart"
    more = wanted - state.cycles
    reached = solver.run_and_save(more * run.steps_per_cycle, restart)
    last = (run.cycles_before + wanted) * run.steps_per_cycle
    if reached.step != last:
        raise RunStopped(f"{solver.log}: at step {reached.step}, not {last}")
    if reached.spheres != state.spheres:
        raise ParticlesLost(f"{solver.log}: {reached.spheres} spheres of {state.spheres}")
    after = state.after(more, restart)
    after = replace(
        after,
        rows_digest=rows.digest(run, folder, after.legs, after.cycles),
        files=files_of(folder, (deck.START_FILE, deck.WALLS_FILE, restart)),
    )
    after.write(folder)
    if state.restart:
        (folder / state.restart).unlink(missing_ok=True)
    return after
