"""Checks of a study before anything runs."""

import itertools
import math
import tempfile
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index
from pidpanel.columns import in_kilohertz
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.geometry.polygon import overlap
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.base import OVERALL
from pidpanel.study.base_motion import BaseMotion, Notching, RandomMotion
from pidpanel.study.document import Document, study_in
from pidpanel.study.mistakes import Keys, Mistake, read_at
from pidpanel.study.panel import MOST_CARRIED, Panel, key_path
from pidpanel.study.response import LEAST_SPAN, Energy, Response
from pidpanel.study.severity import limit_tables
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


def checked_study(source: str | Path | Document) -> Study | CouponStudy:
    """Read a study and everything it names; refuse what could not be computed.

    Raises
    ------
    StudyError
        One line for each mistake: file, line, key, value, what is wrong or what is allowed.
    """
    document = source if isinstance(source, Document) else Document(Path(source))
    study = study_in(document)
    mistakes = [mistake for name in study.coupons for mistake in check_decks(study, name)]
    mistakes += check_measured(study)
    if isinstance(study, Study):
        mistakes += check_panel(study)
    if mistakes:
        raise document.error(dict.fromkeys(mistakes))
    if isinstance(study, Study) and isinstance(study.panel, Structure):
        from pidpanel.structure.from_study import with_normals

        return study.model_copy(update={"panel": with_normals(study.panel)})
    return study


def check_measured(study: CouponStudy) -> Iterator[Mistake]:
    """Yield the mistakes of the table of measured points of a coupon."""
    coupon, keys = study.coupon, ("coupon", "measured")
    if coupon is None or coupon.measured is None:
        return
    from pidpanel.damping.table_files import AMPLITUDES, FILL, read_columns

    file = coupon.measured
    columns = yield from read_at(keys, lambda: read_columns(file, scattered=True))
    if columns is None:
        return
    if not set(AMPLITUDES) & set(columns):
        yield Mistake(keys, f"column {' or '.join(AMPLITUDES)}: missing")
    if FILL not in columns and len(coupon.sweep.fill_fraction) > 1:
        yield Mistake(keys, f"column {FILL}: missing; required for several fills in the sweep")


def check_machine(study: CouponStudy, results: Path) -> None:
    """Refuse a machine without LIGGGHTS, or a results folder that is not writable.

    Raises
    ------
    StudyError
    """
    if study.coupons or study.is_coupled:
        from pidpanel.coupon.liggghts.failures import SolverMissing
        from pidpanel.coupon.liggghts.process import check_installed

        try:
            check_installed()
        except SolverMissing as error:
            raise StudyError(str(error)) from None
    try:
        results.mkdir(exist_ok=True)
        tempfile.TemporaryFile(dir=results).close()
    except OSError as error:
        raise StudyError(f"{results}: must be a writable folder ({error.strerror})") from None


def check_decks(study: CouponStudy, name: str) -> Iterator[Mistake]:
    """Yield the mistakes of a coupon's own decks."""
    coupon = study.coupons[name]
    if coupon.decks or coupon.deck_values:
        from pidpanel.coupon.from_study import mistakes_of_decks  # slow to import

        mistakes = mistakes_of_decks(coupon)
        keys = ("dampers", name) if isinstance(study, Study) else ("coupon",)
        yield from (mistake.prefix(*keys) for mistake in mistakes)


def check_panel(study: Study) -> Iterator[Mistake]:
    """Yield what of a panel in its sound could not be computed."""
    # two seconds of imports that a study of the coupon alone does not need
    from pidpanel.damping.laws import FREQUENCY_RANGE
    from pidpanel.solve.lines import LINES_AT_MOST, line_count, smallest_damping_ratio

    low, high = study.response.frequency_hz
    outside_law = not (FREQUENCY_RANGE[0] <= low and high <= FREQUENCY_RANGE[1])
    if outside_law and any(study.dampers[name].kind == "law" for name in study.used_dampers):
        message = "must be in the range of the paper's law, {:g} to {:g} Hz".format(
            *FREQUENCY_RANGE
        )
        yield Mistake(("response", "frequency_hz"), message)
    table_mistakes = list(_check_tables(study))
    yield from table_mistakes
    lines = line_count(low, high, study.panel.modal_damping.smallest(low, high))
    if lines > LINES_AT_MOST:
        ratio = smallest_damping_ratio(low, high)
        figures = 2 - math.floor(math.log10(ratio))
        ratio = math.ceil(ratio * 10**figures) / 10**figures
        message = f"resolving its resonances takes {lines} frequency lines from {low:g} to "
        message += f"{high:g} Hz; allowed are {LINES_AT_MOST}, for ratios from {ratio:g}"
        yield Mistake(("panel", "damping_ratio"), message)
    frequency = study.panel.modal_damping.frequency
    if frequency and in_kilohertz(frequency, low, high):
        yield Mistake(("panel", "damping_ratio"), _outside(frequency, study.response))
    if study.base is not None and study.base.random is not None:
        yield from _check_base(study, study.base, study.base.random)
    for point, path in limit_tables(study.limits).items():
        yield from _check_limit(point, path, study.response)
    if study.measurements:
        from pidpanel.measurement.from_study import mistakes_of_files

        yield from mistakes_of_files(study)
    if study.sound is not None:
        yield from _check_spectrum(study.sound, study.response, study.energy)
    yield from _check_masses(study.panel)
    # of a table with mistakes the mass is not known
    masses = {} if table_mistakes else study.damper_masses(with_rows=True)
    mistakes = list(_check_mesh(study.panel, high, masses))
    yield from mistakes
    yield from _check_layouts(study, is_meshed=not mistakes)
    if isinstance(study.panel, Structure) and study.sound is not None and not mistakes:
        yield from _check_curved(study.panel, study.sound)
    if study.optimise is not None and not mistakes:
        from pidpanel.optimise.from_study import mistakes_of_search

        yield from mistakes_of_search(study)


