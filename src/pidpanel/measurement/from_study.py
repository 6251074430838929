"""Measured and computed PSDs of a study: the only module of the stage that reads it."""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import pandas as pd

from pidpanel.base.from_study import base_labels, shakers_of
from pidpanel.columns import ColumnsError, in_kilohertz
from pidpanel.measurement.computed import computed_psd
from pidpanel.measurement.differences import band_differences, common_range
from pidpanel.measurement.files import COLUMNS as FILE_COLUMNS
from pidpanel.measurement.files import MeasuredPsd, read_measured
from pidpanel.measurement.universal import RecordChoice
from pidpanel.response.psd_files import read_psd
from pidpanel.response.results import write_csv
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake, read_at
from pidpanel.study.response import Measurement

COLUMNS = (
    "measurement", "excitation", "scenario", "point", "center_hz", "lower_hz",
    "upper_hz", "measured_psd_g2_hz", "measured_transmissibility", "computed_psd_g2_hz",
    "computed_transmissibility", "difference_db", "difference_error_db",
)  # fmt: skip


def read_study_file(measurement: Measurement) -> MeasuredPsd:
    """Read the file of a measurement; see `read_measured`."""
    choice = RecordChoice(measurement.record, measurement.node, measurement.direction or "")
    return read_measured(measurement.file, choice, measurement.point)


def excitation_of(study: Study, measurement: Measurement, measured: MeasuredPsd) -> str:
    """Return what excited the panel: ``sound`` or ``base``."""
    if measured.over_base:
        return "base"
    return measurement.excitation or ("base" if study.sound is None else "sound")


def mistakes_of_files(study: Study) -> Iterator[Mistake]:
    """Yield what is wrong with the files, and those without a band of the response."""
    for name, measurement in study.measurements.items():
        keys = ("measurements", name, "file")
        measured = yield from read_at(keys, partial(read_study_file, measurement))
        if measured is None:
            continue
        if measured.over_base and (study.base is None or measurement.excitation == "sound"):
            message = "is a transmissibility, which is compared with base motion alone"
            yield Mistake(keys, message if study.base else f"{message}; needs a section base")
            continue
        low, high = study.response.frequency_hz
        if excitation_of(study, measurement, measured) == "base" and study.base is not None:
            if study.base.random is None and not measured.over_base:
                yield Mistake(keys, "is a PSD, which under base motion needs base.random")
                continue
            try:
                low, high = next(iter(shakers_of(study).values())).spectrum.frequency[[0, -1]]
            except ColumnsError:  # a mistake of base.random
                continue
        if common_range(measured, low, high) is None:
            first, last = measured.frequency[[0, -1]]
            message = f"its lines are {first:g} to {last:g} Hz; must share a third octave with the "
            unit = "; in kHz?" if in_kilohertz(measured.frequency, low, high) else ""
            yield Mistake(keys, f"{message}response, {low:g} to {high:g} Hz{unit}")


def write_measurements(
    study: Study, curves: Mapping[str, Path | None], measured_csv: Path, differences_csv: Path
) -> None:
    """Write the measured curves, and their differences from those of every damping model.

    ``curves`` are the files of the computed PSDs by excitation, ``sound`` and ``base``.
    """
    computed = {name: read_psd(path) for name, path in curves.items() if path is not None}
    labels = {"base": base_labels(study), "sound": {}}
    lines, rows = [], []
    for name, measurement in study.measurements.items():
        measured = read_study_file(measurement)
        excitation = excitation_of(study, measurement, measured)
        by_label = {scenario.label: scenario for scenario in study.all_scenarios()}
        scenario = by_label[measurement.scenario or next(iter(by_label))]
        models = [scenario, *study.alternatives(scenario)]
        lines.append(pd.DataFrame({"measurement": name, **measured.columns}))
        for label in dict.fromkeys(labels[excitation].get(s.label, s.label) for s in models):
            if label not in computed[excitation]["scenario"].to_numpy():  # of coupled runs a sine
                continue
            where = {"scenario": label, "point": measurement.point}
            case = computed_psd(computed[excitation], where, over_base=measured.over_base)
            if case is not None:
                bands = band_differences(measured, *case)
                about = {"measurement": name, "excitation": excitation, **where}
                rows += bands.assign(**about).to_dict("records")
    write_csv(measured_csv, pd.concat(lines).reindex(columns=("measurement", *FILE_COLUMNS)))
    write_csv(differences_csv, pd.DataFrame(rows, columns=COLUMNS))
