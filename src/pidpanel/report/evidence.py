"""What single runs of the coupon left behind: the energy of every cycle, the last state."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.coupon import coding, cycles, rows, runs
from pidpanel.coupon.cases import Case, Run
from pidpanel.coupon.liggghts import deck, output, start_files
from pidpanel.coupon.records import ShakeOutcome

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
    diameters
        (n,) m.
    speed
        (n,) relative to the cell after the last cycle, m/s.
    cycles
        Run before the picture.
    """

    run: Run
    label: str
    positions: Array
    diameters: Array
    speed: Array
    cycles: int


@dataclass(frozen=True)
class Record:
    """The cycles of one run.

    Attributes
    ----------
    title
        Title of the figure: the case.
    seed
        Seed of the packing.
    energy
        Dissipated energy of each cycle [J/m²], shape ``(n_cycles,)``.
    start
        First cycle (from 0) after the transient.
    mean, error
        Mean and standard error of the cycles from there on [J/m²].
    """

    title: str
    seed: int
    energy: Array
    start: int
    mean: float
    error: float


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


def _title(case: Case, with_size: bool) -> str:
    """A case as the title of its figure; what the study varies stands on a second line."""
    point = case.point
    title = (
        f"r = {point.fill_fraction:g}, {point.drive.frequency:g} Hz, Γ = {point.drive.gamma:.4g}"
    )
    more = [f"d = {1e3 * point.packing.diameter:g} mm"] if with_size else []
    for key, value in case.varied.items():
        shown = f"{value:g}" if isinstance(value, int | float) else value
        more.append(f"{key.rpartition('.')[2].replace('_', ' ')} {shown}")
    return "\n".join([title, ", ".join(more)]) if more else title


def read_records(case: Case, folder: Path, *, with_size: bool = False) -> list[Record]:
    """Energy per cycle of each seed of a case that stands.

    Parameters
    ----------
    case
        The case.
    folder
        ``results/coupon``.
    with_size
        Whether the diameter of the spheres tells cases of the study apart.
    """
    records = []
    for run, path in zip(case.runs, case.outcomes(folder), strict=True):
        outcome = coding.read(ShakeOutcome, path).found
        if outcome is None:
            continue
        read = rows.read_rows(run, path.parent, outcome.legs, outcome.cycles)
        damping, _ = rows.harmonic(run, read, outcome.mass_kg)
        found, _ = rows.estimates(run, read, outcome.mass_kg)
        mean, error, energy = (
            cycles.dissipated_energy(value, run.drive.amplitude, run.drive.frequency)
            for value in (found.mean, found.error, damping)
        )
        records.append(
            Record(
                _title(case, with_size),
                run.packing.seed,
                np.asarray(energy),
                found.start,
                float(mean),
                float(error),
            )
        )
    return records


def read_beads(case: Case, folder: Path) -> Beads:
    """The spheres of the first seed of a case as they were at its end.

    Parameters
    ----------
    case, folder
        As in `read_records`.
    """
    run, path = case.point, case.outcomes(folder)[0]
    found = coding.read(ShakeOutcome, path).shaken
    last = path.parent / runs.LAST_FILE
    state = output.read_dump(last.read_text(), str(last), output.POSITION_AND_VELOCITY)[-1]
    diameters = start_files.read_diameters((path.parent / deck.START_FILE).read_text())
    speed = np.linalg.norm(state[:, 3:], axis=1)
    return Beads(run, case.label, state[:, :3], diameters, speed, found.cycles)
