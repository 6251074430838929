"""Checks of the tables of a study: sound, base motion, limits and damping."""

import math
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.columns import in_kilohertz
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.study import Study
from pidpanel.study.base import OVERALL
from pidpanel.study.base_motion import BaseMotion, Notching, RandomMotion
from pidpanel.study.mistakes import Keys, Mistake, read_at
from pidpanel.study.panel import Panel
from pidpanel.study.response import LEAST_SPAN, Energy, Response
from pidpanel.study.sound import Sound
from pidpanel.study.stated_dampers import ImpedanceDamper, TableDamper
from pidpanel.study.structure import Structure

# Overall levels of a table [dB] outside which it is taken for one in other units
QUIETEST, LOUDEST = 100.0, 170.0
# Bands of levels [dB] that may be pressures [Pa]: the lowest is below, their range above
LOWEST_BAND, WIDEST_RANGE = 60.0, 50.0
MOST_SHIFT = 20.0  # of a table by oaspl_db [dB]
LOUDEST_SHAKER = 50.0  # overall value of a table [g rms], likewise

# Limit over the PSD of all of the input below which it is no notch: a lower input is meant.
DEEPEST = 1e-3


def check_damping_tables(study: Study) -> Iterator[Mistake]:
    """Yield what is wrong with the tables of damping, and with what is read from them."""
    from pidpanel.damping.from_study import read_table
    from pidpanel.damping.table_files import read_columns

    for keys, table in damping_tables(study):
        weighs_as = getattr(study.dampers[keys[1]], "apparent_mass", None)
        read = partial(
            read_table, table, impedance=keys[-1] == "impedance", apparent_mass=weighs_as
        )
        if (yield from read_at(keys, read)) is not None:
            yield from _check_range(study, keys, read_columns(table))


def _check_range(study: Study, keys: Keys, columns: Mapping[str, Array]) -> Iterator[Mistake]:
    """Yield a table with no frequency of the response, and fills beyond those of a table."""
    (low, high), frequency = study.response.frequency_hz, columns["frequency_hz"]
    if min(frequency) > high or max(frequency) < low:
        yield Mistake(keys, outside(frequency, study.response))
    if "fill_fraction" not in columns:
        return
    emptiest, fullest = (float(f(columns["fill_fraction"])) for f in (min, max))
    for way, fill in study.fills(str(keys[1])):
        if not emptiest <= fill <= fullest:
            table = ".".join(str(key) for key in keys)
            yield Mistake(way, f"must be in the range of {table}, {emptiest:g} to {fullest:g}")


def outside(frequency: ArrayLike, response: Response, relation: str = "all outside those") -> str:
    """Return how frequencies (n,) [Hz] lie to those of the response, and whether they are kHz."""
    low, high = response.frequency_hz
    message = f"its frequencies are {np.min(frequency):g} to {np.max(frequency):g} Hz, {relation} "
    message += f"of the response, {low:g} to {high:g} Hz"
    return f"{message}; in kHz?" if in_kilohertz(frequency, low, high) else message


def check_spectrum(sound: Sound, response: Response, energy: Energy | None) -> Iterator[Mistake]:
    """Yield levels that are most likely of another unit, and frequencies beyond the table."""
    from pidpanel.sound.from_study import measured_range, stated_spectrum

    keys: Keys = ("sound", "spectrum") if sound.spectra else ("sound", "field", "cross_spectra")
    spectrum = yield from read_at(keys, lambda: stated_spectrum(sound))
    if spectrum is None:
        return
    bands = getattr(spectrum, "band_spl", np.zeros(1))  # a table of a PSD has none
    sums = f"its {spectrum.rows} sum to {spectrum.oaspl:.1f} dB"
    if not OVERALL.holds(spectrum.oaspl):
        message = f"{sums}; {OVERALL.allowed}: are they in Pa?"
        yield Mistake(keys, message)
    elif sound.oaspl_db is None:
        doubt = "far below a launch; in Pa or Pa²/Hz?" if spectrum.oaspl < QUIETEST else ""
        if spectrum.oaspl > LOUDEST or _may_be_pascals(bands):
            doubt = doubt or "not those of a launch; in Pa?"
        if doubt:
            remedy = f"sound.oaspl_db = {spectrum.oaspl:.1f} states it if it is meant"
            yield Mistake(keys, f"{sums}, {doubt} {remedy}")
    elif sound.oaspl_db > spectrum.oaspl + MOST_SHIFT and _may_be_pascals(bands):
        message = (
            f"{sums}, far below oaspl_db = {sound.oaspl_db:g}; must be levels in dB, not in Pa"
        )
        yield Mistake(keys, message)
    low, high = spectrum.reach
    if sound.field_name == "measured":
        lines = yield from read_at(("sound", "field"), lambda: measured_range(sound))
        low, high = (max(low, lines[0]), min(high, lines[1])) if lines else (low, high)
    if response.frequency_hz[0] < low or response.frequency_hz[1] > high:
        message = (
            f"must be in the {spectrum.rows} of {' and '.join(sound.level_names)}, {low:.5g} to "
        )
        message += f"{high:.5g} Hz"
        if "frequency_hz" not in response.model_fields_set:
            message += "; by default it is {:g} to {:g} Hz".format(*response.frequency_hz)
        yield Mistake(("response", "frequency_hz"), message)
    if energy is not None and energy.highest_hz > high:
        yield Mistake(("energy", "highest_hz"), f"must be at most {high:.5g}, the end of the sound")


