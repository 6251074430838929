"""What the stages left in files, read into the records of `pidpanel.report.inputs`."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import xarray as xr

from pidpanel.coupon.cases import Case
from pidpanel.coupon.from_study import cases_at, cases_by_coupon
from pidpanel.coupon.round import read_rounds
from pidpanel.damping import surface_files
from pidpanel.damping.surface_cases import AXES
from pidpanel.panel.basis_files import read_basis
from pidpanel.paths import PAPER_TABLE, SECTION, of_damper
from pidpanel.provenance.digests import stamp
from pidpanel.report import evidence
from pidpanel.report.films import read_film
from pidpanel.report.inputs import CoupledResults, CouponResults, DampingResults, Inputs
from pidpanel.report.known_errors import with_known_errors
from pidpanel.study import CouponStudy, Study, StudyError

STEADINESS_SHOWN = 6
"""Cases of which the cycles are shown."""


def read_inputs(study: Study, folder: Path, coupon: Path) -> Inputs:
    """Read all that the page of a study with a panel is made from."""
    response, panel = folder / "response", folder / "panel"
    compares_radiation = study.response.radiation_beside != "none"
    summary, psd = with_known_errors(
        study, _read_by_point(response / "summary.csv"), _read_dataset(response / "psd.nc")
    )
    return Inputs(
        study=study,
        stamp=stamp(study),
        summary=summary,
        layouts=_read_by_point(response / "layouts.csv"),
        psd=psd,
        modes=pd.read_csv(panel / "modes.csv"),
        basis=read_basis(panel / "modes.nc"),
        section=pd.read_csv(panel / "section.csv"),
        bands=pd.read_csv(folder / "sound" / "spectrum.csv"),
        printed=pd.read_csv(PAPER_TABLE, comment="#"),
        coupons={
            name: read_coupon(study, name, of_damper(folder / "coupon", name, "cases.csv"), coupon)
            for name in study.coupons
        },
        stress=_read_by_point(response / "stress.csv"),
        radiation=_read_by_point(response / "radiation.csv") if compares_radiation else None,
        maps=_read_dataset(response / "maps.nc"),
        coupled=read_coupled(study, folder / "coupled") if study.is_coupled else None,
        damping={name: read_damping(study, name, folder) for name in study.surfaces},
    )


def read_coupled(study: Study, folder: Path) -> CoupledResults:
    """Read what the runs of panel and particles together left."""
    summary, psd, impedance = (
        _read_by_point(folder / f"{name}.csv") for name in ("summary", "psd", "impedance")
    )
    has_readings = len(study.readings) > 1
    verdict = _read_by_point(folder / "verdict.csv") if has_readings else None
    return CoupledResults(summary, psd, impedance, verdict)


def _read_by_point(path: Path) -> pd.DataFrame:
    """Read a table whose names are names, even where they look like numbers."""
    return pd.read_csv(path, dtype=dict.fromkeys(("scenario", "patch", "point"), str))


def _read_dataset(path: Path) -> xr.Dataset:
    with xr.open_dataset(path, engine="scipy") as dataset:
        return dataset.load()


def read_coupon(study: CouponStudy, damper: str, table: Path, folder: Path) -> CouponResults:
    """Read the cases of a coupon, the cycles of a few and the particles of one."""
    if damper not in study.coupons:
        raise StudyError(f"{study.name}: no coupon named {damper!r}")
    cases = pd.read_csv(table)
    study_cases = {**cases_by_coupon(study)[damper], **_tones(study, damper, cases)}
    if unknown := sorted(set(cases["case"]) - set(study_cases)):
        raise StudyError(
            f"{table}: {unknown[0]}: not a case of {study.name} as it is now; run the study again"
        )
    sizes = {case.point.packing.diameter for case in study_cases.values()}
    return CouponResults(
        cases,
        [
            evidence.read_records(study_cases[label], folder, with_size=len(sizes) > 1)
            for label in evidence.spread_cases(cases, STEADINESS_SHOWN)
        ],
        evidence.read_spheres(study_cases[evidence.nearest_case(cases)], folder),
        read_film(study, damper, folder, table.with_name("film.nc")),
    )


def _tones(study: CouponStudy, damper: str, cases: pd.DataFrame) -> dict[str, Case]:
    """Return the cases of a table that are beside the sweep, where the study allows any."""
    if not isinstance(study, Study) or study.damping.tones is None or damper != SECTION:
        return {}
    points = cases[list(AXES)].to_numpy(float).tolist()
    tones = cases_at(study.coupons[damper], [(r, f, gamma) for r, f, gamma in points])
    return {case.label: case for case in tones}


def read_damping(study: Study, damper: str, folder: Path) -> DampingResults:
    """Read what the damping stage left of a coupon in the results of a study."""
    if damper not in study.coupons:
        raise StudyError(f"{study.name}: no coupon named {damper!r}")

    def file(name: str) -> Path:
        return of_damper(folder / "damping", damper, name)

    has_rounds = study.damping.tones is not None and damper == SECTION
    return DampingResults(
        surface_files.from_dataset(_read_dataset(file("surface.nc"))),
        pd.read_csv(file("law.csv")),
        pd.read_csv(file("forms.csv")),
        pd.read_csv(of_damper(folder / "coupon", damper, "cases.csv")),
        study.coupons[damper].cell.depth,
        read_rounds(folder / "design") if has_rounds else (),
    )
