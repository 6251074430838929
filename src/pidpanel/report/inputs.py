"""Records of what the stages left and a page is made from."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field

import pandas as pd
import xarray as xr

from pidpanel.damping.atlas import AtlasDamping
from pidpanel.damping.surface import DampingSurface
from pidpanel.panel.basis import PanelBasis
from pidpanel.report.films import Shot
from pidpanel.report.names import Severity, Study, names_of
from pidpanel.report.rms import moving_points


@dataclass(frozen=True)
class CouponResults:
    """What the coupon stage left."""

    cases: pd.DataFrame  # ``coupon/cases.csv``
    words: str = ""  # particles, cell, gravity, requested accuracy
    varied: Sequence[str] = ()  # columns in which cases differ besides fill, frequency and Γ
    shot: Shot | None = None  # one run over some cycles; None where that was not possible
    is_design: bool = False  # whether the cases are those of a table, each at a point of its own
    measured: pd.DataFrame | None = None  # of `measured.compared`; None without measured points


@dataclass(frozen=True)
class DampingResults:
    """What the damping stage left."""

    surface: DampingSurface  # ``damping/surface.nc``
    law: pd.DataFrame  # ``damping/law.csv``


@dataclass(frozen=True)
class CoupledResults:
    """What the runs of panel and particles together left; points as text."""

    summary: pd.DataFrame  # ``coupled/summary.csv``
    impedance: pd.DataFrame  # ``coupled/impedance.csv``
    verdict: pd.DataFrame | None = None  # ``coupled/verdict.csv``; None without another reading


@dataclass(frozen=True)
class AtlasResults:
    """The atlas of particle beds, and what is read from it."""

    version: str
    cases: int  # simulated
    models: Mapping[str, AtlasDamping]  # by damper


@dataclass(frozen=True)
class ProposalResults:
    """What the optimise stage left; points as text."""

    layouts: pd.DataFrame  # ``optimise/layouts.csv``
    front: pd.DataFrame  # ``optimise/front.csv``
    summary: pd.DataFrame  # ``optimise/summary.csv``
    psd: pd.DataFrame  # ``optimise/psd.csv``
    _: KW_ONLY
    search: pd.Series  # ``optimise/search.csv``, values by quantity
    objective: str = "largest"  # ``optimise.objective``

    @property
    def excitations(self) -> list[str]:
        """What the search counts."""
        return list(dict.fromkeys(self.summary["excitation"]))


@dataclass(frozen=True)
class SeverityResults:
    """What the severity stage left."""

    oscillators: pd.DataFrame  # ``severity/oscillators.csv``
    peaks: pd.DataFrame  # ``severity/peaks.csv``
    fatigue: pd.DataFrame  # ``severity/fatigue.csv``
    strength: pd.DataFrame  # ``severity/strength.csv``
    margins: pd.DataFrame  # ``severity/margins.csv``
    _: KW_ONLY
    stated: Severity  # the section of the study
    maps: xr.Dataset | None = None  # ``severity/maps.nc``


@dataclass(frozen=True)
class MeasurementResults:
    """What the measurement stage left."""

    measured: pd.DataFrame  # ``measurement/measured.csv``
    differences: pd.DataFrame  # ``measurement/differences.csv``


@dataclass(frozen=True)
class BaseResults:
    """What the base stage left; None for a motion or limits that the study does not have."""

    modes: pd.DataFrame  # ``base/modes.csv``
    summary: pd.DataFrame | None  # ``base/summary.csv``
    psd: xr.Dataset | None  # ``base/psd.nc``
    notched: pd.DataFrame | None  # ``base/notched.csv``
    peaks: pd.DataFrame | None  # ``base/sine.csv``
    sine: xr.Dataset | None  # ``base/sine.nc``


@dataclass(frozen=True, kw_only=True)
class PanelInputs:
    """What the page of a study with a panel is made from, under sound or on a shaker."""

    study: Study
    stamp: Mapping[str, str]  # of the results
    modes: pd.DataFrame  # ``panel/modes.csv``
    basis: PanelBasis  # ``panel/modes.nc``
    section: pd.DataFrame  # ``panel/section.csv``
    printed: pd.DataFrame  # Table 1 of the paper
    coupons: Mapping[str, CouponResults]  # by damper; ``coupon`` is the section of the study
    damping: Mapping[str, DampingResults] = field(default_factory=dict)  # by damper
    coupled: CoupledResults | None = None  # None without coupled runs
    atlas: AtlasResults | None = None  # None where nothing is read from it
    base: BaseResults | None = None  # None without base motion
    measurements: MeasurementResults | None = None  # None without the section ``measurements``
    proposal: ProposalResults | None = None  # None without the section ``optimise``

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

    @property
    def moving_points(self) -> list[str]:
        """The points that do not lie on a support."""
        return moving_points(self.summary, list(self.study.panel.points))
