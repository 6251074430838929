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
    """What the coupon stage left.

    Attributes
    ----------
    cases
        ``coupon/cases.csv``.
    records
        The cycles of a few cases, each with its runs.
    spheres
        The particles of one run at its end.
    shot
        The same run watched for some cycles; None where that was not possible.
    """

    cases: pd.DataFrame
    records: Sequence[Sequence[RunRecord]]
    spheres: DrawnSpheres
    shot: Shot | None = None


@dataclass(frozen=True)
class DampingResults:
    """What the damping stage left.

    Attributes
    ----------
    surface
        ``damping/surface.nc``.
    law, comparison
        ``damping/law.csv``, ``damping/forms.csv``.
    cases
        ``coupon/cases.csv``.
    depth
        Depth of the cell [m].
    rounds
        ``design/round*.json`` in order; empty for a study without tones.
    """

    surface: DampingSurface
    law: pd.DataFrame
    comparison: pd.DataFrame
    cases: pd.DataFrame
    depth: float
    rounds: Sequence[Round] = ()


@dataclass(frozen=True)
class CoupledResults:
    """What the runs of panel and particles together left; points as text.

    Attributes
    ----------
    summary, psd, impedance
        ``coupled/summary.csv``, ``coupled/psd.csv``, ``coupled/impedance.csv``.
    verdict
        ``coupled/verdict.csv``: the other readings beside them; None in a study without others.
    """

    summary: pd.DataFrame
    psd: pd.DataFrame
    impedance: pd.DataFrame
    verdict: pd.DataFrame | None = None


@dataclass(frozen=True)
class Inputs:
    """All that the page of a study with a panel is made from.

    Attributes
    ----------
    study, stamp
        The study and the stamp of its results.
    summary, layouts, psd
        ``response/summary.csv`` (points as text), ``response/layouts.csv``, ``response/psd.nc``.
    modes, basis, section
        ``panel/modes.csv``, ``panel/modes.nc``, ``panel/section.csv``.
    bands
        ``sound/spectrum.csv``.
    printed
        Table 1 of the paper.
    coupons
        By the names of their dampers; ``coupon`` is the section of the study.
    stress
        ``response/stress.csv`` (points as text).
    radiation
        ``response/radiation.csv`` (points as text); None without ``response.radiation_beside``.
    maps
        ``response/maps.nc``.
    coupled
        None without coupled runs.
    damping
        Of the coupons that are read, by the names of their dampers.
    """

    study: Study
    stamp: Mapping[str, str]
    summary: pd.DataFrame
    layouts: pd.DataFrame
    psd: xr.Dataset
    modes: pd.DataFrame
    basis: PanelBasis
    section: pd.DataFrame
    bands: pd.DataFrame
    printed: pd.DataFrame
    coupons: Mapping[str, CouponResults]
    stress: pd.DataFrame
    radiation: pd.DataFrame | None = None
    maps: xr.Dataset | None = None
    coupled: CoupledResults | None = None
    damping: Mapping[str, DampingResults] = field(default_factory=dict)