def _check_tables(study: Study) -> Iterator[Mistake]:
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


def _check_curved(section: Structure, sound: Sound) -> Iterator[Mistake]:
    """Yield what of the sound a curved surface does not go together with."""
    from pidpanel.geometry.plane_mesh import boundary_edges
    from pidpanel.structure.from_study import structure_of

    structure = structure_of(section)
    if structure.plane is not None:
        return
    if math.isfinite(sound.wall):
        message = "must be free or baffle; a wall is only allowed behind a flat structure"
        yield Mistake(("sound", "surroundings"), message)
    elif sound.is_free and not boundary_edges(structure.surface.cells).size:
        message = "must be baffle for a closed surface, which has no free edges"
        yield Mistake(("sound", "surroundings"), message)
    if not sound.is_free and sound.field not in ("diffuse", "uniform"):
        message = "must be diffuse or uniform for a curved surface in a baffle"
        yield Mistake(("sound", "field"), message)
    if sound.field_name == "measured":
        yield Mistake(("sound", "field"), "cross_spectra are only allowed for a flat panel")


def _check_layouts(study: Study, *, is_meshed: bool) -> Iterator[Mistake]:
    """Yield patches of one layout that fill the same cells; a blanket may lie on filled ones."""
    from pidpanel.panel.from_study import StudiedPanel
    from pidpanel.structure.from_study import structure_of

    shapes = {name: getattr(patch, "shape", None) for name, patch in study.panel.patches.items()}
    cells: Mapping[str, Index] = {}
    if None in shapes.values() and is_meshed:
        if isinstance(study.panel, Structure):
            cells = structure_of(study.panel).patches
        elif foreign := (panel := StudiedPanel(study.panel)).foreign:
            cells = foreign.panel_mesh(panel.patches, {}).patch_cells

    def share_cells(patch: str, second: str) -> bool:
        shape, second_shape = shapes[patch], shapes[second]
        if shape is None or second_shape is None:  # an element may be in several groups
            return bool(cells) and bool(np.isin(cells[patch], cells[second]).any())
        width = min(float(np.ptp(s.corners, axis=0).min()) for s in (shape, second_shape))
        return overlap(shape.corners, second_shape.corners, 1e-3 * width)

    for name, layout in study.layouts.items():
        filled = [p for p, value in layout.layout.items() if value.fill_fraction is not None]
        for patch, second in itertools.combinations(filled, 2):
            if share_cells(patch, second):
                message = f"covers cells of {patch} too; a cell has only one fill fraction"
                yield Mistake(("scenarios", name, "layout", second), message)


def _check_range(study: Study, keys: Keys, columns: Mapping[str, Array]) -> Iterator[Mistake]:
    """Yield a table with no frequency of the response, and fills beyond those of a table."""
    (low, high), frequency = study.response.frequency_hz, columns["frequency_hz"]
    if min(frequency) > high or max(frequency) < low:
        yield Mistake(keys, _outside(frequency, study.response))
    if "fill_fraction" not in columns:
        return
    emptiest, fullest = (float(f(columns["fill_fraction"])) for f in (min, max))
    for way, fill in study.fills(str(keys[1])):
        if not emptiest <= fill <= fullest:
            table = ".".join(str(key) for key in keys)
            yield Mistake(way, f"must be in the range of {table}, {emptiest:g} to {fullest:g}")


def _outside(frequency: ArrayLike, response: Response, relation: str = "all outside those") -> str:
    """Return how frequencies (n,) [Hz] lie to those of the response, and whether they are kHz."""
    low, high = response.frequency_hz
    message = f"its frequencies are {np.min(frequency):g} to {np.max(frequency):g} Hz, {relation} "
    message += f"of the response, {low:g} to {high:g} Hz"
    return f"{message}; in kHz?" if in_kilohertz(frequency, low, high) else message


