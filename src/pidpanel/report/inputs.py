"""Records of what the stages left and a page is made from, and their files."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.damping import surface_files
from pidpanel.damping.models import Damper
from pidpanel.damping.surface import DampingSurface
from pidpanel.panel.basis import PanelBasis
from pidpanel.paths import of_damper
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.report.films import Shot
from pidpanel.report.names import Severity, Study, names_of
from pidpanel.report.rms import moving_points


class CouponResults(NamedTuple):
    """Results of the coupon stage."""

    cases: pd.DataFrame  # ``coupon/cases.csv``
    words: str = ""  # particles, cell, gravity, requested accuracy
    varied: Sequence[str] = ()  # columns in which cases differ besides fill, frequency and Γ
    shot: Shot | None = None  # one run over some cycles; None where that was not possible
    is_design: bool = False  # whether the cases are those of a table, each at a point of its own
    measured: pd.DataFrame | None = None  # of `measured.compared`; None without measured points


class DampingResults(NamedTuple):
    """Results of the damping stage."""

    surface: DampingSurface  # ``damping/surface.nc``
    law: pd.DataFrame  # ``damping/law.csv``


class CoupledResults(NamedTuple):
    """Results of the coupled runs; points as text."""

    summary: pd.DataFrame  # ``coupled/summary.csv``
    impedance: pd.DataFrame  # ``coupled/impedance.csv``
    verdict: pd.DataFrame | None = None  # ``coupled/verdict.csv``; None without another model


class AtlasResults(NamedTuple):
    """The atlas of particle beds, and what is read from it."""

    text: str  # version and cases
    models: Mapping[str, Damper]  # by damper


class SpreadResults(NamedTuple):
    """Results of the margin stage; points as text."""

    ranges: pd.DataFrame  # ``margin/ranges.csv``
    shares: pd.DataFrame  # ``margin/shares.csv``
    next_test: pd.DataFrame  # ``margin/next_test.csv``
    factor_of_safety: float  # ``margin.factor_of_safety``
    level: str | None = None  # ``sound.level``
    update: pd.DataFrame | None = None  # ``margin/tests.csv``; None without tests
    inputs: pd.DataFrame | None = None  # ``margin/inputs.csv``


class ProposalResults(NamedTuple):
    """Results of the optimise stage; points as text."""

    layouts: pd.DataFrame  # ``optimise/layouts.csv``
    front: pd.DataFrame  # ``optimise/front.csv``
    summary: pd.DataFrame  # ``optimise/summary.csv``
    psd: pd.DataFrame  # ``optimise/psd.csv``
    search: pd.Series  # ``optimise/search.csv``, values by quantity
    objective: str = "largest"  # ``optimise.objective``

    @property
    def excitations(self) -> list[str]:
        """Excitations of the search."""
        return list(dict.fromkeys(self.summary["excitation"]))


class SeverityResults(NamedTuple):
    """Results of the severity stage."""

    oscillators: pd.DataFrame  # ``severity/oscillators.csv``
    peaks: pd.DataFrame  # ``severity/peaks.csv``
    fatigue: pd.DataFrame  # ``severity/fatigue.csv``
    strength: pd.DataFrame  # ``severity/strength.csv``
    stated: Severity  # the section of the study
    maps: xr.Dataset | None = None  # ``severity/maps.nc``


class EnergyResults(NamedTuple):
    """Results of the energy stage; points as text."""

    bands: pd.DataFrame  # ``energy/bands.csv``
    summary: pd.DataFrame  # ``energy/summary.csv``
    psd: xr.Dataset  # ``energy/psd.nc``


class MeasurementResults(NamedTuple):
    """Results of the measurement stage."""

    measured: pd.DataFrame  # ``measurement/measured.csv``
    differences: pd.DataFrame  # ``measurement/differences.csv``
    hammer: xr.Dataset | None = None  # ``measurement/hammer.nc``


class BaseResults(NamedTuple):
    """Results of the base stage; None for a motion or notching that the study does not have."""

    modes: pd.DataFrame  # ``base/modes.csv``
    summary: pd.DataFrame | None  # ``base/summary.csv``
    psd: xr.Dataset | None  # ``base/psd.nc``
    notched: pd.DataFrame | None  # ``base/notched.csv``
    peaks: pd.DataFrame | None  # ``base/sine.csv``
    sine: xr.Dataset | None  # ``base/sine.nc``


@dataclass(frozen=True, kw_only=True)
class PanelInputs:
    """Inputs of the page of a study with a panel, under sound or on a shaker."""

    study: Study
    stamp: Mapping[str, str]  # of the results
    modes: pd.DataFrame  # ``panel/modes.csv``
    basis: PanelBasis  # ``panel/modes.nc``
    section: pd.DataFrame  # ``panel/section.csv``
    printed: pd.DataFrame  # Table 1 of the paper
    coupons: Mapping[str, CouponResults]  # by damper
    damping: Mapping[str, DampingResults] = field(default_factory=dict)  # by damper
    coupled: CoupledResults | None = None  # None without coupled runs
    atlas: AtlasResults | None = None  # None where nothing is read from it
    base: BaseResults | None = None  # None without base motion
    measurements: MeasurementResults | None = None  # None without the section ``measurements``
    margins: pd.DataFrame | None = None  # ``severity/margins.csv``; None without limits
    proposal: ProposalResults | None = None  # None without the section ``optimise``
    in_space: PanelBasis | None = None  # of a curved surface; ``basis`` is as it is drawn
    spread: SpreadResults | None = None  # None without the section ``uncertain``

    @property
    def names(self) -> dict[str, str]:
        """Names of the scenarios by label."""
        return names_of(self.study)


@dataclass(frozen=True, kw_only=True)
class Inputs(PanelInputs):
    """All that the page of a study under sound is made from."""

    summary: pd.DataFrame  # ``response/summary.csv``
    layouts: pd.DataFrame  # ``response/layouts.csv``
    psd: xr.Dataset  # ``response/psd.nc``
    bands: pd.DataFrame  # ``sound/spectrum.csv``
    stress: pd.DataFrame  # ``response/stress.csv``
    maps: xr.Dataset | None = None  # ``response/maps.nc``
    severity: SeverityResults | None = None  # None without the section ``severity``
    energy: EnergyResults | None = None  # None without the section ``energy``

    @property
    def moving_points(self) -> list[str]:
        """The points that do not lie on a support."""
        return moving_points(self.summary, list(self.study.panel.points))


# Columns of ``response/summary.csv`` with errors.
ERROR_COLUMNS = ("acceleration_rms_error_g", "reduction_error_db", "damping_read_at_error_g")


def read_by_point(path: Path) -> pd.DataFrame:
    """Read a table whose names are names, even where they look like numbers."""
    names = (
        "measurement",
        "scenario",
        "patch",
        "point",
        "drive",
        "doubts",
    )  # of no row, doubts are no text
    return read_csv(path, dtype=dict.fromkeys(names, str))


def _tables(folder: Path, *names: str) -> dict[str, pd.DataFrame]:
    return {name: read_by_point(folder / f"{name}.csv") for name in names}


def read_base(folder: Path, parts: Mapping[str, bool]) -> BaseResults:
    """Read what the base stage left of the motions and notching that a study has."""
    random, sine = parts["random"], parts["sine"]
    return BaseResults(
        read_csv(folder / "modes.csv"),
        read_by_point(folder / "summary.csv") if random else None,
        read_netcdf(folder / "psd.nc") if random else None,
        read_by_point(folder / "notched.csv").fillna({"reason": ""}) if parts["notching"] else None,
        read_by_point(folder / "sine.csv") if sine else None,
        read_netcdf(folder / "sine.nc") if sine else None,
    )


def read_coupled(folder: Path, *, with_verdict: bool) -> CoupledResults:
    """Read what the runs of panel and particles together left."""
    names = ["summary", "impedance", *(["verdict"] if with_verdict else [])]
    return CoupledResults(**_tables(folder, *names))


def read_proposal(folder: Path, objective: str) -> ProposalResults:
    """Read what the optimise stage left of a search for an objective."""
    tables = _tables(folder, "layouts", "front", "summary", "psd")
    search = read_csv(folder / "search.csv").set_index("quantity")["value"]
    return ProposalResults(**tables, search=search, objective=objective)


def read_spread(
    folder: Path, factor_of_safety: float, level: str | None, is_updated: bool
) -> SpreadResults:
    """Read what the margin stage left."""
    tables = _tables(folder, "ranges", "shares", "next_test")
    files = [folder / f"{name}.csv" for name in ("tests", "inputs")]
    made = [read_csv(file) if is_updated else None for file in files]
    return SpreadResults(
        tables["ranges"], tables["shares"], tables["next_test"], factor_of_safety, level, *made
    )


def read_severity(folder: Path, stated: Severity) -> SeverityResults:
    """Read what the severity stage left of a section of a study."""
    tables = _tables(folder, "oscillators", "peaks", "fatigue", "strength")
    texts = {"scenario", "point", "layer", "quantity"}
    for name, table in tables.items():  # pandas has no kind of number for an empty column
        numbers = [column for column in table if column not in texts]
        tables[name] = table.astype(dict.fromkeys(numbers, float))
    maps = None if stated.strength is None else read_netcdf(folder / "maps.nc")
    return SeverityResults(**tables, stated=stated, maps=maps)


def with_vertices(maps: xr.Dataset, position: Array) -> xr.Dataset:
    """Return maps with the vertices (n, 2) where they are drawn [m]."""
    drawn = maps.drop_vars("vertex_position")
    return drawn.assign(vertex_position=(("vertex", "axis"), position))


def read_measurements(folder: Path) -> MeasurementResults:
    """Read what the measurement stage left."""
    tables, hammer = _tables(folder, "measured", "differences"), folder / "hammer.nc"
    is_hit = (tables["differences"]["excitation"] == "hammer").any()
    return MeasurementResults(**tables, hammer=read_netcdf(hammer) if is_hit else None)


def read_damping(damper: str, folder: Path) -> DampingResults:
    """Read what the damping stage left of a coupon."""
    names = ("surface.nc", "law.csv")
    surface, law = (of_damper(folder / "damping", damper, name) for name in names)
    return DampingResults(surface_files.from_dataset(read_netcdf(surface)), read_csv(law))


def without_errors(
    labels: Collection[str], summary: pd.DataFrame, psd: xr.Dataset
) -> tuple[pd.DataFrame, xr.Dataset]:
    """Return ``summary.csv`` and ``psd.nc`` without the errors of some scenarios."""
    if not labels:
        return summary, psd
    summary, psd = summary.copy(), psd.copy()
    selected = summary["scenario"].isin(list(labels))
    summary.loc[selected, [name for name in ERROR_COLUMNS if name in summary]] = np.nan
    if "acceleration_psd_log_error" in psd:
        is_partial = psd["scenario"].isin(list(labels))
        psd["acceleration_psd_log_error"] = psd["acceleration_psd_log_error"].where(~is_partial)
    return summary, psd
