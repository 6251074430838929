"""Checks of a study before anything runs."""

import itertools
import math
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from pidpanel.arrays import Index
from pidpanel.check_tables import (
    check_base,
    check_damping_tables,
    check_limit,
    check_spectrum,
    mass_of,
    outside,
)
from pidpanel.columns import in_kilohertz
from pidpanel.geometry.polygon import overlap
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.document import Document, study_in
from pidpanel.study.mistakes import Mistake, read_at
from pidpanel.study.panel import MOST_CARRIED, Panel, key_path
from pidpanel.study.requirements import mistakes_of_atlas
from pidpanel.study.severity import limit_tables
from pidpanel.study.sound import Sound
from pidpanel.study.structure import Structure
from pidpanel.study.uncertain import REACH, SPECTRUM, varied


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
        mistakes += [] if mistakes else check_spreads(study)
    if mistakes:
        raise document.error(dict.fromkeys(mistakes))
    if isinstance(study, Study) and isinstance(study.panel, Structure):
        from pidpanel.structure.from_study import with_normals

        return study.model_copy(update={"panel": with_normals(study.panel)})
    return study


def check_spreads(study: Study) -> Iterator[Mistake]:
    """Yield spreads whose ends would be refused as numbers of the study."""
    for key, spread in study.uncertain.items():
        for value in () if key == SPECTRUM else (spread.value(-REACH), spread.value(REACH)):
            changed = varied(study, {key: value})
            layouts = _check_layouts(changed, is_meshed=True)
            for keys, message, *_ in (*mistakes_of_atlas(changed), *layouts):
                place = ".".join(map(str, keys))
                message = f"reaches {value:.4g} at {REACH:g} σ; {place}: {message}"
                yield Mistake(("uncertain", key, spread.kind), message)
                return


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
    table_mistakes = list(check_damping_tables(study))
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
        yield Mistake(("panel", "damping_ratio"), outside(frequency, study.response))
    if study.base is not None and study.base.random is not None:
        yield from check_base(study, study.base, study.base.random)
    for point, path in limit_tables(study.limits).items():
        yield from check_limit(point, path, study.response)
    if study.measurements:
        from pidpanel.measurement.from_study import mistakes_of_files

        yield from mistakes_of_files(study)
    if study.update is not None:
        from pidpanel.margin.update.from_study import mistakes_of_files as mistakes_of_tests

        yield from mistakes_of_tests(study)
    if study.sound is not None:
        yield from check_spectrum(study.sound, study.response, study.energy)
    yield from _check_masses(study.panel)
    # of a table with mistakes the mass is not known
    masses = {} if table_mistakes else study.damper_masses(with_rows=True)
    mistakes = list(_check_mesh(study.panel, high, masses))
    yield from mistakes
    yield from _check_layouts(study, is_meshed=not mistakes)
    if isinstance(study.panel, Structure) and study.base is not None and not mistakes:
        from pidpanel.structure.from_study import structure_of

        if fault := structure_of(study.panel).fault_of_base_motion:
            yield Mistake(("base",), f"not allowed: {fault}")
    if isinstance(study.panel, Structure) and study.sound is not None and not mistakes:
        yield from _check_curved(study.panel, study.sound)
    if study.optimise is not None and not mistakes:
        from pidpanel.optimise.from_study import mistakes_of_search

        yield from mistakes_of_search(study)


def _check_curved(section: Structure, sound: Sound) -> Iterator[Mistake]:
    """Yield what of the sound a curved surface does not go together with."""
    from pidpanel.structure.from_study import structure_of

    structure = structure_of(section)
    if structure.plane is not None:
        return
    if math.isfinite(sound.wall):
        message = "must be free or baffle; a wall is only allowed behind a flat structure"
        yield Mistake(("sound", "surroundings"), message)
    elif sound.is_free and not structure.surface.has_free_edges:
        message = "must be baffle for a surface that closes, or has three elements at an edge"
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


def _check_masses(panel: Panel | Structure) -> Iterator[Mistake]:
    weight = mass_of(panel)
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
