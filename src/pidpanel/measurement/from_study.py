"""Measured and computed PSDs of a study: the only module of the stage that reads it."""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import pandas as pd
import xarray as xr

from pidpanel.arrays import variable
from pidpanel.base.from_study import base_labels, shakers_of
from pidpanel.columns import ColumnsError, in_kilohertz
from pidpanel.measurement.computed import HAMMER, computed_psd, point_remainder, squared_accelerance
from pidpanel.measurement.differences import band_differences, common_range
from pidpanel.measurement.files import COLUMNS as FILE_COLUMNS
from pidpanel.measurement.files import FORCE_COLUMN, MeasuredPsd, read_measured
from pidpanel.measurement.universal import RecordChoice
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.response.from_study import read_response_panel
from pidpanel.response.psd_files import read_psd
from pidpanel.response.results import write_csv
from pidpanel.solve.basis_error import modal_basis
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.panel import deflection_at_points
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake, read_at
from pidpanel.study.response import Measurement

COLUMNS = (
    "measurement", "excitation", "drive", "scenario", "point", "center_hz", "lower_hz",
    "upper_hz", "measured_psd_g2_hz", "measured_transmissibility", "measured_accelerance_1_kg",
    "computed_psd_g2_hz", "computed_transmissibility", "computed_accelerance_1_kg",
    "difference_db", "difference_error_db",
)  # fmt: skip


def read_study_file(measurement: Measurement) -> MeasuredPsd:
    """Read the file of a measurement; see `read_measured`."""
    choice = RecordChoice(measurement.record, measurement.node, measurement.direction or "")
    return read_measured(measurement.file, choice, measurement.point)


def excitation_of(study: Study, measurement: Measurement, measured: MeasuredPsd) -> str:
    """Return what excited the panel: ``sound``, ``base`` or ``hammer``."""
    if measured.column == FORCE_COLUMN:
        return HAMMER
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
        if wrong := _mistake_of_hammer(study, measurement, measured):
            yield Mistake((*keys[:2], *wrong[0]), wrong[1])
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


def _mistake_of_hammer(
    study: Study, measurement: Measurement, measured: MeasuredPsd
) -> tuple[tuple[str, ...], str] | None:
    """Return the key and what is wrong with the point that a hammer hits."""
    points = ", ".join(study.panel.points)
    if measured.column != FORCE_COLUMN:
        message = "only allowed with an acceleration over force"
        return None if measurement.drive is None else (("drive",), message)
    if measurement.drive is None:
        message = "is an acceleration over force; the key drive must name the point that was hit: "
        return ("file",), f"{message}{points}"
    if measurement.drive not in study.panel.points:
        return ("drive",), f"unknown point; allowed are {points}"
    bare = {scenario.label for scenario in study.all_scenarios() if scenario.is_bare}
    if measurement.scenario not in (None, *bare) or measurement.excitation:
        key = "excitation" if measurement.excitation else "scenario"
        return (key,), "not allowed with an acceleration over force, of the bare panel hit alone"
    return None


def hammer_curves(study: Study, files: Files) -> xr.Dataset:
    """Return the squared accelerance of the bare panel at all points over all that may be hit.

    In the air of the sound of the study, in vacuum without sound.

    Parameters
    ----------
    files
        modes and plate; with sound modal_force and air.
    """
    if study.sound is not None:
        panel = read_response_panel(study, files)
        basis, modal, air, frequency = panel.basis, panel.modal, panel.air, panel.frequency
    else:
        basis, ratio, air = read_basis(files.modes), study.panel.modal_damping, None
        low, high = study.response.frequency_hz
        modal = modal_basis(basis, ratio, high)
        natural = basis.natural_frequency[~basis.is_residual]
        frequency = frequency_grid(low, high, ratio.smallest(low, high), natural)
    deflection = deflection_at_points(basis)
    remainder = point_remainder(read_plate(files.plate), modal, deflection)
    square = squared_accelerance(modal, deflection, remainder, frequency, air)
    names = list(basis.point_names)
    return xr.Dataset(
        {"squared_accelerance": variable("frequency point drive", square, "kg-2")},
        {"frequency": frequency, "point": names, "drive": names},
    )


def write_measurements(
    study: Study,
    curves: Mapping[str, Path | None],
    measured_csv: Path,
    differences_csv: Path,
    panel: Files | None = None,
    hammer_nc: Path | None = None,
) -> None:
    """Write the measured curves, and their differences from those of every damping model.

    Parameters
    ----------
    curves
        Files of the computed PSDs by excitation, ``sound`` and ``base``.
    panel, hammer_nc
        Files of `hammer_curves`, and its own; with a hammer.
    """
    computed = {name: read_psd(path) for name, path in curves.items() if path is not None}
    if panel is not None and hammer_nc is not None:
        computed[HAMMER] = hammer_curves(study, panel)
        computed[HAMMER].assign_attrs(stamp(study)).to_netcdf(hammer_nc, engine="scipy")
    labels = {"base": base_labels(study), "sound": {}, HAMMER: {}}
    lines, rows = [], []
    for name, measurement in study.measurements.items():
        measured = read_study_file(measurement)
        excitation = excitation_of(study, measurement, measured)
        by_label = {scenario.label: scenario for scenario in study.all_scenarios()}
        scenario = by_label[measurement.scenario or next(iter(by_label))]
        models = [scenario, *study.alternatives(scenario)][: 1 if excitation == HAMMER else None]
        lines.append(pd.DataFrame({"measurement": name, **measured.columns}))
        for label in dict.fromkeys(labels[excitation].get(s.label, s.label) for s in models):
            names = {"point": measurement.point, "drive": measurement.drive}
            scenarios = computed[excitation].get("scenario", [label])
            if label not in list(scenarios):  # of coupled runs a sine
                continue
            where = {"scenario": label, **{key: place for key, place in names.items() if place}}
            case = computed_psd(computed[excitation], where, over_base=measured.over_base)
            if case is not None:
                bands = band_differences(measured, *case)
                about = {"measurement": name, "excitation": excitation, **where}
                rows += bands.assign(**about).to_dict("records")
    write_csv(measured_csv, pd.concat(lines).reindex(columns=("measurement", *FILE_COLUMNS)))
    write_csv(differences_csv, pd.DataFrame(rows, columns=COLUMNS))
