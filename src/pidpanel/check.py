"""What can be known to be wrong before anything runs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import jinja2

from pidpanel.coupon import deck
from pidpanel.coupon.beds import shake_values
from pidpanel.coupon.cases import cases_of
from pidpanel.coupon.log import SolverMissing
from pidpanel.coupon.solver import check_installed
from pidpanel.study import CouponStudy, Study, StudyError, load_any_study
from pidpanel.study_coupon import Coupon


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
            # two seconds of imports that a coupon alone need not pay for
            from pidpanel.check_panel import check_panel

            check_panel(study)
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
