"""What the stages left in files, read into the records of `pidpanel.report.inputs`."""

from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import BY_DAMPER
from pidpanel.damping import surface_files
from pidpanel.paths import of_damper
from pidpanel.report import inputs
from pidpanel.report.names import Severity

# Columns of ``response/summary.csv`` with errors.
ERROR_COLUMNS = ("acceleration_rms_error_g", "reduction_error_db", "damping_read_at_error_g")

PARTLY = BY_DAMPER  # readings in which patches are read as the study states them


def read_by_point(path: Path) -> pd.DataFrame:
    """Read a table whose names are names, even where they look like numbers."""
    return pd.read_csv(
        path, dtype=dict.fromkeys(("measurement", "scenario", "patch", "point"), str)
    )


def _tables(folder: Path, *names: str) -> list[pd.DataFrame]:
    return [read_by_point(folder / f"{name}.csv") for name in names]


def read_dataset(path: Path) -> xr.Dataset:
    """Read a NetCDF file whole."""
    return xr.load_dataset(path, engine="scipy")


def read_base(folder: Path, parts: Mapping[str, bool]) -> inputs.BaseResults:
    """Read what the base stage left of the motions and limits that a study has."""
    random, sine = parts["random"], parts["sine"]
    return inputs.BaseResults(
        pd.read_csv(folder / "modes.csv"),
        read_by_point(folder / "summary.csv") if random else None,
        read_dataset(folder / "psd.nc") if random else None,
        read_by_point(folder / "notched.csv").fillna({"reason": ""}) if parts["limits"] else None,
        read_by_point(folder / "sine.csv") if sine else None,
        read_dataset(folder / "sine.nc") if sine else None,
    )


def read_coupled(folder: Path, *, with_verdict: bool) -> inputs.CoupledResults:
    """Read what the runs of panel and particles together left."""
    names = ["summary", "impedance", *(["verdict"] if with_verdict else [])]
    return inputs.CoupledResults(*_tables(folder, *names))


def read_proposal(folder: Path, objective: str) -> inputs.ProposalResults:
    """Read what the optimise stage left of a search for an objective."""
    tables = _tables(folder, "layouts", "front", "summary", "psd")
    search = pd.read_csv(folder / "search.csv").set_index("quantity")["value"]
    return inputs.ProposalResults(*tables, search=search, objective=objective)


def read_severity(folder: Path, stated: Severity) -> inputs.SeverityResults:
    """Read what the severity stage left of a section of a study."""
    tables = _tables(folder, "oscillators", "peaks", "fatigue", "strength", "margins")
    maps = None if tables[3].empty else read_dataset(folder / "maps.nc")
    return inputs.SeverityResults(*tables, stated=stated, maps=maps)


def read_measurements(folder: Path) -> inputs.MeasurementResults:
    """Read what the measurement stage left."""
    return inputs.MeasurementResults(*_tables(folder, "measured", "differences"))


def read_damping(damper: str, folder: Path) -> inputs.DampingResults:
    """Read what the damping stage left of a coupon."""

    def file(name: str) -> Path:
        return of_damper(folder / "damping", damper, name)

    return inputs.DampingResults(
        surface_files.from_dataset(read_dataset(file("surface.nc"))), pd.read_csv(file("law.csv"))
    )


def without_errors(
    labels: Collection[str], summary: pd.DataFrame, psd: xr.Dataset
) -> tuple[pd.DataFrame, xr.Dataset]:
    """Return ``summary.csv`` and ``psd.nc`` without the errors of some scenarios in `PARTLY`."""
    if not labels:
        return summary, psd
    summary, psd = summary.copy(), psd.copy()
    selected = summary["reading"].isin(PARTLY) & summary["scenario"].isin(list(labels))
    summary.loc[selected, [name for name in ERROR_COLUMNS if name in summary]] = np.nan
    if "acceleration_psd_log_error" in psd:
        of_psd = psd["reading"].isin(PARTLY) & psd["scenario"].isin(list(labels))
        psd["acceleration_psd_log_error"] = psd["acceleration_psd_log_error"].where(~of_psd)
    return summary, psd
