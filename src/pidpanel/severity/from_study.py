"""Tables of a study's severity from its PSDs: the only module of the stage that reads it."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.base.from_study import base_labels
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.response.from_study import partly_known
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.response.results import write_csv
from pidpanel.severity import margins
from pidpanel.severity.fatigue import FatigueLine
from pidpanel.severity.oscillators import miles, natural_frequencies, response_spectrum
from pidpanel.severity.strength import LayerStrength
from pidpanel.severity.tables import (
    COLUMNS,
    Bursts,
    PointMotion,
    fatigue_rows,
    index_maps,
    peak_rows,
    strength_rows,
)
from pidpanel.spectra.acceleration_table import read_base_table
from pidpanel.study import Study, StudyError
from pidpanel.study.severity import Strengths, limit_tables

NAMES = {"scenario": str, "point": str}


def write_severity(study: Study, files: Files, output: Files) -> None:
    """Write all tables of the stage; `StudyError` for a study without the section ``severity``."""
    severity = study.severity
    if severity is None:
        raise StudyError(f"{study.name}: severity: missing")
    psd, stress = read_psd(files.psd), read_psd(files.stress)
    summary, stress_rows = (
        read_csv(path, dtype=NAMES).set_index([*NAMES, *keys]).sort_index()
        for path, keys in ((files.summary, []), (files.stress_table, ["layer", "quantity"]))
    )
    frequency = psd["frequency"].to_numpy()
    natural = natural_frequencies(frequency[0], frequency[-1])
    fatigue, line, exponent = severity.fatigue, None, 0.0
    if fatigue is not None:
        exponent = fatigue.exponent
        line = FatigueLine(fatigue.stress_mpa * 1e6, fatigue.cycles, exponent)
    layers, core = strengths(severity.strength)
    oscillators: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    rows: dict[str, list[tuple[Any, ...]]] = {name: [] for name in COLUMNS}
    coupled = files.get("coupled")
    recorded = (
        None
        if coupled is None
        else read_csv(coupled, ["log_damage_4"], dtype=NAMES).set_index([*NAMES])
    )
    for motion in _motions(psd, summary, recorded=recorded, exponent=exponent):
        motion = motion._replace(error=np.nan_to_num(motion.error))
        where, points, _, values, error, bursts = motion
        case_key = tuple(where.values())
        rms = response_spectrum(frequency, values, natural, severity.quality)
        approximate = miles(frequency, values, natural, severity.quality)
        for index, point in enumerate(points):
            columns = {
                "natural_frequency_hz": natural,
                "oscillator_rms_g": rms[:, index],
                "oscillator_rms_error_g": error[index] * rms[:, index],
                "miles_rms_g": approximate[:, index],
            }
            oscillators.append(pd.DataFrame({**where, "point": point, **columns}))
        peaks += peak_rows(motion, severity.duration_s)
        stress_values = stress_rows.loc[case_key, :]
        rows["strength"] += strength_rows(where, stress_values, layers, core)
        if line is not None:
            relative_error = stress_values["relative_error"].fillna(0.0)
            rows["fatigue"] += fatigue_rows(
                where, stress.sel(where), frequency, relative_error, line,
                severity.duration_s, bursts,
            )  # fmt: skip
    write_csv(output.oscillators, pd.concat(oscillators))
    write_csv(output.peaks, pd.DataFrame(peaks))
    for name, header in COLUMNS.items():
        write_csv(getattr(output, name), pd.DataFrame(rows[name], columns=list(header)))
    if severity.strength is not None:
        indices = index_maps(read_netcdf(files.maps), layers, core)
        indices.assign_attrs(stamp(study)).to_netcdf(output.maps, engine="scipy")


def write_margins(study: Study, files: Files, output: Path) -> None:
    """Write the margins to the limits of a study under sound and random base motion.

    ``files`` has ``psd`` and ``summary`` of both, those of base motion as ``base_…``.
    """
    unknown, tables = partly_known(study), []
    if (path := files.get("psd")) is not None:
        tables.append(("sound", read_psd(path), read_csv(files.summary, dtype=NAMES), unknown))
    if (path := files.get("base_psd")) is not None:
        base, summary = read_psd(path), read_csv(files.base_summary, dtype=NAMES)
        base = base.rename(absolute_acceleration_psd="acceleration_psd")
        labels = [base_labels(study)[label] for label in unknown]
        for level, name in (("stated", "base"), ("notched", "notched base")):
            rows = summary[summary["input"] == level]
            tables.append((name, base.sel(input=level), rows, labels))
    rows = pd.concat([_margins(study, *table) for table in tables])
    write_csv(output, rows[list(margins.COLUMNS)])


def _margins(
    study: Study, excitation: str, psd: xr.Dataset, summary: pd.DataFrame, unknown: Sequence[str]
) -> pd.DataFrame:
    """Return the margins under an excitation; errors of some scenarios are ``unknown``."""
    limits = {point: read_base_table(path) for point, path in limit_tables(study.limits).items()}
    bands = [
        row
        for motion in _motions(psd, summary.set_index(list(NAMES)).sort_index(), unknown)
        for row in margins.band_rows(motion, limits)
    ]
    rows = pd.DataFrame(bands, columns=list(margins.ROW))
    parts = [rms_margins(study, summary, unknown), margins.with_margins(rows)]
    judged = pd.concat([part for part in parts if len(part)] or parts[:1])
    doubts = summary[[*margins.PLACE, "doubts"]]
    return judged.assign(excitation=excitation).merge(doubts, "left", list(margins.PLACE))


def rms_margins(
    study: Study, summary: pd.DataFrame, unknown: Sequence[str] | None = None
) -> pd.DataFrame:
    """Return the margins of rms values to the limits of a study.

    Parameters
    ----------
    summary
        ``response/summary.csv``, or ``base/summary.csv`` under one input.
    unknown
        Scenarios without an error; by default those of `partly_known`.
    """
    limits = {name: limit.rms_g for name, limit in study.limits.items() if limit.rms_g is not None}
    is_unknown = summary["scenario"].isin(partly_known(study) if unknown is None else unknown)
    error = summary["acceleration_rms_error_g"].mask(is_unknown)
    rows = margins.rms_rows(summary.assign(acceleration_rms_error_g=error), limits)
    return margins.with_margins(rows)


def strengths(section: Strengths | None) -> tuple[LayerStrength | None, tuple[float, float] | None]:
    """Return the strengths of the layers and of the core [MPa], as ``stress.csv`` has stresses."""
    if section is None:
        return None, None
    layers, core = section.layers, section.core
    return (
        None if layers is None else LayerStrength(*dict(layers).values()),
        None if core is None else (core.shear_xz_mpa, core.shear_yz_mpa),
    )


def _motions(
    psd: xr.Dataset,
    summary: pd.DataFrame,
    unknown: Sequence[str] = (),
    recorded: pd.DataFrame | None = None,
    exponent: float = 0.0,
) -> Iterator[PointMotion]:
    """Yield the motion in each scenario with a response.

    ``summary`` and ``recorded``, that of ``coupled/summary.csv``, are by scenario and point.
    """
    relative = summary["acceleration_rms_error_g"] / summary["acceleration_rms_g"]
    points = [str(name) for name in psd["point"].to_numpy()]
    for scenario in psd["scenario"].to_numpy().tolist():
        if is_steady(psd, scenario):
            where = {"scenario": str(scenario)}
            values = psd["acceleration_psd"].sel(where).transpose("frequency", "point").to_numpy()
            error = relative.loc[where["scenario"]].reindex(points).to_numpy()
            error = np.where(scenario in unknown, np.nan, error)
            psd_g = values / STANDARD_GRAVITY**2
            bursts = Bursts.none(len(points))
            if recorded is not None and where["scenario"] in recorded.index:
                rows = pd.DataFrame(recorded.loc[where["scenario"]]).reindex(points)
                bursts = Bursts.recorded(rows, exponent)
            yield PointMotion(where, points, psd["frequency"].to_numpy(), psd_g, error, bursts)
