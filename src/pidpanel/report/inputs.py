"""Records of what the stages left and a page is made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd
import xarray as xr

from pidpanel.coupon.round import Round
from pidpanel.damping.surface import DampingSurface
from pidpanel.panel.basis import PanelBasis
from pidpanel.report.evidence import DrawnSpheres, RunRecord, Shot
from pidpanel.study import Study


@dataclass(frozen=True)
class CouponResults:
    """What the coupon stage left."""

    cases: pd.DataFrame  # ``coupon/cases.csv``
    records: Sequence[Sequence[RunRecord]]  # cycles of a few cases, each with its runs
    spheres: DrawnSpheres  # particles of one run at its end
    shot: Shot | None = None  # the same run over some cycles; None where that was not possible


@dataclass(frozen=True)
class DampingResults:
    """What the damping stage left."""

    surface: DampingSurface  # ``damping/surface.nc``
    law: pd.DataFrame  # ``damping/law.csv``
    comparison: pd.DataFrame  # ``damping/forms.csv``
    cases: pd.DataFrame  # ``coupon/cases.csv``
    depth: float  # of the cell [m]
    rounds: Sequence[Round] = ()  # ``design/round*.json``; empty without tones


@dataclass(frozen=True)
class CoupledResults:
    """What the runs of panel and particles together left; points as text."""

    summary: pd.DataFrame  # ``coupled/summary.csv``
    psd: pd.DataFrame  # ``coupled/psd.csv``
    impedance: pd.DataFrame  # ``coupled/impedance.csv``
    verdict: pd.DataFrame | None = None  # ``coupled/verdict.csv``; None without another reading


@dataclass(frozen=True)
class Inputs:
    """All that the page of a study with a panel is made from."""

    study: Study
    stamp: Mapping[str, str]  # of the results
    summary: pd.DataFrame  # ``response/summary.csv``
    layouts: pd.DataFrame  # ``response/layouts.csv``
    psd: xr.Dataset  # ``response/psd.nc``
    modes: pd.DataFrame  # ``panel/modes.csv``
    basis: PanelBasis  # ``panel/modes.nc``
    section: pd.DataFrame  # ``panel/section.csv``
    bands: pd.DataFrame  # ``sound/spectrum.csv``
    printed: pd.DataFrame  # Table 1 of the paper
    coupons: Mapping[str, CouponResults]  # by damper; ``coupon`` is the section of the study
    stress: pd.DataFrame  # ``response/stress.csv``
    radiation: pd.DataFrame | None = None  # ``response/radiation.csv``, if asked for
    maps: xr.Dataset | None = None  # ``response/maps.nc``
    coupled: CoupledResults | None = None  # None without coupled runs
    damping: Mapping[str, DampingResults] = field(default_factory=dict)  # by damper
