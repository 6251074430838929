"""What the page is made from, as it was read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd
import xarray as xr

from pidpanel.panel.modes import PanelBasis
from pidpanel.report.damping_section import DampingResults
from pidpanel.report.evidence import Beads
from pidpanel.report.figures import Record
from pidpanel.study import Study


@dataclass(frozen=True)
class Coupon:
    """What the coupon stage left: cases, cycles of a few, the spheres of one."""

    cases: pd.DataFrame
    records: Sequence[Sequence[Record]]
    beads: Beads


@dataclass(frozen=True)
class Inputs:
    """All that the page is made from.

    Attributes
    ----------
    study, stamp
        The study, and what its results are stamped with.
    summary, psd
        ``response/summary.csv`` (points as text), ``response/psd.nc``.
    modes, basis, section
        ``panel/modes.csv``, ``panel/modes.nc``, ``panel/section.csv``.
    bands
        ``sound/spectrum.csv``.
    printed
        Table 1 of the paper.
    coupon
        None for a study without a coupon.
    stress
        ``response/stress.csv`` (points as text).
    radiation
        ``response/radiation.csv`` (points as text); None where nothing was asked beside.
    maps
        ``response/maps.nc``.
    damping
        None for a study that does not read its own cases.
    """

    study: Study
    stamp: Mapping[str, str]
    summary: pd.DataFrame
    psd: xr.Dataset
    modes: pd.DataFrame
    basis: PanelBasis
    section: pd.DataFrame
    bands: pd.DataFrame
    printed: pd.DataFrame
    coupon: Coupon | None
    stress: pd.DataFrame
    radiation: pd.DataFrame | None = None
    maps: xr.Dataset | None = None
    damping: DampingResults | None = None