def _may_be_pascals(bands: Array) -> bool:
    """Return whether bands (n,) are rather those of a launch in Pa than in dB."""
    from pidpanel.sound.spectrum import REFERENCE_PRESSURE

    is_odd = np.ptp(bands) > WIDEST_RANGE or bands.max() < QUIETEST
    if not (is_odd and 0 < bands.min() < LOWEST_BAND):
        return False
    pressure = np.sqrt(np.sum(bands**2))
    return bool(QUIETEST <= 20 * np.log10(pressure / REFERENCE_PRESSURE) <= LOUDEST)


def check_limit(point: str, path: Path, response: Response) -> Iterator[Mistake]:
    """Yield what is wrong with the table of a limit, and one without a band of the response."""
    from pidpanel.solve.bands import third_octaves
    from pidpanel.spectra.acceleration_table import read_base_table

    keys = ("limits", point, "psd")
    limit = yield from read_at(keys, lambda: read_base_table(path))
    if limit is None:
        return
    (low, high), (lowest, highest) = response.frequency_hz, limit.frequency[[0, -1]].tolist()
    if third_octaves(max(low, lowest), max(low, min(high, highest)))[0].size == 0:
        yield Mistake(keys, outside(limit.frequency, response, "no third octave in those"))


def check_base(study: Study, motion: BaseMotion, random: RandomMotion) -> Iterator[Mistake]:
    """Yield what is wrong with the table of base motion, and an overall value it does not have."""
    from pidpanel.spectra.acceleration_table import OVERALL_TOLERANCE, read_base_table

    response = study.response
    keys = ("base", "random")
    spectrum = yield from read_at((*keys, "spectrum"), lambda: read_base_table(random.spectrum))
    if spectrum is None:
        return
    stated = random.overall_g
    if stated is not None and abs(spectrum.rms / stated - 1) > OVERALL_TOLERANCE:
        message = f"the table integrates to {spectrum.rms:.3g} g rms; must agree within "
        yield Mistake((*keys, "overall_g"), f"{message}{100 * OVERALL_TOLERANCE:.0f} %")
    if stated is None and spectrum.rms > LOUDEST_SHAKER:
        message = f"its break points have {spectrum.rms:.3g} g rms; in (m/s²)²/Hz? "
        message += f"base.random.overall_g = {spectrum.rms:.3g} states it if it is meant"
        yield Mistake((*keys, "spectrum"), message)
    low, high = spectrum.frequency[[0, -1]]
    if max(low, response.frequency_hz[0]) * LEAST_SPAN > min(high, response.frequency_hz[1]):
        message = f"must overlap the table {random.spectrum.name}, {low:g} to {high:g} Hz"
        yield Mistake(("response", "frequency_hz"), message)
    psd, rms = float(spectrum.psd.min()) * DEEPEST, math.sqrt(DEEPEST) * spectrum.rms
    limits, mass = motion.notching or Notching(), mass_of(study.panel)
    bounds: list[tuple[Keys, object, Mapping[str, float], str]] = [
        (("points", name), limit, {"psd_g2_hz": psd, "rms_g": rms}, "all of the input")
        for name, limit in limits.points.items()
    ]
    if limits.force is not None and mass is not None:
        rigid, words = mass * STANDARD_GRAVITY, "the force of the input on"
        force = {"psd_n2_hz": rigid**2 * psd, "rms_n": rigid * rms}
        bounds.append((("force",), limits.force, force, f"{words} {mass:.3g} kg, a rigid panel"))
    for way, limit, least, words in bounds:
        for key, lowest in least.items():
            value = getattr(limit, key)
            if value is not None and value < lowest:
                message = f"must be at least {lowest:.2g}, 30 dB below {words}; lower the input"
                yield Mistake(("base", "notching", *way, key), message)


def damping_tables(study: Study) -> Iterator[tuple[tuple[str, str, str], Path]]:
    """Yield the tables of damping that a study names, with the ways to them."""
    for name, damper in study.dampers.items():
        if isinstance(damper, TableDamper | ImpedanceDamper):
            yield ("dampers", name, damper.kind), damper.file


def mass_of(panel: Panel | Structure) -> float | None:
    """Return the mass of a panel without attachments [kg]; None where its mistakes are reported."""
    from pidpanel.panel.from_study import StudiedPanel

    if isinstance(panel, Structure):
        return panel.mass_kg
    studied = StudiedPanel(panel)
    try:
        return float(studied.section.mass_per_area * studied.area.area)
    except ValueError:
        return None
