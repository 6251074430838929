"""The file of an identification and its results: the only module of the package that reads both."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from pidpanel.arrays import Array
from pidpanel.columns import ColumnsError, in_kilohertz
from pidpanel.damping.atlas import Atlas
from pidpanel.damping.atlas_files import read_atlas
from pidpanel.damping.measured import amplitudes_g, measured_values
from pidpanel.damping.table_files import (
    DAMPING,
    ERRORS,
    FILL,
    MASS,
    MOST_OF_MASS,
    PARTICLE_MASS,
    read_columns,
)
from pidpanel.identify.force_files import read_force
from pidpanel.identify.next_tones import candidates, next_tones
from pidpanel.identify.posterior import FillPrior, MeasuredDamping, Posterior, identify
from pidpanel.identify.prediction import BULK_ERROR, Specimen, Tones, predict
from pidpanel.measurement.universal import SUFFIXES
from pidpanel.provenance import durable
from pidpanel.spectra.acceleration_table import read_base_table
from pidpanel.study.document import Document, section_in
from pidpanel.study.identify import Identification, Measured
from pidpanel.study.mistakes import Mistake, Mistakes
from pidpanel.study.requirements import FILLS, FRICTION, RESTITUTION

MOST_ROWS = 60  # of a measurement
GAMMA, STROKE = (1.5, 700.0), (1e-5, 20.0)  # ranges of the atlas
FARTHEST = 5.0  # standard errors that a fill fraction may lie from the mass of the particles
SIZE_MARGIN = 0.1  # of the mean mass of a particle over the stated: 3 % of the diameter
NEXT_ERROR = 0.05  # relative, expected of a further test where the file states none
PARAMETERS = ("restitution", "friction", "fill_fraction")


@dataclass(frozen=True)
class IdentificationResult:
    """Particles of a specimen identified from a measurement."""

    identification: Identification
    atlas: Atlas
    measured: MeasuredDamping
    posterior: Posterior
    predictions: pd.DataFrame  # a row for each tone, as ``predictions.csv``
    further: pd.DataFrame  # a row for each further tone, as ``next_tests.csv``

    @property
    def is_upright(self) -> bool:
        """Whether gravity lies across the motion."""
        return self.identification.coupon.transverse_share == 1

    @property
    def outside(self) -> int:
        """Number of tones outside the atlas."""
        return int((~self.predictions["inside"]).sum())


def identify_file(file: Path) -> IdentificationResult:
    """Identify the particles of a damper from the file of its measurement.

    Raises
    ------
    StudyError
        One line for each mistake: file, line, key, value, what is wrong or what is allowed.
    """
    atlas = read_atlas()
    identification, specimen, measured = read_measurement(file, atlas)
    fill = _fill_prior(identification, specimen)
    ranges = RESTITUTION, (float(np.log(FRICTION[0])), float(np.log(FRICTION[1])))
    posterior = identify(atlas, specimen, measured, fill, ranges)
    shaker = identification.shaker
    tones = candidates(
        shaker.frequency_hz, shaker.acceleration_g, shaker.displacement_mm * 1e-3, specimen.onset_g
    )
    relative_error = identification.measured.relative_error or NEXT_ERROR
    further = next_tones(atlas, specimen, measured, posterior, tones, relative_error)
    predictions = _predictions(atlas, specimen, measured, posterior)
    if not predictions["inside"].any():
        strokes = predictions["stroke_per_gap"]
        message = (
            f"no tone lies in the atlas, Γ from {GAMMA[0]:g} to {GAMMA[1]:g} and W/L from "
            f"{STROKE[0]:g} to {STROKE[1]:g}; W/L is {strokes.min():.2g} to {strokes.max():.2g} "
            "(is the frequency in Hz?)"
        )
        raise Document(file).error([Mistake(("measured", "file"), message)])
    return IdentificationResult(identification, atlas, measured, posterior, predictions, further)


def read_measurement(file: Path, atlas: Atlas) -> tuple[Identification, Specimen, MeasuredDamping]:
    """Read the file of an identification, and what it names.

    Raises
    ------
    StudyError
        If `identify_file` raises it.
    """
    document = Document(file)
    identification = section_in(document, Identification)
    try:
        return identification, *_measurement(identification, atlas)
    except Mistakes as error:
        raise document.error(error.mistakes) from None


def _measurement(identification: Identification, atlas: Atlas) -> tuple[Specimen, MeasuredDamping]:
    """Return the damper and its measurement; `Mistakes` of the file."""
    coupon, particles = identification.coupon, identification.coupon.particles
    cell, diameter = coupon.cell, coupon.diameters[0]
    bulk = atlas.bulk_fraction(cell.across_flats / diameter, cell.depth / diameter)
    mass_per_fill = bulk * particles.effective_density(diameter) * cell.depth
    if coupon.transverse_share not in (0, 1):
        raise Mistakes([Mistake(("coupon", "gravity_direction"), "is not in the atlas")])
    weight = identification.particle_mass_per_area_kg_m2
    mass = weight or mass_per_fill * (identification.fill_fraction or 0.5)
    test = identification.measured
    try:
        if test.file.suffix.lower() in SUFFIXES:
            measured = _from_universal(test, mass)
        else:
            stated = {"record", "area_mm2", "fixture_mass_kg"} & test.model_fields_set
            message = "only allowed with a universal file"
            if faults := [Mistake(("measured", key), message) for key in sorted(stated)]:
                raise Mistakes(faults)
            measured, weight = _from_table(test, mass, weight)
    except ColumnsError as error:
        raise _refusal("file", *error.faults) from None
    low, high = identification.shaker.frequency_hz
    if in_kilohertz(measured.tones.frequency, low, high):
        message = f"its frequencies are at most {measured.tones.frequency.max():g} Hz, below "
        raise _refusal("file", f"{message}those of the shaker, {low:g} to {high:g} Hz; in kHz?")
    specimen = Specimen(
        cell.across_flats,
        cell.depth,
        diameter,
        coupon.transverse_share,
        coupon.gravity_g,
        mass_per_fill,
        weight,
    )
    if faults := list(_contradictions(identification, specimen, measured, mass)):
        raise Mistakes(faults)
    moves = measured.tones.acceleration_g > specimen.onset_g
    used = moves & (np.isfinite(measured.damping) | np.isfinite(measured.mass))
    if not used.any():
        message = f"no row has C_e above 0 and an acceleration above {specimen.onset_g:g} g, "
        raise _refusal("file", f"{message}from which on the particles move")
    return specimen, measured.rows(used)


def _refusal(key: str, *messages: str) -> Mistakes:
    """Return the error of a key of the section ``measured``."""
    return Mistakes(Mistake(("measured", key), message) for message in messages)


def _contradictions(
    identification: Identification, specimen: Specimen, measured: MeasuredDamping, mass: float
) -> Iterator[Mistake]:
    """Yield what the mass of the particles contradicts: size, fill fraction or m_a."""
    fill, weight = identification.fill_fraction, specimen.particle_mass
    density = identification.coupon.particles.effective_density(specimen.diameter)
    sphere, mean = 1e6 * density * np.pi / 6 * specimen.diameter**3, identification.particle_mass_mg
    if mean is not None and abs(mean / sphere - 1) > SIZE_MARGIN:
        message = f"contradicts coupon.particles, {sphere:.3g} mg each, by more than"
        yield Mistake(("particle_mass_mg",), f"{message} {SIZE_MARGIN:.0%}; another size, or two?")
    if fill is not None and weight is not None:
        expected = specimen.mass_per_fill * fill
        error = np.hypot(BULK_ERROR, identification.fill_fraction_error / fill)
        if abs(weight - expected) > FARTHEST * error * expected:
            message = f"particles of {weight:.3g} kg/m² contradict it: with it the cell holds "
            yield Mistake(
                ("fill_fraction",), f"{message}{expected:.3g} kg/m², to {100 * error:.0f} %"
            )
    worst = float(np.max(np.abs(measured.mass), initial=0.0, where=np.isfinite(measured.mass)))
    if worst > MOST_OF_MASS * mass:
        message = (
            f"an apparent mass of {worst:.3g} kg/m²: at most {MOST_OF_MASS:g} times the mass of "
        )
        yield Mistake(("measured", "file"), f"{message}the particles, {mass:.3g} kg/m²; in g/m²?")


def _from_table(
    test: Measured, mass: float, weight: float | None
) -> tuple[MeasuredDamping, float | None]:
    columns = read_columns(test.file, scattered=True)
    if FILL in columns:
        raise ColumnsError([f"{test.file}: column {FILL}: not allowed; use the key {FILL}"])
    if PARTICLE_MASS in columns:
        weight = mass = float(columns[PARTICLE_MASS][0])
    count = len(columns["frequency_hz"])
    if count > MOST_ROWS:
        message = f"has {count} rows; allowed are {MOST_ROWS}, such as means over third octaves"
        raise ColumnsError([f"{test.file}: {message}"])
    gamma, is_broadband = _level(test, amplitudes_g(columns), count)
    tones = Tones(columns["frequency_hz"], gamma, is_broadband)
    needs = [MASS] if MASS in columns else []
    needs += [name for name in ERRORS if name in columns and name != MASS]
    if test.relative_error is None and any(ERRORS[name] not in columns for name in needs):
        raise _refusal("relative_error", _MISSING)
    return measured_table(columns, tones, test.relative_error or 0.0, mass), weight


def measured_table(
    columns: Mapping[str, Array], tones: Tones, relative_error: float, particle_mass: float
) -> MeasuredDamping:
    """Return measured C_e and m_a from the columns of a table.

    Parameters
    ----------
    relative_error
        Standard error of C_e over C_e, and of m_a over ``particle_mass``, if the table has no
        errors.
    particle_mass
        Mass per area m″ of the particles [kg/m²].
    """
    damping, error, mass, mass_error = measured_values(columns)
    damping = np.where(damping > 0, damping, np.nan)
    error = np.where(np.isnan(error), relative_error * damping, error)
    mass_error = np.where(np.isnan(mass_error), relative_error * particle_mass, mass_error)
    return MeasuredDamping(tones, damping, error, mass, mass_error)


_MISSING = "missing; needed for a file without standard errors of all values"


def _from_universal(test: Measured, mass: float) -> MeasuredDamping:
    if test.area_mm2 is None:
        raise _refusal("area_mm2", "missing; needed for a universal file")
    if test.relative_error is None:
        raise _refusal("relative_error", _MISSING)
    bands = read_force(test.file, test.record, test.area_mm2 * 1e-6, test.fixture_mass_kg)
    gamma, is_broadband = _level(test, None, len(bands.frequency))
    tones, relative = Tones(bands.frequency, gamma, is_broadband), test.relative_error
    damping_error = np.hypot(bands.damping_error, relative * bands.damping)
    mass_error = np.hypot(bands.mass_error, relative * mass)
    return MeasuredDamping(tones, bands.damping, damping_error, bands.mass, mass_error)


def _level(test: Measured, gamma: Any, count: int) -> tuple[Any, Any]:
    """Return Γ (n,), of a random test √2 times its rms value, and whether the test is random."""
    rms = test.acceleration_rms_g
    if test.spectrum is not None:
        try:
            rms = read_base_table(test.spectrum).rms
        except ColumnsError as error:
            raise _refusal("spectrum", *error.faults) from None
    stated = test.acceleration_g if rms is None else np.sqrt(2) * rms
    if stated is None and gamma is None:
        message = "missing; needed for a file without amplitudes, or acceleration_rms_g"
        raise _refusal("acceleration_g", message)
    if stated is not None and gamma is not None:
        key = "acceleration_g" if rms is None else "acceleration_rms_g"
        raise _refusal(key, "not allowed; the file has amplitudes")
    is_broadband = np.full(count, rms is not None)
    return (np.full(count, stated) if gamma is None else gamma), is_broadband


def _fill_prior(identification: Identification, specimen: Specimen) -> FillPrior:
    """Return the prior of r from the file: r itself, or the mass of the particles."""
    if identification.fill_fraction is not None:
        return FillPrior(*FILLS, identification.fill_fraction, identification.fill_fraction_error)
    if specimen.particle_mass is None:
        return FillPrior(*FILLS)
    value = float(np.clip(specimen.particle_mass / specimen.mass_per_fill, *FILLS))
    return FillPrior(*FILLS, value, BULK_ERROR * value)


def _predictions(
    atlas: Atlas, specimen: Specimen, measured: MeasuredDamping, posterior: Posterior
) -> pd.DataFrame:
    """Return measured values and those of the atlas with the identified particles."""
    tones, n = measured.tones, len(measured.tones.frequency)
    particles = posterior.best[None]
    predicted = predict(atlas, specimen, particles, tones, measured.values)
    error = np.sqrt(np.diagonal(predicted.covariance[0]))
    score = (measured.values - predicted.mean[0]) / np.hypot(error, measured.errors)
    damping = np.exp(predicted.mean[0, :n])
    bed = specimen.bed(particles[:, 0], np.exp(particles[:, 1]))
    points = bed.points(np.full(n, particles[0, 2]), tones.frequency, tones.acceleration_g)
    stroke = np.exp(bed.log_stroke(points))
    in_range = [
        (low <= values) & (values <= high)
        for values, (low, high) in ((tones.acceleration_g, GAMMA), (stroke, STROKE))
    ]
    return pd.DataFrame(
        {
            "frequency_hz": tones.frequency,
            "acceleration_g": tones.acceleration_g,
            "stroke_per_gap": stroke,
            f"measured_{DAMPING}": measured.damping,
            f"measured_{ERRORS[DAMPING]}": measured.damping_error,
            f"atlas_{DAMPING}": damping,
            f"atlas_{ERRORS[DAMPING]}": damping * error[:n],
            "damping_difference_over_error": score[:n],
            f"measured_{MASS}": measured.mass,
            f"measured_{ERRORS[MASS]}": measured.mass_error,
            f"atlas_{MASS}": predicted.mean[0, n:],
            f"atlas_{ERRORS[MASS]}": error[n:],
            "mass_difference_over_error": score[n:],
            "inside": in_range[0] & in_range[1],
            "is_other_state": predicted.log_states[0] < np.log(0.5),
        }
    )


def write_tables(result: IdentificationResult, file: Path, folder: Path) -> None:
    """Write the tables of an identification, and the identified particles for a study."""
    folder.mkdir(parents=True, exist_ok=True)
    posterior = result.posterior
    e, log_friction, fill = posterior.particles.T
    weights = dict(zip(PARAMETERS, (e, np.exp(log_friction), fill), strict=True))
    tables = {
        "posterior": pd.DataFrame({**weights, "probability": posterior.weights.ravel()}),
        "summary": summary(posterior),
        "predictions": result.predictions,
        "next_tests": result.further.sort_values("information_nat", ascending=False),
    }
    for name, table in tables.items():
        durable.write_text(folder / f"{name}.csv", table.to_csv(index=False, float_format="%.6g"))
    durable.write_text(folder / "identified.yaml", _snippet(result, file))


def summary(posterior: Posterior) -> pd.DataFrame:
    """Return the rows of ``summary.csv``: value, standard deviation and interval of e, μ and r."""
    rows = []
    for axis, name in enumerate(PARAMETERS):
        estimate = posterior.estimate(axis)
        values = [estimate.value, estimate.low, estimate.high]
        if name == "friction":  # from the logarithm
            values = [float(value) for value in np.exp(values)]
        error = estimate.error * (values[0] if name == "friction" else 1.0)
        flags = estimate.cut_low, estimate.cut_high, estimate.is_determined
        rows.append((name, values[0], error, *values[1:], *flags))
    columns = ["parameter", "value", "error", "low_90", "high_90", "cut_low", "cut_high"]
    columns.append("determined")
    return pd.DataFrame(rows, columns=columns)


def _snippet(result: IdentificationResult, file: Path) -> str:
    """Return the section ``dampers`` of a study with the identified particles."""
    values = {
        row["parameter"]: float(f"{row['value']:.3g}")
        for row in summary(result.posterior).to_dict("records")
    }
    coupon = result.identification.coupon.model_dump(mode="json", exclude_unset=True)
    coupon["particles"] = {
        **coupon.get("particles", {}), **{name: values[name] for name in PARAMETERS[:2]}
    }  # fmt: skip
    text = yaml.safe_dump({"dampers": {result.identification.name: coupon}}, sort_keys=False)
    fill = f"fill_fraction: {values['fill_fraction']:g}"
    return f"# identified by pidpanel identify {file.name}; {fill}\n{text}"
