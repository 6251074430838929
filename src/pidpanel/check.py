"""What can be known to be wrong before anything runs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import jinja2

from pidpanel.coupon.cases import cases_of
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.output import SolverMissing
from pidpanel.coupon.liggghts.process import check_installed
from pidpanel.coupon.preparation import shake_values
from pidpanel.study import CouponStudy, Study, StudyError, load_any_study
from pidpanel.study.coupon import Coupon


def checked_study(path: str | Path) -> Study | CouponStudy:
    """Read a study and everything it names; refuse what could not be carried through.

    Raises
    ------
    StudyError
        One line: file, key, value, what is allowed.
    """
    study = load_any_study(path)
    try:
        if study.coupon is not None:
            _check_decks(study.coupon)
        if isinstance(study, Study):
            _check_panel(study)
    except ValueError as error:
        raise StudyError(f"{path}: {error}") from None
    return study


def _check_decks(coupon: Coupon) -> None:
    """Refuse a deck of the user's own that asks for what it will not be given."""
    for case in cases_of(coupon):
        path = case.point.deck
        if path is None:
            continue
        given = shake_values(case.point, restart="none")
        text = Path(path).read_text(encoding="utf-8")
        try:
            unknown = deck.undeclared(text, given)
        except jinja2.TemplateSyntaxError as error:
            raise StudyError(f"coupon.deck = {path}:{error.lineno}: {error.message}") from None
        if unknown:
            raise StudyError(
                f"coupon.deck = {path}: no variable {unknown[0]}; there are "
                f"{', '.join(sorted(given))}"
            )
        unused = sorted({"cycles_file", "steps_per_cycle"} - set(deck.undeclared(text, ())))
        if unused:
            raise StudyError(
                f"coupon.deck = {path}: {unused[0]} is not used; the deck must write one row per "
                "cycle, as templates/shake.in.j2 does"
            )


def check_machine(study: CouponStudy, results: Path) -> None:
    """Refuse a machine without LIGGGHTS, or a results folder that cannot be written.

    Raises
    ------
    StudyError
    """
    if study.coupon is not None:
        try:
            check_installed()
        except SolverMissing as error:
            raise StudyError(str(error)) from None
    try:
        results.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=results):
            pass
    except OSError as error:
        raise StudyError(
            f"{results}: cannot be written ({error.strerror}); a folder you may write to"
        ) from None


def _check_panel(study: Study) -> None:
    """Refuse a panel in sound that could not be carried through; `ValueError` says what."""
    # two seconds of imports that a study of the coupon alone does not need
    from pidpanel.damping.laws import FREQUENCY_RANGE
    from pidpanel.damping.tables import read_surface
    from pidpanel.panel.from_study import StudiedPanel
    from pidpanel.sound.table import read_spl_table

    low, high = study.response.frequency_hz
    asked = f"response.frequency_hz = [{low:g}, {high:g}]"
    edges = read_spl_table(study.sound.spectrum).edge_frequency
    if low < edges[0] or high > edges[-1]:
        raise StudyError(
            f"{asked}: within the bands of {study.sound.spectrum.name}, "
            f"{edges[0]:.5g} to {edges[-1]:.5g} Hz"
        )
    for reading in study.damping.readings:
        if reading.startswith("paper") and not (
            FREQUENCY_RANGE[0] <= low and high <= FREQUENCY_RANGE[1]
        ):
            raise StudyError(
                f"{asked}: the paper's law holds from {FREQUENCY_RANGE[0]:g} to "
                f"{FREQUENCY_RANGE[1]:g} Hz"
            )
    if study.damping.table is not None:
        read_surface(study.damping.table)
    StudiedPanel(study.panel).check(high)