def _check_spectrum(sound: Sound, response: Response, energy: Energy | None) -> Iterator[Mistake]:
    from pidpanel.sound.from_study import measured_range, stated_spectrum

    spectrum = yield from read_at(("sound", "spectrum"), lambda: stated_spectrum(sound))
    if spectrum is None:
        return
    bands = getattr(spectrum, "band_spl", np.zeros(1))  # a table of a PSD has none
    sums = f"its {spectrum.rows} sum to {spectrum.oaspl:.1f} dB"
    if not OVERALL.holds(spectrum.oaspl):
        message = f"{sums}; {OVERALL.allowed}: are they in Pa?"
        yield Mistake(("sound", "spectrum"), message)
    elif sound.oaspl_db is None:
        doubt = "far below a launch; in Pa or Pa²/Hz?" if spectrum.oaspl < QUIETEST else ""
        if spectrum.oaspl > LOUDEST or _may_be_pascals(bands):
            doubt = doubt or "not those of a launch; in Pa?"
        if doubt:
            remedy = f"sound.oaspl_db = {spectrum.oaspl:.1f} states it if it is meant"
            yield Mistake(("sound", "spectrum"), f"{sums}, {doubt} {remedy}")
    elif sound.oaspl_db > spectrum.oaspl + MOST_SHIFT and _may_be_pascals(bands):
        message = (
            f"{sums}, far below oaspl_db = {sound.oaspl_db:g}; must be levels in dB, not in Pa"
        )
        yield Mistake(("sound", "spectrum"), message)
    low, high = spectrum.reach
    if sound.field_name == "measured":
        lines = yield from read_at(("sound", "field"), lambda: measured_range(sound))
        low, high = (max(low, lines[0]), min(high, lines[1])) if lines else (low, high)
    if response.frequency_hz[0] < low or response.frequency_hz[1] > high:
        message = f"must be in the {spectrum.rows} of {sound.level_file.name}, {low:.5g} to "
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


def _check_limit(point: str, path: Path, response: Response) -> Iterator[Mistake]:
    """Yield what is wrong with the table of a limit, and one without a band of the response."""
    from pidpanel.solve.bands import third_octaves
    from pidpanel.spectra.acceleration_table import read_base_table

    keys = ("limits", point, "psd")
    limit = yield from read_at(keys, lambda: read_base_table(path))
    if limit is None:
        return
    (low, high), (lowest, highest) = response.frequency_hz, limit.frequency[[0, -1]].tolist()
    if third_octaves(max(low, lowest), max(low, min(high, highest)))[0].size == 0:
        yield Mistake(keys, _outside(limit.frequency, response, "no third octave in those"))


def _check_base(study: Study, motion: BaseMotion, random: RandomMotion) -> Iterator[Mistake]:
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
    limits, mass = motion.notching or Notching(), _mass_of(study.panel)
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


def _mass_of(panel: Panel | Structure) -> float | None:
    """Return the mass of a panel without attachments [kg]; None where its mistakes are reported."""
    from pidpanel.panel.from_study import StudiedPanel

    if isinstance(panel, Structure):
        return panel.mass_kg
    studied = StudiedPanel(panel)
    try:
        return float(studied.section.mass_per_area * studied.area.area)
    except ValueError:
        return None


def _check_masses(panel: Panel | Structure) -> Iterator[Mistake]:
    weight = _mass_of(panel)
    if weight is None:
        return
    for name, mass in panel.masses.items():
        if mass.mass_kg > MOST_CARRIED * weight:
            message = (
                f"more than {MOST_CARRIED} times the panel itself, which weighs {weight:.3g} kg"
            )
            grams = f"; {mass.mass_kg:g} g would be {mass.mass_kg / 1e3:g}"
            yield Mistake(("panel", "masses", name, "mass_kg"), message + grams)


def _check_mesh(
    panel: Panel | Structure, highest: float, damper_mass: Mapping[str, float]
) -> Iterator[Mistake]:
    from pidpanel.panel.from_study import StudiedPanel
    from pidpanel.structure.any_structure import StructureRefused
    from pidpanel.structure.from_study import mistakes_of_normals, structure_of

    if isinstance(panel, Structure):
        try:
            structure_of(panel).check(highest)
        except StructureRefused as refused:
            yield Mistake(("panel", *refused.keys), str(refused))
        else:
            yield from (mistake.prefix("panel") for mistake in mistakes_of_normals(panel))
        return
    try:
        StudiedPanel(panel).check(highest, damper_mass)
    except ValueError as error:
        for fault in getattr(error, "faults", (str(error),)):
            keys = key_path(panel, fault)
            file = getattr(panel.mesh, "file", "")
            message = fault.removeprefix("mesh: ").removeprefix(f"{file}: ")
            yield Mistake(("panel", *keys), message)


def damping_tables(study: Study) -> Iterator[tuple[tuple[str, str, str], Path]]:
    """Yield the tables of damping that a study names, with the ways to them."""
    for name, damper in study.dampers.items():
        if isinstance(damper, TableDamper | ImpedanceDamper):
            yield ("dampers", name, damper.kind), damper.file
