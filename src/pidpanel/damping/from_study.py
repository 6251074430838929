"""The damping of a study: its models, and the files of the stage.

The only module of the stage that knows what a study is.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

from pidpanel.atlas.groups import ElasticSphere
from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.interpolation import Interpolation
from pidpanel.damping.laws import ConstantDamper, PaperLaw
from pidpanel.damping.models import Damper, DampingError, Tolerance
from pidpanel.damping.table_files import FILL, IMAGINARY, MASS, PARTICLE_MASS, read_columns
from pidpanel.damping.tables import TableDamping
from pidpanel.paths import of_damper
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.study import Scenario, Study
from pidpanel.study.coupon import Coupon
from pidpanel.study.dampers import COUPLED, BedDamper, Prior
from pidpanel.study.requirements import ATLAS_RANGES, mistakes_of_coupon
from pidpanel.study.stated_dampers import (
    ConstantSection,
    DamperSection,
    ImpedanceDamper,
    LawDamper,
    LossFactorDamper,
    TableDamper,
    WeighsAs,
)
from pidpanel.study.stated_number import error_of

if TYPE_CHECKING:  # pandas, xarray and scipy.optimize, which a table does not need
    import pandas as pd

    from pidpanel.damping.atlas import AtlasDamping
    from pidpanel.damping.surface import DampingSurface


def surface_of(coupon: Coupon, cases: pd.DataFrame) -> DampingSurface:
    """Return the surface of the rows of ``cases.csv``.

    Only gravity along the motion holds the particles down: Γ₀ is its component.
    """
    from pidpanel.damping.surface import DampingSurface

    onset = abs(coupon.apparent_gravity_g[2])
    return DampingSurface.from_frame(cases, onset_g=onset, depth=coupon.cell.depth)


def read_cases(path: Path) -> pd.DataFrame:
    """Read the rows of ``cases.csv``; an empty field is a number that is not known."""
    return read_csv(path, keep_default_na=True)


def _surface_after(prior: Prior, path: Path, coupon: Coupon) -> Damper:
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


def damper_model(
    damper: DamperSection, surface: Path | None = None, *, is_broadband: bool = True
) -> Damper:
    """Return what a damper of a study is.

    Parameters
    ----------
    damper
        One of ``dampers``, but none of coupled runs, whose results are by patch.
    surface
        ``damping/<damper>/surface.nc``, for one of simulated tones.
    is_broadband
        Whether the motion is random; else it is a tone.

    Raises
    ------
    ColumnsError
        If a table cannot be read.
    DampingError
        If the surface is missing.
    """
    match damper:
        case LawDamper():
            return PaperLaw(printed=damper.law == "paper_printed")
        case TableDamper():
            weighs_as = damper.apparent_mass
            return read_table(damper.table, damper.interpolation, apparent_mass=weighs_as)
        case ImpedanceDamper():
            return read_table(damper.impedance, damper.interpolation, impedance=True)
        case ConstantSection():
            return _constant(damper, damper.equivalent_damping_n_s_m3, 0.0)
        case LossFactorDamper():
            weight = damper.particle_mass_per_area_kg_m2 or 0.0
            mass = damper.patch_mass_per_area_kg_m2 or weight
            return _constant(damper, 0.0, damper.loss_factor * mass)
        case BedDamper(model="atlas"):
            return atlas_model(damper, is_broadband=is_broadband)
        case BedDamper(model="tones") if surface is not None:
            return _surface_after(damper.prior, surface, damper)
    raise DampingError("its runs are missing")


def dampers_of(
    study: Study, folder: Path | None = None, *, is_broadband: bool = True
) -> dict[str, Damper]:
    """Return the used dampers of a study but those of coupled runs; see `damper_model`.

    They are by name, with that of a scenario's steady acceleration (`Scenario.damper_name`).
    ``folder`` has the surfaces of simulated tones. A damper that shall have no mass is a dashpot.
    """
    sections = {name: (name, study.dampers[name]) for name in study.used_dampers} | {
        study.damper_name(scenario, patch): (str(filling.damper), study.damper_in(scenario, patch))
        for scenario in study.all_scenarios()
        for patch, filling in scenario.fillings.items()
    }
    models = {}
    for label, (name, section) in sections.items():
        if name not in study.beds(COUPLED):
            surface = None if folder is None else of_damper(folder, name, "surface.nc")
            models[label] = damper_model(section, surface, is_broadband=is_broadband)
    return {label: with_mass_of(study, model) for label, model in models.items()}


def with_mass_of(study: Study, model: Damper) -> Damper:
    """Return a damper with its apparent mass, or without it where the study wants none."""
    return model if study.response.damper_mass else model.without_mass()


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

    particles, cell = coupon.particles, coupon.cell
    diameter = coupon.diameters[0]
    bed = atlas_bed(
        particles.impacts.value, particles.friction, cell.across_flats, cell.depth, diameter,
        [coupon.transverse_share], coupon.gravity / STANDARD_GRAVITY,
    )  # fmt: skip
    atlas = read_atlas()
    bulk = atlas.bulk_fraction(cell.across_flats / diameter, cell.depth / diameter)
    density = particles.effective_density(diameter)
    mass_per_fill = bulk * density * cell.depth
    material = density, particles.youngs_modulus, particles.poissons_ratio
    sphere: ElasticSphere | None = ElasticSphere(diameter / 2, *material)
    if surface is not None:
        mass_per_fill, sphere = surface.bed.mass_per_fill, None  # its own cases are as soft
        atlas = extended_atlas(bed, surface.cases, mass_per_fill)
    damping = replace(atlas.damping_of(bed, mass_per_fill), sphere=sphere)
    return damping.under_sound() if is_broadband else damping


def tolerances_of(study: Study, scenario: Scenario, patch: str) -> tuple[Tolerance, ...]:
    """Return the inputs of a patch with errors; those of particles are common to a damper."""
    bed, filling = study.damper_in(scenario, patch), scenario.fillings[patch]
    if not isinstance(bed, BedDamper) or (fill := filling.fill_fraction) is None:
        return ()
    particles = bed.particles
    stated = {"restitution": particles.impacts, "friction": particles.friction, FILL: fill}

    @cache
    def model_at(key: str, value: float) -> tuple[Damper, float]:
        changed = particles.model_copy(update={} if key == FILL else {key: value})
        model = atlas_model(bed.model_copy(update={"particles": changed}), is_broadband=True)
        return model, value if key == FILL else fill

    return tuple(
        Tolerance(
            f"{key} of {patch if key == FILL else filling.damper}",
            fill if key == FILL else particles.constant(key),
            error_of(number),
            ATLAS_RANGES[key],
            partial(model_at, key),
        )
        for key, number in stated.items()
        if error_of(number)
    )


def compare_measured(coupon: Coupon, file: Path, cases: pd.DataFrame) -> pd.DataFrame:
    """Return the measured points of a coupon with its cases and the atlas; `measured.compared`.

    ``file`` is their table, and ``cases`` are the rows of its ``coupon/cases.csv``.
    """
    from pidpanel.damping.measured import compare, measured_points

    columns = read_columns(file, scattered=True)
    atlas = None
    if not list(mistakes_of_coupon(coupon)):
        atlas = atlas_model(coupon, is_broadband=False)
    points = measured_points(columns, coupon.sweep.fill_fraction[0])
    return compare(points, cases, atlas)


def _constant(
    damper: ConstantSection | LossFactorDamper, value: float, loss_mass: float
) -> ConstantDamper:
    error, weight = getattr(damper, damper.error), damper.particle_mass_per_area_kg_m2
    mass = damper.apparent_mass_kg_m2 or (weight if damper.apparent_mass else 0.0)
    return ConstantDamper(
        equivalent_damping=value,
        loss_mass=loss_mass,
        relative_error=error / getattr(damper, damper.kind) if error else 0.0,
        apparent_mass=mass or 0.0,
        apparent_mass_error=damper.apparent_mass_error_kg_m2 or 0.0,
        weight=weight,
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
