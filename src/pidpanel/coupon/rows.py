"""Rows of a run: read from its folder, and what they say of C_e and m_a.

A run has a row a cycle, in the files of its legs. Nothing here enters a label: changed code judges
the rows that are there anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon import cycles
from pidpanel.coupon.cases import Run
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.failures import LogTruncated

FLOOR = 2e-4
"""An error below this share of the inelastic bound ends a run too [1]: a bed that dissipates next
to nothing never reaches an error relative to itself."""

DRIFT_LIMIT = 3.0
"""Difference of the halves over its error beyond which a run is called drifting [1]."""


def read_rows(run: Run, folder: Path, legs: Sequence[int], cycles_wanted: int) -> Array:
    """First rows of a run, checked, (cycles_wanted, 7); see `output.read_cycles`.

    Parameters
    ----------
    run, folder
        The run and its folder.
    legs
        Cycles of each LIGGGHTS process.
    cycles_wanted
        Rows to return.

    Raises
    ------
    LogTruncated, NotFinite
        With the file, the line and the offending text.
    """
    rows, before = [], 0
    for number, leg in enumerate(legs, 1):
        path = folder / deck.cycles_file(number)
        rows.append(
            output.read_cycles(
                rows_text(path),
                str(path),
                steps_per_cycle=run.steps_per_cycle,
                cycles=leg,
                before=before,
            )
        )
        before += leg
    if before < cycles_wanted:
        raise LogTruncated(f"{folder}: {before} of {cycles_wanted} cycles")
    return np.concatenate(rows)[:cycles_wanted]


def rows_text(path: Path) -> str:
    """Text of a file of cycle rows.

    Raises
    ------
    LogTruncated
        If it is not there.
    """
    try:
        return path.read_text()
    except FileNotFoundError:
        raise LogTruncated(f"{path}: no such file") from None


def _column(rows: Array, name: str) -> Array:
    return rows[:, output.CYCLE_COLUMNS.index(name)]


def harmonic(run: Run, rows: Array, mass: float) -> tuple[Array, Array]:
    """C_e [N s/m³] and m_a [kg/m²] of each cycle, (n,); see `cycles.first_harmonic`.

    Parameters
    ----------
    run, rows
        The run and its rows, (n, 7).
    mass
        Of all spheres [kg].
    """
    return cycles.first_harmonic(
        _column(rows, "p_sin"),
        _column(rows, "p_cos"),
        amplitude=run.drive.amplitude,
        frequency=run.drive.frequency,
        mass=mass,
        area=run.packing.area,
    )


def stored_energy(run: Run, rows: Array, mass: float) -> Array:
    """Kinetic and potential energy of the bed, mean of each cycle, (n,) [J]."""
    weight = -mass * run.bed.gravity * run.bed.gravity_direction[2]
    kinetic = _column(rows, "kinetic_energy") + _column(rows, "rotational_energy")
    return kinetic + weight * _column(rows, "height")


def estimates(run: Run, rows: Array, mass: float) -> tuple[cycles.Estimate, cycles.Estimate]:
    """C_e [N s/m³] and, from the same rows, m_a [kg/m²] of a run."""
    damping, apparent_mass = harmonic(run, rows, mass)
    stored = stored_energy(run, rows, mass)
    found = cycles.estimate(damping, stored=stored)
    return found, cycles.estimate(apparent_mass, start=found.start, stored=stored)


def is_steady(found: cycles.Estimate, done: int) -> bool:
    """Whether the transient ended well inside the run and nothing drifts after it."""
    return found.start < 0.45 * done and abs(found.drift) < DRIFT_LIMIT


def smallest_error(run: Run, mass: float) -> float:
    """`FLOOR` of the inelastic bound of C_e [N s/m³]: less is never asked of an error."""
    return FLOOR * cycles.inelastic_bound(mass / run.packing.area, run.drive.frequency)
