"""What can be known to be wrong before anything runs."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

import jinja2

from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.failures import DeckRefused, SolverMissing
from pidpanel.coupon.liggghts.process import check_installed
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.base import OVERALL
from pidpanel.study.document import Document
from pidpanel.study.mistakes import Keys, Mistake
from pidpanel.study.panel import named_place
from pidpanel.study.reading import study_in


def checked_study(path: str | Path) -> Study | CouponStudy:
    """Read a study and everything it names; refuse what could not be computed.

    Raises
    ------
    StudyError
        One line for each mistake: file, line, key, value, what is wrong or what is allowed.
    """
    document = Document(Path(path))
    study = study_in(document)
    mistakes = [one for name in study.coupons for one in check_decks(study, name)]
    if isinstance(study, Study):
        mistakes += check_panel(study)
    if mistakes:
        raise document.error(dict.fromkeys(mistakes))
    return study


def check_machine(study: CouponStudy, results: Path) -> None:
    """Refuse a machine without LIGGGHTS, or a results folder that is not writable.

    Raises
    ------
    StudyError
    """
    if study.coupons:
        try:
            check_installed()
        except SolverMissing as error:
            raise StudyError(str(error)) from None
    try:
        results.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=results):
            pass
    except OSError as error:
        raise StudyError(f"{results}: must be a writable folder ({error.strerror})") from None


def check_decks(study: CouponStudy, name: str) -> Iterator[Mistake]:
    """Yield the mistakes of a coupon's own decks: variables that are unknown or not used."""
    coupon = study.coupons[name]
    way = ("coupon",) if coupon is study.coupon else ("dampers", name, "coupon")
    for case in cases_of(coupon):
        path = case.point.deck
        if path is None:
            continue
        # a varied deck is one of a list
        varied = [str(one) for one in coupon.vary.get("deck", ())]
        keys = (*way, *(("vary", "deck", varied.index(path)) if varied else ("deck",)))
        given = case.point.deck_values(restart="none")
        text = Path(path).read_text(encoding="utf-8")
        try:
            unknown = deck.undeclared(text, given)
        except jinja2.TemplateSyntaxError as error:
            yield Mistake(keys, f"{path}:{error.lineno}: {error.message}")
            continue
        if not unknown:
            try:
                case.point.deck_text()
            except DeckRefused as error:
                yield Mistake(keys, f"{error}; --trust-deck allows it")
            except Exception as error:  # whatever a template of somebody else computes
                yield Mistake(keys, f"{path}: {type(error).__name__}: {error}")
        for name in unknown:
            yield Mistake(keys, f"unknown variable {name}; allowed are {', '.join(sorted(given))}")
        for name in sorted({"cycles_file", "steps_per_cycle"} - set(deck.undeclared(text, ()))):
            yield Mistake(
                keys,
                f"must use the variable {name}; a deck writes one row per cycle, as "
                "templates/shake.in.j2 does",
            )


def check_panel(study: Study) -> Iterator[Mistake]:
    """Yield what of a panel in its sound could not be computed."""
    # two seconds of imports that a study of the coupon alone does not need
    from pidpanel.damping.from_study import read_table
    from pidpanel.damping.laws import FREQUENCY_RANGE
    from pidpanel.damping.table_files import TableError
    from pidpanel.panel.from_study import StudiedPanel
    from pidpanel.response.lines import LINES_AT_MOST, line_count, smallest_damping_ratio
    from pidpanel.sound.table import SpectrumTableError, read_spl_table

    low, high = study.response.frequency_hz
    try:
        spectrum = read_spl_table(study.sound.spectrum)
    except SpectrumTableError as error:
        yield from (Mistake(("sound", "spectrum"), fault) for fault in error.faults)
    else:
        says = OVERALL.refuses(spectrum.oaspl)
        if says:
            yield Mistake(
                ("sound", "spectrum"),
                f"its bands sum to {spectrum.oaspl:.1f} dB; {says.partition(';')[0]}: are they in Pa?",
            )
        edges = spectrum.edge_frequency
        if low < edges[0] or high > edges[-1]:
            yield Mistake(
                ("response", "frequency_hz"),
                f"must be in the bands of {study.sound.spectrum.name}, "
                f"{edges[0]:.5g} to {edges[-1]:.5g} Hz",
            )
    outside_law = not (FREQUENCY_RANGE[0] <= low and high <= FREQUENCY_RANGE[1])
    laws = [name for name in study.used_dampers if study.all_dampers[name].law is not None]
    if outside_law and (laws or any(name.startswith("paper") for name in study.readings)):
        yield Mistake(
            ("response", "frequency_hz"),
            f"must be in the range of the paper's law, {FREQUENCY_RANGE[0]:g} to "
            f"{FREQUENCY_RANGE[1]:g} Hz",
        )
    for keys, table in _tables(study):
        try:
            read_table(table, impedance=keys[-1] == "impedance")
        except TableError as error:
            yield from (Mistake(keys, fault) for fault in error.faults)
    lines = line_count(low, high, study.panel.damping_ratio)
    if lines > LINES_AT_MOST:
        least = smallest_damping_ratio(low, high)
        figures = 2 - math.floor(math.log10(least))
        least = math.ceil(least * 10**figures) / 10**figures
        yield Mistake(
            ("panel", "damping_ratio"),
            f"its resonances take {lines} frequency lines from {low:g} to {high:g} Hz; allowed"
            f" are {LINES_AT_MOST}, for ratios from {least:g}",
        )
    try:
        StudiedPanel(study.panel).check(high)
    except ValueError as error:
        for fault in getattr(error, "faults", (str(error),)):
            keys = named_place(study.panel, fault)
            says = fault.removeprefix("mesh: ").removeprefix(f"{study.panel.mesh.file}: ")
            yield Mistake(("panel", *keys), says)


def _tables(study: Study) -> Iterator[tuple[Keys, Path]]:
    """Yield the tables of damping that a study names, with the ways to them."""
    if study.damping.table is not None:
        yield ("damping", "table"), study.damping.table
    for name, damper in study.dampers.items():
        if damper.table is not None:
            yield ("dampers", name, "table"), damper.table
        if damper.impedance is not None:
            yield ("dampers", name, "impedance"), damper.impedance
