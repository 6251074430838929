"""What the stages left in files, read into the records of `pidpanel.report.inputs`."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
import xarray as xr

from pidpanel.damping import surface_files
from pidpanel.paths import of_damper
from pidpanel.report import inputs


def read_by_point(path: Path) -> pd.DataFrame:
    """Read a table whose names are names, even where they look like numbers."""
    return pd.read_csv(
        path, dtype=dict.fromkeys(("measurement", "scenario", "patch", "point"), str)
    )


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
    summary, psd, impedance = (
        read_by_point(folder / f"{name}.csv") for name in ("summary", "psd", "impedance")
    )
    verdict = read_by_point(folder / "verdict.csv") if with_verdict else None
    return inputs.CoupledResults(summary, psd, impedance, verdict)


def read_proposal(folder: Path, objective: str) -> inputs.ProposalResults:
    """Read what the optimise stage left of a search for an objective."""
    layouts, front = (pd.read_csv(folder / f"{name}.csv") for name in ("layouts", "front"))
    search = pd.read_csv(folder / "search.csv").set_index("quantity")["value"]
    summary, psd = (read_by_point(folder / f"{name}.csv") for name in ("summary", "psd"))
    return inputs.ProposalResults(layouts, front, summary, search, psd, objective)


def read_severity(folder: Path, quality: float, duration: float) -> inputs.SeverityResults:
    """Read what the severity stage left, of oscillators of this Q and a duration [s]."""
    oscillators, peaks, fatigue, strength, margins = (
        read_by_point(folder / f"{name}.csv")
        for name in ("oscillators", "peaks", "fatigue", "strength", "margins")
    )
    maps = None if strength.empty else read_dataset(folder / "maps.nc")
    tables = (oscillators, peaks, fatigue, strength, margins)
    return inputs.SeverityResults(*tables, quality, duration, maps)


def read_measurements(folder: Path) -> inputs.MeasurementResults:
    """Read what the measurement stage left."""
    return inputs.MeasurementResults(
        *(read_by_point(folder / f"{name}.csv") for name in ("measured", "differences"))
    )


def read_damping(damper: str, folder: Path, depth: float) -> inputs.DampingResults:
    """Read what the damping stage left of a coupon whose cells are so deep [m]."""

    def file(name: str) -> Path:
        return of_damper(folder / "damping", damper, name)

    return inputs.DampingResults(
        surface_files.from_dataset(read_dataset(file("surface.nc"))),
        pd.read_csv(file("law.csv")),
        pd.read_csv(of_damper(folder / "coupon", damper, "cases.csv")),
        depth,
    )
