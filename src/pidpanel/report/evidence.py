"""What single runs of the coupon left: the energy of every cycle, a film."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.coupon import coding, cycles, rows
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.film import Film
from pidpanel.coupon.records import ShakeOutcome
from pidpanel.report.layout import pick

PICTURED = (0.5, 158.0, 10.0)
"""Fill fraction, frequency [Hz] and Γ of the case in the film, or of the nearest to it."""


@dataclass(frozen=True)
class Shot:
    """A run watched for some cycles."""

    run: Run
    film: Film


@dataclass(frozen=True)
class RunRecord:
    """The cycles of one run."""

    title: str
    seed: int  # of the packing
    energy: Array  # (n_cycles,) dissipated [J/m²]
    start: int  # first cycle after the transient, from 0
    mean: float  # of the cycles from there on [J/m²]
    error: float  # standard error of the mean [J/m²]


def nearest_case(cases: pd.DataFrame) -> str:
    """Return the label of the case nearest to `PICTURED`, in r and octaves of f and Γ."""
    good = cases[cases["status"] == "ok"]
    fill, frequency, gamma = PICTURED
    away = (
        5 * (good["fill_fraction"] - fill).abs()
        + np.log2(good["frequency_hz"] / frequency).abs()
        + np.log2(good["acceleration_g"] / gamma).abs()
    )
    return str(good.loc[away.idxmin(), "case"])


def spread_cases(cases: pd.DataFrame, count: int) -> list[str]:
    """Return labels of ``count`` cases of status ok, evenly spread over the table."""
    good = cases.loc[cases["status"] == "ok", "case"].tolist()
    return [good[int(i)] for i in pick(np.arange(len(good), dtype=float), count)]


def _title(case: Case, with_size: bool) -> str:
    """Return the title of a case's figure; what the study varies is on a second line."""
    point = case.point
    title = (
        f"r = {point.fill_fraction:g}, {point.drive.frequency:g} Hz, Γ = {point.drive.gamma:.4g}"
    )
    details = [f"d = {1e3 * point.packing.diameter:g} mm"] if with_size else []
    for key, value in case.varied.items():
        text = f"{value:g}" if isinstance(value, int | float) else value
        details.append(f"{key.rpartition('.')[2].replace('_', ' ')} {text}")
    return "\n".join([title, ", ".join(details)]) if details else title


def read_records(case: Case, folder: Path, *, with_size: bool = False) -> list[RunRecord]:
    """Read the energy per cycle of each seed of a case whose run succeeded."""
    records = []
    for run, path in zip(case.runs, case.outcomes(folder), strict=True):
        outcome = coding.read(ShakeOutcome, path).found
        if outcome is None:
            continue
        read = rows.read_shaken(run, path.parent, outcome)
        damping, _ = rows.harmonic(run, read, outcome.mass_kg)
        estimate, _ = rows.estimates(run, read, outcome.mass_kg)
        mean, error, energy = (
            cycles.dissipated_energy(value, run.drive.amplitude, run.drive.frequency)
            for value in (estimate.mean, estimate.error, damping)
        )
        records.append(
            RunRecord(
                _title(case, with_size),
                run.packing.seed,
                np.asarray(energy),
                estimate.start,
                float(mean),
                float(error),
            )
        )
    return records
