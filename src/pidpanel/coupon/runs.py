"""Shake a run until it is as certain as asked: what happens in ``results/coupon/<case>/s<seed>``.

The folder holds the run as far as it has ever gone: the rows of its cycles, a restart at the
last of them, and ``state.json``, which says what of the files counts. A target that asks for
more goes on from there; one that asks for less reads the rows it would have run itself, so a
study gives the same numbers whatever ran before.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import resource
import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon import cycles, geometry
from pidpanel.coupon.cases import Bed, Packing, Run, Target
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.process import VERSION, Liggghts
from pidpanel.coupon.preparation import loosen, pour, read_bed, shake_values, write_start
from pidpanel.coupon.window import measure_balance

FLOOR = 2e-4
"""An error below this share of the inelastic bound ends a run too: a bed that dissipates next
to nothing never reaches an error relative to itself."""

DRIFT_LIMIT = 3.0
"""Difference of the halves over its error beyond which a run is called drifting."""

APART = 0.25
"""Share of their mean by which two seeds differ that are in different states of motion; packings
of few spheres alone differ by a tenth (11 of about 85 cases of the paper's study by four standard
errors or more; ten of them by 2 to 12 % of their mean, one by 44 %)."""

LAST_COLUMNS = ("x", "y", "z", "vx", "vy", "vz")
"""Of each sphere at the end of a run, in ``last.dump`` (m, m/s)."""


@dataclass
class State:
    """What of a run's folder counts; the content of ``state.json``."""

    run: dict[str, Any]
    """`Run.identity`: another run's files are not gone on from."""
    spheres: int
    mass: float
    """Of all spheres, kg."""
    legs: list[int] = field(default_factory=list)
    """Cycles of each LIGGGHTS process, in ``cycles_1.txt``, ``cycles_2.txt``, …"""
    restart: str = ""
    balance: dict[str, float] | None = None

    @property
    def cycles(self) -> int:
        return sum(self.legs)

    def write(self, folder: Path) -> None:
        """As JSON, at one stroke."""
        draft = folder / "state.json.new"
        draft.write_text(json.dumps(vars(self), indent=1) + "\n")
        os.replace(draft, folder / "state.json")


def is_steady(found: cycles.Estimate, done: int) -> bool:
    """Whether the transient ended well inside the run and nothing drifts after it."""
    return found.start < 0.45 * done and abs(found.drift) < DRIFT_LIMIT


def read_run(run: Run, folder: Path, legs: list[int], cycles_wanted: int) -> Array:
    """First rows of a run's cycles, checked; see `output.read_cycles`."""
    rows, before = [], 0
    for number, leg in enumerate(legs, 1):
        path = folder / f"cycles_{number}.txt"
        rows.append(
            output.read_cycles(
                path.read_text(),
                str(path),
                steps_per_cycle=run.steps_per_cycle,
                cycles=leg,
                before=before,
            )
        )
        before += leg
    if before < cycles_wanted:
        raise output.LogTruncated(f"{folder}: {before} of {cycles_wanted} cycles")
    return np.concatenate(rows)[:cycles_wanted]


def harmonic(run: Run, rows: Array, mass: float) -> tuple[Array, Array]:
    """C_e and m_a of each cycle of a run whose spheres weigh ``mass`` kg together."""
    return cycles.first_harmonic(
        rows[:, output.CYCLE_COLUMNS.index("p_sin")],
        rows[:, output.CYCLE_COLUMNS.index("p_cos")],
        amplitude=run.amplitude,
        frequency=run.frequency,
        mass=mass,
        area=run.packing.area,
    )


def stored_energy(run: Run, rows: Array, mass: float) -> Array:
    """Kinetic energy and energy of height of the bed, mean of each cycle, J, (n,)."""
    kinetic, rotational, height = (
        rows[:, output.CYCLE_COLUMNS.index(name)]
        for name in ("kinetic_energy", "rotational_energy", "height")
    )
    weight = -mass * run.bed.gravity * run.bed.gravity_direction[2]
    return kinetic + rotational + weight * height


def estimates(run: Run, rows: Array, mass: float) -> tuple[cycles.Estimate, cycles.Estimate]:
    """C_e and, from the same rows, m_a of a run."""
    damping, apparent_mass = harmonic(run, rows, mass)
    stored = stored_energy(run, rows, mass)
    found = cycles.estimate(damping, stored=stored)
    return found, cycles.estimate(apparent_mass, start=found.start, stored=stored)


def _bound(run: Run, mass: float) -> float:
    """Inelastic bound of C_e, N s/m³."""
    return cycles.inelastic_bound(mass / run.packing.area, run.frequency)


