"""The damping of a study: its models, and the files of the stage.

The only module of the stage that knows what a study is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pidpanel.atlas.groups import ElasticSphere
from pidpanel.columns import ColumnsError
from pidpanel.constants import ATLAS
from pidpanel.damping.interpolation import Interpolation
from pidpanel.damping.laws import ConstantDamper, PaperLaw
from pidpanel.damping.models import DampingError, DampingModel
from pidpanel.damping.table_files import IMAGINARY, MASS, PARTICLE_MASS, read_columns
from pidpanel.damping.tables import TableDamping
from pidpanel.paths import SECTION
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.study import Study
from pidpanel.study.coupon import Coupon
from pidpanel.study.dampers import Damper, WeighsAs
from pidpanel.study.damping import ModelName, Prior
from pidpanel.study.requirements import direction_of, mistakes_of_coupon

if TYPE_CHECKING:  # pandas, xarray and scipy.optimize, which a table does not need
    import pandas as pd

    from pidpanel.damping.atlas import AtlasDamping
    from pidpanel.damping.surface import DampingSurface


def surface_of(coupon: Coupon, cases: pd.DataFrame) -> DampingSurface:
    """Return the surface of the rows of ``cases.csv``.

    Only gravity along the motion holds the particles down: Γ₀ is its component.
    """
    from pidpanel.damping.surface import DampingSurface

    *_, along = np.array(coupon.gravity_direction) / np.hypot.reduce(coupon.gravity_direction)
    return DampingSurface.from_frame(
        cases, onset_g=coupon.gravity_g * abs(along), depth=coupon.cell.depth
    )


def read_cases(path: Path) -> pd.DataFrame:
    """Read the rows of ``cases.csv``; an empty field is a number that is not known."""
    return read_csv(path, keep_default_na=True)


def _surface_after(prior: Prior, path: Path, coupon: Coupon) -> DampingModel:
    """Read the surface of ``damping/surface.nc``: of its cases alone, or added to the atlas."""
    from pidpanel.damping import surface_files

    surface = surface_files.from_dataset(read_netcdf(path))
    if prior == "closed_form":
        return surface
    return atlas_model(coupon, is_broadband=False, surface=surface)


def read_table(
    path: Path,
    interpolation: Interpolation | None = None,
    *,
    impedance: bool = False,
    apparent_mass: WeighsAs | None = None,
) -> TableDamping:
    """Read a CSV table of damping, or of an impedance over frequency; log by default.

    Raises
    ------
    ColumnsError
        If the file has faults, with a line for each; or if m_a is to be the particles' mass, and
        the table does not have it, or has m_a.
    """
    columns = read_columns(path, impedance=impedance)
    if apparent_mass == "particles":
        if MASS in columns or IMAGINARY in columns:
            raise ColumnsError([f"{path}: has an apparent mass; apparent_mass is not allowed"])
        if PARTICLE_MASS not in columns:
            raise ColumnsError([f"{path}: column {PARTICLE_MASS}: missing; apparent_mass needs it"])
        columns[MASS] = columns[PARTICLE_MASS]
    return TableDamping(columns, interpolation or "log")


def study_model(name: ModelName, study: Study, surface: Path | None) -> DampingModel:
    """Return the damping model that a study names.

    Parameters
    ----------
    name
        One of ``damping.readings``.
    study
        Study with the table of the model ``table`` and the choice of particles without mass.
    surface
        ``damping/surface.nc``, for the model ``dem``.

    Raises
    ------
    ColumnsError
        If the table cannot be read.
    DampingError
        If a file is missing, or there is no such damping model.
    """
    reading = _model_with_mass(name, study, surface)
    return reading if study.response.damper_mass else reading.without_mass()


def _model_with_mass(name: ModelName, study: Study, surface: Path | None) -> DampingModel:
    damping = study.damping
    match name:
        case "dem" if surface is not None:
            return _surface_after(damping.prior, surface, study.coupons[SECTION])
        case "table" if damping.table is not None:
            return read_table(
                damping.table, damping.interpolation, apparent_mass=damping.apparent_mass
            )
        case "paper_corrected":
            return PaperLaw(printed=False)
        case "paper_printed":
            return PaperLaw(printed=True)
    raise DampingError(f"damping model {name}: unknown, or its file is missing")


def damper_model(
    damper: Damper, surface: Path | None, prior: Prior = "closed_form"
) -> DampingModel:
    """Return what a damper is, as the study states it.

    Parameters
    ----------
    damper
        One of ``dampers``.
    surface
        ``damping/<damper>/surface.nc``, for a coupon.
    prior
        ``damping.prior`` of the study.

    Raises
    ------
    ColumnsError
        If a table cannot be read.
    DampingError
        If the surface is missing.
    """
    if damper.law is not None:
        return PaperLaw(printed=damper.law == "paper_printed")
    if damper.table is not None:
        return read_table(damper.table, damper.interpolation, apparent_mass=damper.apparent_mass)
    if damper.impedance is not None:
        return read_table(damper.impedance, damper.interpolation, impedance=True)
    if damper.coupon is None:
        return _constant(damper)
    if surface is None:
        raise DampingError("a coupon without its damping/surface.nc")
    return _surface_after(prior, surface, damper.coupon)


def models_by_damper(
    study: Study, surface: Callable[[str], Path | None], *, is_broadband: bool
) -> dict[str, dict[str, DampingModel]]:
    """Return the models of single dampers, by the names of the model and of the damper.

    Parameters
    ----------
    surface
        Function of the name of a damper: its ``surface.nc``, if it has one.
    is_broadband
        Whether the motion is random; else it is a tone.
    """
    prior = study.damping.prior
    models: dict[str, dict[str, DampingModel]] = {
        "stated": {
            name: damper_model(study.all_dampers[name], surface(name), prior)
            for name in study.stated_dampers
        },
        ATLAS: {**atlas_models(study, is_broadband=is_broadband)},
    }
    if study.response.damper_mass:
        return models
    return {
        name: {damper: model.without_mass() for damper, model in dampers.items()}
        for name, dampers in models.items()
    }


def atlas_models(study: Study, *, is_broadband: bool) -> dict[str, AtlasDamping]:
    """Return what a study reads from the atlas, by damper; see `atlas_model`."""
    return {
        name: atlas_model(coupon, is_broadband=is_broadband)
        for name, coupon in study.atlas_coupons.items()
    }


def atlas_model(
    coupon: Coupon, *, is_broadband: bool, surface: DampingSurface | None = None
) -> AtlasDamping:
    """Return C_e and m_a of a coupon from the atlas of particle beds, under sound or tones.

    Parameters
    ----------
    coupon, is_broadband
        The coupon, and whether C_e is for sound.
    surface
        Surface of cases of the coupon that extend the atlas.
    """
    from pidpanel.damping.atlas import atlas_bed
    from pidpanel.damping.atlas_files import extended_atlas, read_atlas

    direction = direction_of(coupon)
    if direction is None:
        raise DampingError(f"gravity_direction = {coupon.gravity_direction}: not in the atlas")
    particles, cell = coupon.particles, coupon.cell
    diameter = coupon.diameters[0]
    bed = atlas_bed(
        particles.restitution, particles.friction, cell.across_flats, cell.depth, diameter,
        [direction], coupon.gravity_g,
    )  # fmt: skip
    atlas = read_atlas()
    bulk = atlas.bulk_fraction(cell.across_flats / diameter, cell.depth / diameter)
    density = particles.effective_density(diameter)
    mass_per_fill = bulk * density * cell.depth
    material = density, particles.youngs_modulus, particles.poissons_ratio
    sphere: ElasticSphere | None = ElasticSphere(diameter / 2, *material)
    if surface is not None:
        mass_per_fill, sphere = surface.mass_per_fill, None  # its own cases are as soft
        atlas = extended_atlas(bed, surface.cases, mass_per_fill)
    damping = replace(atlas.damping_of(bed, mass_per_fill), sphere=sphere)
    return damping.under_sound() if is_broadband else damping


def compare_measured(coupon: Coupon, cases: pd.DataFrame) -> pd.DataFrame:
    """Return the measured points of a coupon with its cases and the atlas; `measured.compared`.

    ``cases`` are the rows of its ``coupon/cases.csv``.
    """
    from pidpanel.damping.measured import compare, measured_points

    if coupon.measured is None:
        raise DampingError("a coupon without measured points")
    columns = read_columns(coupon.measured, scattered=True)
    atlas = None
    if not list(mistakes_of_coupon(coupon)):
        atlas = atlas_model(coupon, is_broadband=False)
    points = measured_points(columns, coupon.sweep.fill_fraction[0])
    return compare(points, cases, atlas)


def _constant(damper: Damper) -> ConstantDamper:
    """Return constants; m″ of a loss factor is that of the patch, or of the particles."""
    loss_factor, value = damper.loss_factor or 0.0, damper.equivalent_damping_n_s_m3 or 0.0
    error, reference = (
        (damper.loss_factor_error, loss_factor)
        if damper.loss_factor is not None
        else (damper.equivalent_damping_error_n_s_m3, value)
    )
    weight, weighs = damper.particle_mass_per_area_kg_m2 or 0.0, damper.apparent_mass is not None
    mass = damper.patch_mass_per_area_kg_m2 or weight
    return ConstantDamper(
        equivalent_damping=value,
        loss_mass=loss_factor * mass,
        relative_error=error / reference if error else 0.0,
        apparent_mass=damper.apparent_mass_kg_m2 or (weight if weighs else 0.0),
        apparent_mass_error=damper.apparent_mass_error_kg_m2 or 0.0,
        weight=damper.particle_mass_per_area_kg_m2,
    )


def write_damping(study: Study, damper: str, cases: Path, output: Files) -> None:
    """Write the surface of the cases of a damper's coupon and the constants of the law.

    Raises `DampingError` if the cases make no surface.
    """
    from pidpanel.damping import fit, surface_files

    surface = surface_of(study.coupons[damper], read_cases(cases))
    dataset = surface_files.to_dataset(surface).assign_attrs(stamp(study))
    dataset.to_netcdf(output.surface, engine="scipy")
    surface_files.to_frame(surface).to_csv(output.table, index=False, float_format="%.6g")
    fit.fit_accelerations(surface.cases).to_csv(output.law, index=False, float_format="%.6g")
