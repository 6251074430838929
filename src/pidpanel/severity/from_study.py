"""Tables of a study's severity from its PSDs: the only module of the stage that reads it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.response.results import write_csv
from pidpanel.severity.fatigue import FatigueLine, dirlik_damage_rate, narrow_band_damage_rate
from pidpanel.severity.moments import peak_factor, spectral_moment, zero_crossing_rate
from pidpanel.severity.oscillators import miles, natural_frequencies, response_spectrum
from pidpanel.study import Study, StudyError

NAMES = {"reading": str, "scenario": str, "point": str}
STRESSES = ("stress_xx", "stress_yy", "stress_xy", "von_mises")


class SeverityFiles(NamedTuple):
    """The files of the stage; ``fatigue_csv`` has no rows without an S-N line."""

    oscillators_csv: Path
    peaks_csv: Path
    fatigue_csv: Path


class ResponseTables(NamedTuple):
    """Files of the response that the stage reads."""

    psd_nc: Path
    summary_csv: Path
    stress_nc: Path
    stress_csv: Path


def write_severity(study: Study, files: ResponseTables, output: SeverityFiles) -> None:
    """Write all tables of the stage.

    Parameters
    ----------
    study
        With the section ``severity``.
    files
        Errors are those of the rms accelerations and stresses there.

    Raises
    ------
    StudyError
        For a study without the section.
    """
    severity = study.severity
    if severity is None:
        raise StudyError(f"{study.name}: severity: missing")
    psd, stress = read_psd(files.psd_nc), read_psd(files.stress_nc)
    summary, stress_rows = (
        pd.read_csv(path, dtype=NAMES).set_index([*NAMES, *more]).sort_index()
        for path, more in ((files.summary_csv, []), (files.stress_csv, ["layer", "quantity"]))
    )
    relative = summary["acceleration_rms_error_g"] / summary["acceleration_rms_g"]
    frequency = psd["frequency"].to_numpy()
    natural = natural_frequencies(frequency[0], frequency[-1])
    oscillators: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    fatigue: list[dict[str, Any]] = []
    for where, case in _steady_cases(psd):
        points = [str(name) for name in case["point"].to_numpy()]
        values = case["acceleration_psd"].to_numpy() / STANDARD_GRAVITY**2
        error = relative.loc[tuple(where.values())].reindex(points).fillna(0.0).to_numpy()
        exact = response_spectrum(frequency, values, natural, severity.quality)
        approximate = miles(frequency, values, natural, severity.quality)
        for index, point in enumerate(points):
            place = {**where, "point": point}
            columns = {
                "natural_frequency_hz": natural,
                "oscillator_rms_g": exact[:, index],
                "oscillator_rms_error_g": error[index] * exact[:, index],
                "miles_rms_g": approximate[:, index],
            }
            oscillators.append(pd.DataFrame({**place, **columns}))
        peaks += _peak_rows(where, points, frequency, values, error, severity.duration_s)
        if severity.fatigue is not None:
            line = FatigueLine(
                severity.fatigue.stress_mpa * 1e6,
                severity.fatigue.cycles,
                severity.fatigue.exponent,
            )
            of_stress = stress_rows["relative_error"].fillna(0.0).loc[tuple(where.values())]
            fatigue += _fatigue_rows(
                where, stress.sel(where), frequency, of_stress, line, severity.duration_s
            )
    write_csv(output.oscillators_csv, pd.concat(oscillators))
    write_csv(output.peaks_csv, pd.DataFrame(peaks))
    write_csv(output.fatigue_csv, pd.DataFrame(fatigue, columns=list(FATIGUE_COLUMNS)))


def _steady_cases(psd: xr.Dataset) -> Iterator[tuple[dict[str, str], xr.Dataset]]:
    """Yield the cases with a response, each with its damping model and scenario."""
    for reading in psd["reading"].to_numpy():
        for scenario in psd["scenario"].to_numpy():
            if is_steady(psd, reading, scenario):
                where = {"reading": str(reading), "scenario": str(scenario)}
                yield where, psd.sel(where)


def _peak_rows(
    where: dict[str, str],
    points: list[str],
    frequency: Array,
    psd: Array,
    error: Array,
    duration: float,
) -> Iterator[dict[str, Any]]:
    rate = zero_crossing_rate(frequency, psd)
    factor = peak_factor(rate, duration)
    rms = np.sqrt(spectral_moment(frequency, psd, 0))
    for index, point in enumerate(points):
        if rms[index] > 0:
            yield {
                **where,
                "point": point,
                "acceleration_rms_g": rms[index],
                "three_sigma_g": 3 * rms[index],
                "zero_crossings_hz": rate[index],
                "peak_g": factor[index] * rms[index],
                "peak_error_g": factor[index] * rms[index] * error[index],
            }


FATIGUE_COLUMNS = (
    "reading",
    "scenario",
    "point",
    "layer",
    "quantity",
    "stress_rms_mpa",
    "zero_crossings_hz",
    "damage_dirlik",
    "damage_narrow_band",
    "damage_log_error",
)


def _fatigue_rows(
    where: dict[str, str],
    stress: xr.Dataset,
    frequency: Array,
    relative_error: pd.Series,
    line: FatigueLine,
    duration: float,
) -> Iterator[dict[str, Any]]:
    """Yield a row per point, layer and stress; errors by point, layer and stress."""
    for quantity in STRESSES:
        psd = stress[f"{quantity}_psd"].transpose("frequency", "point", "layer").to_numpy()
        rms = np.sqrt(spectral_moment(frequency, psd, 0)) / 1e6
        rate = zero_crossing_rate(frequency, psd)
        dirlik = dirlik_damage_rate(frequency, psd, line)
        narrow_band = narrow_band_damage_rate(frequency, psd, line)
        for (p, point), (n, layer) in _pairs(stress):
            if rms[p, n] > 0:
                values = (rms, rate, duration * dirlik, duration * narrow_band)
                numbers = [float(value[p, n]) for value in values]
                error = line.exponent * math.log1p(relative_error[point, layer, quantity])
                row = (*where.values(), point, layer, quantity, *numbers, error)
                yield dict(zip(FATIGUE_COLUMNS, row, strict=True))


def _pairs(stress: xr.Dataset) -> Iterator[tuple[tuple[int, str], tuple[int, str]]]:
    points, layers = (stress[axis].to_numpy().astype(str) for axis in ("point", "layer"))
    for point in enumerate(points.tolist()):
        for layer in enumerate(layers.tolist()):
            yield point, layer