def _resumed(run: Run, folder: Path) -> State | None:
    """The state of a folder that can be gone on from."""
    try:
        state = State(**json.loads((folder / "state.json").read_text()))
    except (OSError, ValueError, TypeError):
        return None
    if state.run != json.loads(json.dumps(run.identity)):
        return None
    # rows that a killed process wrote after its last restart do not count
    path = folder / f"cycles_{len(state.legs)}.txt"
    lines = path.read_text().splitlines(keepends=True)
    if len(lines) > 2 + state.legs[-1]:
        path.write_text("".join(lines[: 2 + state.legs[-1]]))
    return state


def _begun(run: Run, bed_folder: Path, folder: Path) -> State:
    spheres = read_bed(bed_folder / "bed.csv")
    write_start(folder, run.packing, spheres, bed_folder / "walls.stl")
    mass = float(geometry.masses(spheres[:, 3], run.packing.density).sum())
    return State(run.identity, len(spheres), mass)


def shake(run: Run, target: Target, bed_folder: Path, folder: Path) -> dict[str, Any]:
    """Shake one run until its error target or its last cycle: files in ``folder``.

    ``shake_<leg>.in`` runs again under ``liggghts -in``; ``cycles_<leg>.txt`` are the rows,
    ``shake_<leg>.log`` the log, ``last.dump`` the spheres at the end.

    Returns
    -------
    dict
        ``cycles`` that the target took, ``legs``, ``spheres``, ``mass_kg``, ``ended_by``
        ("accuracy" or "max_cycles") and the energy ``balance``.

    Raises
    ------
    SolverFailure
        Named after what went wrong.
    """
    # a deck of the user's own may hold what no restart keeps, so it begins anew
    state = (_resumed(run, folder) if run.deck is None else None) or _begun(run, bed_folder, folder)
    wanted = target.min_cycles
    solver: Liggghts | None = None
    with contextlib.ExitStack() as stack:
        while True:
            if wanted > state.cycles:
                solver = solver or stack.enter_context(_started(run, state, folder))
                _go_on(solver, run, state, folder, wanted)
            done = wanted
            found, _ = estimates(run, read_run(run, folder, state.legs, done), state.mass)
            allowed = max(target.relative_error * abs(found.mean), FLOOR * _bound(run, state.mass))
            good = found.error <= allowed and is_steady(found, done)
            if good or done >= target.max_cycles:
                break
            wanted = min(target.max_cycles, math.ceil(1.5 * done))
        unbalanced = state.balance is None and lists_contacts(run)
        if unbalanced and solver is None:
            solver = stack.enter_context(_started(run, state, folder))
        if solver is not None:
            solver.execute(
                f"dump last all custom 1 last.dump id {' '.join(LAST_COLUMNS)}\nrun 0\nundump last"
            )
            if unbalanced:
                floor = FLOOR * _bound(run, state.mass)
                state.balance = measure_balance(solver, run, state.spheres, floor, folder)
                # a leg that ran no cycle of its own leaves none behind
                state.legs = [leg for leg in state.legs if leg]
                state.write(folder)
            last, _, _ = solver.execute("")
            solver.finish()
            output.check_log(
                solver.log.read_text(errors="replace"),
                str(solver.log),
                last_step=last,
                atoms=state.spheres,
            )
    return {
        "cycles": done,
        "legs": state.legs,
        "spheres": state.spheres,
        "mass_kg": state.mass,
        "ended_by": "accuracy" if good else "max_cycles",
        "balance": state.balance,
    }


def lists_contacts(run: Run) -> bool:
    """Whether the deck of a run can list its contacts, without which there is no balance."""
    return run.deck is None or "compute touches" in Path(run.deck).read_text(encoding="utf-8")


def _started(run: Run, state: State, folder: Path) -> Liggghts:
    """LIGGGHTS at the last cycle of a state, with a new leg of no cycles."""
    leg = len(state.legs) + 1
    values = shake_values(run, leg, state.restart or None)
    if run.deck is None:
        text = deck.render("shake.in.j2", values)
    else:
        own = Path(run.deck)
        text = deck.render(own.name, values, own.parent)
    solver = Liggghts(folder, f"shake_{leg}")
    solver.execute(text)
    state.legs.append(0)
    return solver


def _go_on(solver: Liggghts, run: Run, state: State, folder: Path, wanted: int) -> None:
    """Run to a cycle and leave a restart there."""
    restart = f"at_{wanted}.restart"
    more = (wanted - state.cycles) * run.steps_per_cycle
    step, atoms, _ = solver.execute(f"run {more}\nwrite_restart {restart}")
    if step != wanted * run.steps_per_cycle:
        raise output.RunStopped(f"{solver.log}: at step {step}, not {wanted * run.steps_per_cycle}")
    if atoms != state.spheres:
        raise output.ParticlesLost(f"{solver.log}: {atoms} spheres of {state.spheres}")
    before = state.restart
    state.legs[-1] += wanted - state.cycles
    state.restart = restart
    state.write(folder)
    if before:
        (folder / before).unlink()


