"""What single runs of the coupon left behind: the energy of every cycle, the last state."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pidpanel.coupon import bed, cycles, log, runs
from pidpanel.coupon.cases import Case, Run, cell_outline
from pidpanel.report.figures import Record

Array = NDArray[np.float64]

PICTURED = (0.5, 158.0, 10.0)
"""Fill fraction, frequency (Hz) and Γ of the case that is pictured, or the nearest to them."""


@dataclass(frozen=True)
class Beads:
    """The spheres of one run.

    Attributes
    ----------
    run
        What was run.
    label
        Of the case.
    positions
        (n, 3) centres, m.
    speed
        (n,) relative to the cell after the last cycle, m/s; None where only the start is
        kept, with ``positions`` those of the start.
    cycles
        Run before the picture.
    """

    run: Run
    label: str
    positions: Array
    speed: Array | None
    cycles: int


def nearest_case(cases: pd.DataFrame) -> str:
    """Label of the case that stands nearest to `PICTURED`, in r and octaves of f and Γ.

    Parameters
    ----------
    cases
        ``coupon/cases.csv`` with at least one row "ok".
    """
    good = cases[cases["status"] == "ok"]
    fill, frequency, level = PICTURED
    away = (
        5 * (good["fill_fraction"] - fill).abs()
        + np.log2(good["frequency_hz"] / frequency).abs()
        + np.log2(good["acceleration_g"] / level).abs()
    )
    return str(good.loc[away.idxmin(), "case"])


def spread_cases(cases: pd.DataFrame, count: int) -> list[str]:
    """Labels of so many cases that stand, evenly spread over the table."""
    good = cases.loc[cases["status"] == "ok", "case"].tolist()
    index = np.unique(np.linspace(0, len(good) - 1, min(count, len(good))).round().astype(int))
    return [good[i] for i in index]


def read_records(case: Case, folder: Path) -> list[Record]:
    """Energy per cycle of each seed of a case that stands.

    Parameters
    ----------
    case
        The case.
    folder
        Its folder, with ``s<seed>/run.json`` and ``cycles.txt``.
    """
    point = case.point
    records = []
    for run in case.runs:
        own = folder / f"s{run.packing.seed}"
        outcome = json.loads((own / "run.json").read_text())
        if outcome["status"] != "ok":
            continue
        rows = runs.read_run(run, own, outcome["cycles"])
        packing = run.packing
        damping, _ = cycles.first_harmonic(
            rows[:, log.CYCLE_COLUMNS.index("p_sin")],
            rows[:, log.CYCLE_COLUMNS.index("p_cos")],
            amplitude=run.amplitude,
            frequency=run.frequency,
            mass=outcome["spheres"] * packing.density * np.pi / 6 * packing.diameter**3,
            area=packing.count * bed.polygon_area(cell_outline(packing)),
        )
        found = cycles.estimate(damping)
        mean, error, energy = (
            cycles.dissipated_energy(value, run.amplitude, run.frequency)
            for value in (found.mean, found.error, damping)
        )
        records.append(
            Record(
                f"r = {point.fill_fraction:g}, {point.frequency:g} Hz, "
                f"Γ = {point.acceleration / runs.STANDARD_GRAVITY:.4g}",
                packing.seed,
                np.asarray(energy),
                found.start,
                float(mean),
                float(error),
            )
        )
    return records


def read_beads(case: Case, folder: Path) -> Beads:
    """The spheres of the first seed of a case: their last state, or the start if it is not kept.

    Parameters
    ----------
    case, folder
        As in `read_records`.
    """
    run = case.point
    own = folder / f"s{run.packing.seed}"
    outcome = json.loads((own / "run.json").read_text())
    last = own / "last.dump"
    if last.exists():
        state = log.read_dump(last.read_text(), str(last), runs.LAST_COLUMNS)[-1]
        speed = np.linalg.norm(state[:, 3:], axis=1)
        return Beads(run, case.label, state[:, :3], speed, outcome["cycles"])
    # made before runs kept their last state; the caption of the picture says so
    positions = start_positions((own / "start.data").read_text())
    return Beads(run, case.label, positions, None, 0)


def start_positions(text: str) -> Array:
    """Centres of the spheres of a LIGGGHTS data file, (n, 3) m.

    Examples
    --------
    >>> start_positions("spheres\\n\\n1 atoms\\n\\nAtoms\\n\\n1 1 0.002 1190 0.1 0.2 0.3\\n")
    array([[0.1, 0.2, 0.3]])
    """
    body = text.partition("\nAtoms\n")[2]
    return np.array([[float(v) for v in line.split()[4:7]] for line in body.splitlines() if line])
