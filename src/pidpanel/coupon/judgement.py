"""Estimates and checks of the seeds of a case.

No label depends on this module: a change rebuilds the table from stored rows without new runs.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pidpanel.coupon import coding, cycles, rows
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.liggghts.failures import EnergyNotClosed, LossesApart, NotSteady, SolverFailure
from pidpanel.coupon.records import Shaken, ShakeOutcome
from pidpanel.coupon.window import CLOSURE_LIMIT


@dataclass(frozen=True)
class SeedEstimate:
    """Estimates from one seed of a case."""

    damping: cycles.Estimate  # C_e [N s/m³]
    apparent_mass: cycles.Estimate  # m_a [kg/m²]
    cells: list[rows.CellEstimate]  # of each cell that holds particles, or of all together
    # Least and largest work of the shaker in a cycle of the second half [J].
    work: tuple[float, float]
    shaken: Shaken


def read_run(run: Run, file: Path) -> SeedEstimate:
    """Return the estimates of one run from the outcome in its folder."""
    outcome = coding.read(ShakeOutcome, file)
    outcome.check_run(run, file)
    shaken = outcome.shaken
    read = rows.read_shaken(run, file.parent, shaken)
    cells = rows.cell_estimates(run, rows.read_cells(run, file.parent, shaken), shaken.mass_kg)
    work = rows.work(run, read)[len(read) // 2 :]
    damping, apparent_mass = rows.estimates(run, read, shaken.mass_kg)
    ends = float(work.min()), float(work.max())
    return SeedEstimate(damping, apparent_mass, cells, ends, shaken)


# Largest ratio of the loss of the contacts in the window of the energy balance, often one cycle, to
# the mean of the rows [1]. In 180 runs of the paper's study it was 0.145 to 2.28. A cell that lands
# every third cycle loses almost nothing in the two between (0.01 was seen): the lower limit is 0.
LOSSES_APART = 30.0

# Largest distance of the work of the window from that of the rows, over their range and size [1]: a
# bed may change its motion, but not by an order of magnitude.
WORK_APART = 3.0


def problems_of(run: Run, read: SeedEstimate, folder: Path) -> Iterator[SolverFailure]:
    """Yield the problems of a finished run."""
    damping, done = read.damping, read.shaken.cycles
    if not rows.is_steady(damping, done):
        yield NotSteady(
            f"{folder}: transient to cycle {damping.start} of {done}, "
            f"drift of {damping.drift:.2g} standard errors after it"
        )
    balance = read.shaken.balance
    if balance is not None and not abs(balance.closure) <= CLOSURE_LIMIT:  # nor if it is NaN
        yield EnergyNotClosed(
            f"{folder}: {balance.closure:+.2%} of the work is missing in the energy balance"
        )
    if balance is not None and damping.mean > 4 * damping.error:
        drive = run.drive
        energy = cycles.dissipated_energy(damping.mean, drive.amplitude, drive.frequency)
        ratio = balance.energies.dissipated / balance.cycles / (energy * run.packing.area)
        if not -CLOSURE_LIMIT < ratio < LOSSES_APART:
            yield LossesApart(
                f"{folder}: contacts dissipate {ratio:.3g} times the energy in the rows; "
                f"allowed is 0 to {LOSSES_APART:g}"
            )
        work = balance.energies.work / balance.cycles
        low, high = read.work
        margin = WORK_APART * (high - low + abs(high))
        if not low - margin <= work <= high + margin:
            yield LossesApart(
                f"{folder}: work of {work:.3g} J per cycle in the energy balance, "
                f"{low:.3g} to {high:.3g} J in the rows"
            )


def judged_by(case: Case, outcomes: Sequence[Path]) -> list[tuple[Run, Path]]:
    """Return the runs used for a case, and their outcomes: with its reserve if that was run."""
    for path in outcomes:
        with suppress(SolverFailure):
            if coding.read(ShakeOutcome, path).seeds > len(case.runs):
                homes = [path.parents[1] / f"s{run.packing.seed}" for run in case.reserve]
                outcomes = [*outcomes, *(home / path.name for home in homes)]
                return list(zip(case.with_reserve.runs, outcomes, strict=True))
    return list(zip(case.runs, outcomes, strict=True))


def error_of(read: SeedEstimate) -> float:
    """Return the standard error of C_e of one seed [N s/m³], with its drift if it is not steady.

    The halves of the run differ by `drift` times the error of their difference, twice that of the
    mean. The mean may be wrong by half of that.
    """
    damping = read.damping
    if rows.is_steady(damping, read.shaken.cycles):
        return damping.error
    return damping.error * max(1.0, abs(damping.drift))