# ------------------------------------------------------------------ what a job leaves behind


def _attempt(action: Callable[[], dict[str, Any]], folder: Path) -> dict[str, Any]:
    """Do it, twice if need be; a failure is kept by its name.

    The first failure may be the machine's; the second is reported, so that a sweep goes on
    and its coverage decides. A stopped run goes on from its last restart; what any other
    failure left is removed.
    """
    attempts = 0
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    while True:
        attempts += 1
        try:
            outcome = {"status": "ok", "message": "", **action()}
        except output.SolverMissing:
            raise
        except output.SolverFailure as failure:
            outcome = {"status": type(failure).__name__, "message": str(failure)}
        if outcome["status"] == "ok" or attempts == 2:
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            return {
                **outcome,
                "attempts": attempts,
                "liggghts": VERSION,
                "solver_cpu_s": round(spent, 2),
            }
        if outcome["status"] != output.RunStopped.__name__:
            shutil.rmtree(folder, ignore_errors=True)


def attempt_pour(packing: Packing, folder: Path) -> dict[str, Any]:
    """Content of ``packing.json``: `pour`, or the name of its failure."""
    return {**_attempt(lambda: pour(packing, folder), folder), "packing": packing.as_dict()}


def attempt_loosen(start: Bed, packing: Path, folder: Path) -> dict[str, Any]:
    """Content of ``bed.json``: `loosen`, or the name of its failure or of its packing's."""
    before = json.loads(packing.read_text())
    outcome = _failed(before) or _attempt(
        lambda: loosen(start, packing.parent, folder, before["spheres_full"]), folder
    )
    return {**outcome, "bed": start.as_dict()}


def attempt_shake(run: Run, target: Target, start: Path, folder: Path) -> dict[str, Any]:
    """Content of ``<target>.json``: `shake`, or the name of its failure or of its bed's."""
    before = json.loads(start.read_text())
    outcome = _failed(before) or _attempt(lambda: shake(run, target, start.parent, folder), folder)
    return {**outcome, "run": run.as_dict(), "target": asdict(target)}


def attempt_case(
    case_runs: Sequence[Run], target: Target, beds: Sequence[Path], folders: Sequence[Path]
) -> list[dict[str, Any]]:
    """What `attempt_shake` says of each seed of a case; seeds that are apart go on.

    A bed can dwell in a state of motion that does not last, and look steady (100 Hz, 80 g,
    μ = 0.1: C_e = 1250 N s/m³ for 60 or 90 cycles, 190 ever after). Where two seeds differ by
    more than `APART` and four standard errors, the shorter goes on by half, until they agree or
    have run ``max_cycles``.
    """
    outcomes = [
        attempt_shake(run, target, bed_file, folder)
        for run, bed_file, folder in zip(case_runs, beds, folders, strict=True)
    ]
    while all(outcome["status"] == "ok" for outcome in outcomes):
        found = []
        for run, folder, outcome in zip(case_runs, folders, outcomes, strict=True):
            rows = read_run(run, folder, outcome["legs"], outcome["cycles"])
            found.append(estimates(run, rows, outcome["mass_kg"])[0])
        k = min(range(len(outcomes)), key=lambda i: outcomes[i]["cycles"])
        done = outcomes[k]["cycles"]
        if not _apart(found) or done >= target.max_cycles:
            break
        longer = replace(target, min_cycles=min(target.max_cycles, math.ceil(1.5 * done)))
        more = attempt_shake(case_runs[k], longer, beds[k], folders[k])
        spent = outcomes[k]["solver_cpu_s"] + more["solver_cpu_s"]
        outcomes[k] = {**more, "target": asdict(target), "solver_cpu_s": round(spent, 2)}
    return outcomes


def _apart(found: Sequence[cycles.Estimate]) -> bool:
    """Whether the highest and the lowest are further apart than their errors explain."""
    low, high = min(found, key=lambda one: one.mean), max(found, key=lambda one: one.mean)
    difference = high.mean - low.mean
    far = difference > APART * abs(high.mean + low.mean) / 2
    return far and difference > 4 * math.hypot(high.error, low.error)


def _failed(before: dict[str, Any]) -> dict[str, Any] | None:
    """The outcome that is handed on when an earlier step failed."""
    if before["status"] == "ok":
        return None
    keys = ("status", "message", "attempts", "liggghts")
    return {**{key: before[key] for key in keys}, "solver_cpu_s": 0.0}
