"""What the stages left in files, read into the records of `pidpanel.report.inputs`."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import xarray as xr

from pidpanel.coupon.from_study import cases_of
from pidpanel.damping.surface import DampingSurface
from pidpanel.panel.basis_files import read_basis
from pidpanel.paths import PAPER_TABLE
from pidpanel.report import evidence
from pidpanel.report.inputs import Coupon, DampingResults, Inputs
from pidpanel.round import read_rounds
from pidpanel.stamp import stamp
from pidpanel.study import CouponStudy, Study, StudyError

STEADINESS_SHOWN = 6
"""Cases of which the cycles are shown."""


def read_inputs(study: Study, folder: Path, coupon: Path) -> Inputs:
    """Read all that the page of a study with a panel is made from.

    Parameters
    ----------
    study
        The study.
    folder
        Results of the study, ``results/<study>``.
    coupon
        Runs of the coupon, ``results/coupon``.

    Raises
    ------
    StudyError
        As `read_coupon`.
    """
    response, panel = folder / "response", folder / "panel"
    beside = study.response.radiation_beside != "none"
    return Inputs(
        study=study,
        stamp=stamp(study),
        summary=_read_by_point(response / "summary.csv"),
        psd=_read_dataset(response / "psd.nc"),
        modes=pd.read_csv(panel / "modes.csv"),
        basis=read_basis(panel / "modes.nc"),
        section=pd.read_csv(panel / "section.csv"),
        bands=pd.read_csv(folder / "sound" / "spectrum.csv"),
        printed=pd.read_csv(PAPER_TABLE, comment="#"),
        coupon=read_coupon(study, folder / "coupon" / "cases.csv", coupon)
        if study.coupon
        else None,
        stress=_read_by_point(response / "stress.csv"),
        radiation=_read_by_point(response / "radiation.csv") if beside else None,
        maps=_read_dataset(response / "maps.nc"),
        damping=read_damping(study, folder) if "dem" in study.damping.readings else None,
    )


def _read_by_point(path: Path) -> pd.DataFrame:
    """Read a table whose points are names, even where they look like numbers."""
    return pd.read_csv(path, dtype={"point": str})


def _read_dataset(path: Path) -> xr.Dataset:
    with xr.open_dataset(path, engine="scipy") as dataset:
        return dataset.load()


def read_coupon(study: CouponStudy, table: Path, folder: Path) -> Coupon:
    """Read the cases of a coupon, the cycles of a few and the particles of one.

    Parameters
    ----------
    study
        Study with a section ``coupon``.
    table
        ``coupon/cases.csv`` of the study.
    folder
        Runs of the coupon, ``results/coupon``.

    Raises
    ------
    StudyError
        If the table holds a case that the study does not.
    """
    if study.coupon is None:
        raise StudyError(f"{study.name}: no section coupon")
    cases = pd.read_csv(table)
    known = {case.label: case for case in cases_of(study.coupon)}
    if unknown := sorted(set(cases["case"]) - set(known)):
        raise StudyError(
            f"{table}: {unknown[0]}: not a case of {study.name} as it is now; run the study again"
        )
    sizes = {case.point.packing.diameter for case in known.values()}
    return Coupon(
        cases,
        [
            evidence.read_records(known[label], folder, with_size=len(sizes) > 1)
            for label in evidence.spread_cases(cases, STEADINESS_SHOWN)
        ],
        evidence.read_spheres(known[evidence.nearest_case(cases)], folder),
    )


def read_damping(study: Study, folder: Path) -> DampingResults:
    """Read what the damping stage left in the results of a study.

    Parameters
    ----------
    study
        Study with a section ``coupon``.
    folder
        Results of the study, ``results/<study>``.
    """
    if study.coupon is None:
        raise StudyError(f"{study.name}: no section coupon")
    return DampingResults(
        DampingSurface.from_dataset(_read_dataset(folder / "damping" / "surface.nc")),
        pd.read_csv(folder / "damping" / "law.csv"),
        pd.read_csv(folder / "damping" / "forms.csv"),
        pd.read_csv(folder / "coupon" / "cases.csv"),
        study.coupon.cell.depth,
        read_rounds(folder / "design") if study.damping.target else (),
    )
