"""Rows of a run: read from its folder, with estimates of C_e and m_a.

A run has a row a cycle, in the files of its legs. Nothing here enters a label: changed code judges
the stored rows again.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon import cycles
from pidpanel.coupon.bed import HARD, Run
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.failures import LogTruncated, Unphysical
from pidpanel.coupon.records import Shaken

# An error below this share of the inelastic bound ends a run too [1]: a bed that dissipates next
# to nothing never reaches an error relative to itself.
FLOOR = 2e-4

# Difference of the halves over its error beyond which a run is called drifting [1].
DRIFT_LIMIT = 3.0


def read_rows(
    run: Run, folder: Path, legs: Sequence[int], cycles_wanted: int, *, by_cell: bool = False
) -> Array:
    """Read and check the first rows of a run, (cycles_wanted, 7), or by cell; see `read_cycles`.

    Raises
    ------
    LogTruncated, NotFinite
        If rows are missing or not finite, with file, line and text.
    """
    file_of, header = deck.cycles_file, output.CYCLES_HEADER
    if by_cell:
        file_of, header = deck.cells_file, output.cells_header(run.cells_listed)
    rows, count = [], run.cycles_before
    for number, leg in enumerate(legs, 1):
        path, steps = folder / file_of(number), run.steps_per_cycle
        rows.append(output.read_cycles(rows_text(path), str(path), steps, leg, count, header))
        count += leg
    if sum(legs) < cycles_wanted:
        raise LogTruncated(f"{folder}: {sum(legs)} of {cycles_wanted} cycles")
    return np.concatenate(rows)[:cycles_wanted]


def read_cells(run: Run, folder: Path, shaken: Shaken) -> Array:
    """Read ⟨p sin ωt⟩ and ⟨p cos ωt⟩ of each cell of a run, (shaken.cycles, cells, 2) [kg m/s].

    Of a single cell, and where the deck does not list them, those of all cells together.
    """
    by_cell = run.cells_listed > 0
    read = read_rows(run, folder, shaken.legs, shaken.cycles, by_cell=by_cell)
    return read[:, 1 : None if by_cell else 3].reshape(shaken.cycles, -1, 2)


def read_shaken(run: Run, folder: Path, shaken: Shaken) -> Array:
    """Read the rows of a run up to its target, (shaken.cycles, 7).

    Raises
    ------
    LogTruncated, NotFinite, Unphysical
        If rows are missing, not finite or impossible, with file, line and text.
    """
    rows = read_rows(run, folder, shaken.legs, shaken.cycles)
    check_physics(run, rows, shaken.mass_kg, folder)
    check_cells(rows, read_cells(run, folder, shaken), folder)
    return rows


def files_of_rows(run: Run) -> list[Callable[[int], str]]:
    """Return the names of the files of rows of a run, by leg."""
    return [deck.cycles_file, deck.cells_file] if run.cells_listed else [deck.cycles_file]


def rows_text(path: Path) -> str:
    """Return the text of a file of cycle rows."""
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else error.strerror
        raise LogTruncated(f"{path}: {reason}") from None


def _column(rows: Array, name: str) -> Array:
    return rows[:, output.CYCLE_COLUMNS.index(name)]


# Relative tolerance of a comparison of two columns: rows are written with six digits [1].
ROUNDING = 1e-5

# Share of its height by which overlaps may shorten a bed [1]: half of it is the deepest overlap
# that softened contacts have at the speed of the drive, over the radius.
OVERLAP = 0.1


def check_physics(run: Run, rows: Array, mass: float, folder: Path) -> None:
    """Refuse rows that no motion of the spheres in their cells can have.

    The samples of a cycle have ⟨p²⟩ ≤ 2 M ⟨E_kin⟩ (Cauchy and Schwarz), and the parts of p along
    sin ωt, cos ωt and 1 are at most all of it (Bessel):

        2⟨p sin⟩² + 2⟨p cos⟩² + ⟨p⟩² ≤ 2 M ⟨E_kin⟩,  0 < ⟨E_kin⟩,  0 ≤ ⟨E_rot⟩

    The centre of mass is as far from floor and lid as half the height of the same mass without
    gaps. And a bed cannot give the shaker more than it had when the run began, at the speed ωW
    of the cells: the work up to any cycle is at least −(½ M (ωW)² + M g L), L the depth. A deck of
    the user's own may use another frame, so only the last and the signs are checked.

    Notes
    -----
    The largest ratio of the two sides was 0.9998 in 180 runs of the paper's study.
    """
    p_sin, p_cos, p_mean, kinetic, rotational, height = rows[:, 1:].T
    packing, drive = run.packing, run.drive
    harmonics = 2 * p_sin**2 + 2 * p_cos**2 + p_mean**2
    lowest = (1 - OVERLAP) * mass / packing.density / packing.area / 2
    supplied = np.cumsum(work(run, rows))
    # a bed that was shaken hard has at most twice the speed of the cells then
    speed = drive.speed * (2 * HARD if run.start == "hard" else 1)
    stored = mass * (speed**2 / 2 + run.bed.gravity * packing.depth)
    ours = run.deck is None
    for wrong, fault in (
        (kinetic <= 0, "a kinetic energy that is not positive"),
        (rotational < 0, "a negative energy of rotation"),
        (
            ours & (harmonics > 2 * mass * kinetic * (1 + ROUNDING)),
            "more momentum than its kinetic energy allows",
        ),
        (
            ours & ((height < lowest) | (height > packing.depth - lowest)),
            "a centre of mass outside the free space of the cells",
        ),
        (supplied < -stored, "more work returned by then than the bed had stored"),
    ):
        if wrong.any():
            raise Unphysical(f"{folder}: cycle {int(np.argmax(wrong)) + 1} has {fault}")


def check_cells(rows: Array, cells: Array, folder: Path) -> None:
    """Refuse rows whose momentum is not that of all cells."""
    deviation = np.abs(cells.sum(axis=1) - rows[:, 1:3]).max(axis=1)
    wrong = deviation > ROUNDING * np.abs(cells).sum(axis=(1, 2))
    if wrong.any():
        raise Unphysical(
            f"{folder}: the momentum of cycle {int(np.argmax(wrong)) + 1} is not the sum over "
            "its cells"
        )


def harmonic(run: Run, rows: Array, mass: float) -> tuple[Array, Array]:
    """Return C_e and m_a of each cycle of rows (n, 7) in SI; see `cycles.first_harmonic`."""
    return _harmonic(run, _column(rows, "p_sin"), _column(rows, "p_cos"), mass=mass)


def _harmonic(
    run: Run, p_sin: Array, p_cos: Array, *, mass: float, cells: int = 1
) -> tuple[Array, Array]:
    """Return C_e and m_a of all cells together, or of one of several equal cells."""
    drive, area = run.drive, run.packing.area / cells
    motion = {"amplitude": drive.amplitude, "frequency": drive.frequency}
    return cycles.first_harmonic(p_sin, p_cos, **motion, mass=mass / cells, area=area)


def work(run: Run, rows: Array) -> Array:
    """Return the work of the inertial force in each cycle, (n,) [J]: ω²W ⟨p sin ωt⟩/f."""
    return run.drive.acceleration * _column(rows, "p_sin") / run.drive.frequency


def stored_energy(run: Run, rows: Array, mass: float) -> Array:
    """Return the kinetic and potential energy of the bed, mean of each cycle, (n,) [J]."""
    weight = -mass * run.bed.gravity * run.bed.gravity_direction[2]
    kinetic = _column(rows, "kinetic_energy") + _column(rows, "rotational_energy")
    return kinetic + weight * _column(rows, "height")


def estimates(run: Run, rows: Array, mass: float) -> tuple[cycles.Estimate, cycles.Estimate]:
    """Return C_e [N s/m³] and, from the same rows, m_a [kg/m²] of a run."""
    damping, apparent_mass = harmonic(run, rows, mass)
    stored = stored_energy(run, rows, mass)
    estimate = cycles.estimate(damping, stored=stored)
    return estimate, cycles.estimate(apparent_mass, start=estimate.start, stored=stored)


def cell_estimates(run: Run, cells: Array, mass: float) -> Array:
    """Return C_e, its standard error [N s/m³] and m_a [kg/m²] of the cells with spheres, (3, n).

    Those of the second half of the run: a cell comes to its state of motion in up to 120 cycles,
    some by others on the way.
    """
    count = cells.shape[1]
    samples = []
    for cell in np.moveaxis(cells, 1, 0):
        if not cell.any():
            continue
        damping, apparent_mass = _harmonic(run, *cell.T, mass=mass, cells=count)
        half = len(damping) // 2
        samples.append((*cycles.settled(damping[half:]), apparent_mass[half:].mean()))
    return np.array(samples).reshape(-1, 3).T


def is_steady(estimate: cycles.Estimate, done: int) -> bool:
    """Return whether the transient ended well inside the run, without drift after it."""
    return estimate.start < 0.45 * done and abs(estimate.drift) < DRIFT_LIMIT


def smallest_error(run: Run, mass: float) -> float:
    """Return `FLOOR` times the inelastic bound of C_e [N s/m³], the least required error."""
    return FLOOR * cycles.inelastic_bound(mass / run.packing.area, run.drive.frequency)
