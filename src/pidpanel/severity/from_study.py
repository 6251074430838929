"""Tables of a study's severity from its PSDs: the only module of the stage that reads it."""

from typing import Any

import pandas as pd

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.response.results import write_csv
from pidpanel.severity.fatigue import FatigueLine
from pidpanel.severity.oscillators import miles, natural_frequencies, response_spectrum
from pidpanel.severity.strength import LayerStrength
from pidpanel.severity.tables import (
    COLUMNS,
    PointMotion,
    fatigue_rows,
    index_maps,
    margin_rows,
    peak_rows,
    strength_rows,
)
from pidpanel.spectra.acceleration_table import read_base_table
from pidpanel.study import Study, StudyError
from pidpanel.study.severity import Strengths

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
    relative = summary["acceleration_rms_error_g"] / summary["acceleration_rms_g"]
    frequency = psd["frequency"].to_numpy()
    natural = natural_frequencies(frequency[0], frequency[-1])
    fatigue, line = severity.fatigue, None
    if fatigue is not None:
        line = FatigueLine(fatigue.stress_mpa * 1e6, fatigue.cycles, fatigue.exponent)
    layers, core = strengths(severity.strength)
    limits = {point: read_base_table(path) for point, path in severity.limits.items()}
    oscillators: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    rows: dict[str, list[tuple[Any, ...]]] = {name: [] for name in COLUMNS}
    points = [str(name) for name in psd["point"].to_numpy()]
    for scenario in psd["scenario"].to_numpy().astype(str).tolist():
        if not is_steady(psd, scenario):
            continue
        where, case_key = {"scenario": scenario}, (scenario,)
        values = psd.sel(where)["acceleration_psd"].to_numpy() / STANDARD_GRAVITY**2
        error = relative.loc[case_key].reindex(points).fillna(0.0).to_numpy()
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
        motion = PointMotion(where, points, frequency, values, error)
        peaks += peak_rows(motion, severity.duration_s)
        rows["margins"] += margin_rows(motion, limits)
        stress_values = stress_rows.loc[case_key, :]
        rows["strength"] += strength_rows(where, stress_values, layers, core)
        if line is not None:
            relative_error = stress_values["relative_error"].fillna(0.0)
            rows["fatigue"] += fatigue_rows(
                where, stress.sel(where), frequency, relative_error, line, severity.duration_s
            )
    write_csv(output.oscillators, pd.concat(oscillators))
    write_csv(output.peaks, pd.DataFrame(peaks))
    for name, header in COLUMNS.items():
        write_csv(getattr(output, name), pd.DataFrame(rows[name], columns=list(header)))
    if severity.strength is not None:
        indices = index_maps(read_netcdf(files.maps), layers, core)
        indices.assign_attrs(stamp(study)).to_netcdf(output.maps, engine="scipy")


def strengths(section: Strengths | None) -> tuple[LayerStrength | None, tuple[float, float] | None]:
    """Return the strengths of the layers and of the core [MPa], as ``stress.csv`` has stresses."""
    if section is None:
        return None, None
    layers, core = section.layers, section.core
    return (
        None if layers is None else LayerStrength(*dict(layers).values()),
        None if core is None else (core.shear_xz_mpa, core.shear_yz_mpa),
    )
