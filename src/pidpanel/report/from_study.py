"""Reports of studies: pages, the results they show and the files they read."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from pidpanel.coupon.cases import Case
from pidpanel.coupon.from_study import cases_by_coupon, plain
from pidpanel.damping.atlas_files import read_atlas, version_text
from pidpanel.damping.from_study import compare_measured, damper_model
from pidpanel.geometry.cells import SHAPES
from pidpanel.panel.files import read_basis
from pidpanel.paths import PAPER_TABLE, SECTION, of_damper
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.report import inputs
from pidpanel.report.facts import files_step, run_step
from pidpanel.report.films import read_film
from pidpanel.report.html import Page, write_page
from pidpanel.report.study_page import coupon_page, shaker_page, study_page
from pidpanel.report.templates import sentence
from pidpanel.response.from_study import partly_known
from pidpanel.structure.surface import flattened
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import VariedCoupon
from pidpanel.study.dampers import BedDamper


def write_study_page(
    study: Study, study_file: Path, folder: Path, file: Path, figures: Path
) -> None:
    """Write ``report.html`` and ``report/*`` of a study with a panel.

    Parameters
    ----------
    study, study_file
        The study and its file.
    folder
        Results of the study, ``results/<study>``.
    file, figures
        The page, and the folder of its figures.

    Raises
    ------
    StudyError
        If the results are not those of the study.
    """
    write_page(page_of(study, study_file, folder), Path(file), Path(figures))


def page_of(study: Study, study_file: Path, folder: Path) -> Page:
    """Return the page of `write_study_page`."""
    on_panel = read_panel_inputs(study, folder)
    steps = _steps(study, study_file)
    if study.sound is None:
        return shaker_page(on_panel, steps)
    return study_page(read_inputs(study, on_panel, folder), steps)


def write_coupon_page(
    study: CouponStudy, study_file: Path, table: Path, file: Path, figures: Path
) -> None:
    """Write the page and the figures of a study of a coupon alone.

    Parameters are those of `write_study_page`, and ``table``, its ``coupon/cases.csv``.
    """
    results = read_coupon(study, SECTION, Path(table))
    page = coupon_page(study, stamp(study), results, _steps(study, study_file))
    write_page(page, Path(file), Path(figures))


def _steps(study: CouponStudy, file: Path) -> list[tuple[str, str]]:
    """Return how to reproduce the results of a study."""
    decks = [deck for coupon in study.coupons.values() for deck in coupon.decks]
    return [run_step(file, decks), files_step(study.name)]


def spread_of(study: Study, folder: Path) -> inputs.SpreadResults:
    """Read what the margin stage left of a study with spreads; ``folder`` has its results."""
    margin, level, is_updated = study.margin, study.acoustics.level, study.update is not None
    return inputs.read_spread(folder / "margin", margin.factor_of_safety, level, is_updated)


def read_panel_inputs(study: Study, folder: Path) -> inputs.PanelInputs:
    """Read what pages of studies with a panel have in common."""
    panel, measured = folder / "panel", None
    if study.measurements:
        measured = inputs.read_measurements(folder / "measurement")
    basis = read_basis(panel / "modes.nc")
    return inputs.PanelInputs(
        study=study,
        stamp=stamp(study),
        modes=read_csv(panel / "modes.csv"),
        basis=flattened(basis),
        in_space=basis if basis.vertex_position.shape[1] == 3 else None,
        section=read_csv(panel / "section.csv"),
        printed=pd.read_csv(PAPER_TABLE, comment="#"),
        coupons={
            name: read_coupon(study, name, of_damper(folder / "coupon", name, "cases.csv"))
            for name in study.coupons
        },
        coupled=inputs.read_coupled(folder / "coupled", with_verdict=study.has_verdict)
        if study.is_coupled
        else None,
        atlas=read_atlas_results(study) if study.beds("atlas") else None,
        damping={name: inputs.read_damping(name, folder) for name in study.coupons},
        base=inputs.read_base(folder / "base", study.base.parts) if study.base else None,
        measurements=measured,
        margins=inputs.read_by_point(folder / "severity" / "margins.csv") if study.limits else None,
        proposal=inputs.read_proposal(folder / "optimise", study.optimise.objective)
        if study.optimise
        else None,
        spread=spread_of(study, folder) if study.uncertain else None,
    )


def read_atlas_results(study: Study) -> inputs.AtlasResults:
    """Return the atlas, and what a study reads from it."""
    beds = dict(study.beds("atlas"))
    for scenario in study.all_scenarios():  # with the gravity of a scenario, of a patch
        for patch in scenario.patches:
            bed = study.damper_in(scenario, patch)
            if isinstance(bed, BedDamper) and bed.model == "atlas":
                beds[study.damper_name(scenario, patch)] = bed
    models = {name: damper_model(bed) for name, bed in beds.items()}
    return inputs.AtlasResults(version_text(read_atlas()), models)


def read_inputs(study: Study, on_panel: inputs.PanelInputs, folder: Path) -> inputs.Inputs:
    """Read all that the page of a study under sound is made from."""
    response = folder / "response"
    table, psds = inputs.read_by_point(response / "summary.csv"), response / "psd.nc"
    summary, psd = inputs.without_errors(partly_known(study), table, read_netcdf(psds))
    return inputs.Inputs(
        **vars(on_panel),
        summary=summary,
        layouts=inputs.read_by_point(response / "layouts.csv"),
        psd=psd,
        bands=read_csv(folder / "sound" / "spectrum.csv"),
        stress=inputs.read_by_point(response / "stress.csv"),
        maps=inputs.with_vertices(
            read_netcdf(response / "maps.nc"), on_panel.basis.vertex_position
        ),
        energy=inputs.EnergyResults(
            read_csv(folder / "energy" / "bands.csv"),
            inputs.read_by_point(folder / "energy" / "summary.csv"),
            read_netcdf(folder / "energy" / "psd.nc"),
        )
        if study.energy
        else None,
        severity=inputs.read_severity(folder / "severity", study.severity)
        if study.severity
        else None,
    )


def read_coupon(study: CouponStudy, damper: str, table: Path) -> inputs.CouponResults:
    """Read what the coupon stage left of a damper; refuse a table of other cases."""
    if damper not in study.coupons:
        raise StudyError(f"{study.name}: no coupon named {damper!r}")
    cases = cases_by_coupon(study)[damper]
    rows = read_csv(table)
    if unknown := sorted(set(rows["case"]) - set(cases)):
        raise StudyError(
            f"{table}: {unknown[0]}: not a case of {study.name} as it is now; run the study again"
        )
    coupon, alone = study.coupons[damper], study.coupon
    return inputs.CouponResults(
        rows,
        coupon_words(coupon),
        varied_keys(study),
        read_film(cases, table.with_name("film.nc")),
        is_design=alone is not None and alone.cases is not None,
        measured=None
        if alone is None or alone.measured is None
        else _compared(alone, alone.measured, cases, rows),
    )


def _compared(
    coupon: VariedCoupon, file: Path, cases: Mapping[str, Case], rows: pd.DataFrame
) -> pd.DataFrame:
    """Return the measured points with each variant of a coupon; see `compare_measured`."""
    parts = []
    for chosen, variant in coupon.variants():
        varied = {key: plain(value) for key, value in chosen.items()}
        labels = [label for label, case in cases.items() if case.varied == varied]
        own = rows[rows["case"].isin(labels)]
        parts.append(compare_measured(variant, file, own).assign(**varied))
    return pd.concat(parts, ignore_index=True)


def varied_keys(study: CouponStudy) -> list[str]:
    """Return the columns of ``coupon/cases.csv`` varied besides fill, frequency and Γ."""
    if study.coupon is None:
        return []
    sizes = ["diameter_mm"] if len(study.coupon.sweep.diameter_mm) > 1 else []
    values = study.coupon.varied_values
    # a column of a table of cases may be the same in all
    keys = [key for key in values if study.coupon.cases is None or len(values[key]) > 1]
    return [*keys, *sizes]


def coupon_words(coupon: Coupon) -> str:
    """Return material, e, μ, cell, gravity and the requested accuracy of a coupon in words."""
    values = {
        "coupon": coupon,
        "varied": getattr(coupon, "varied_values", {}),
        "sizes": sorted(1e3 * d for d in coupon.diameters),
        "shape": SHAPES[coupon.cell.shape].word,
    }
    return sentence("particles.html", values)
