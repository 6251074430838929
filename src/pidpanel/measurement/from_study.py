"""Measured PSDs of a study beside computed ones: the only module of the stage that reads it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.measurement.differences import BandDifference, band_differences, common_range
from pidpanel.measurement.files import read_measured
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.response.results import write_csv
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake

NAMES = ("measurement", "reading", "scenario", "point")


def mistakes_of_files(study: Study) -> Iterator[Mistake]:
    """Yield what is wrong with the files, and those without a band of the response."""
    for name, measurement in study.measurements.items():
        keys = ("measurements", name, "file")
        try:
            measured = read_measured(measurement.file, measurement.record)
        except ColumnsError as error:
            yield from (Mistake(keys, fault) for fault in error.faults)
            continue
        low, high = study.response.frequency_hz
        if common_range(measured, low, high) is None:
            first, last = measured.frequency[[0, -1]]
            says = f"its lines are {first:g} to {last:g} Hz; must share a third octave with the "
            yield Mistake(keys, f"{says}response, {low:g} to {high:g} Hz")


def write_measurements(study: Study, psd_nc: Path, psd_csv: Path, differences_csv: Path) -> None:
    """Write the measured PSDs, and their differences from those of every damping model."""
    psd = read_psd(psd_nc)
    frequency = psd["frequency"].to_numpy()
    lines, rows = [], []
    for name, measurement in study.measurements.items():
        measured = read_measured(measurement.file, measurement.record)
        label = measurement.scenario or study.all_scenarios()[0].label
        columns = {"frequency_hz": measured.frequency, "acceleration_psd_g2_hz": measured.psd}
        lines.append(pd.DataFrame({"measurement": name, **columns}))
        for reading in study.readings:
            if not is_steady(psd, reading, label):
                continue
            case = psd.sel(reading=reading, scenario=label, point=measurement.point)
            values = case["acceleration_psd"].to_numpy() / STANDARD_GRAVITY**2
            error = case.get("acceleration_psd_log_error")
            log_error = None if error is None else np.asarray(error)
            where = (name, reading, label, measurement.point)
            bands = band_differences(measured, frequency, values, log_error)
            rows += [(*where, *band) for band in bands]
    write_csv(psd_csv, pd.concat(lines))
    columns_of_rows = [*NAMES, *BandDifference._fields]
    write_csv(differences_csv, pd.DataFrame(rows, columns=columns_of_rows))
