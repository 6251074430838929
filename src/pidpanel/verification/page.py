"""The pages of verification and validation: what is computed beside what is known or measured.

The rows of `pidpanel.verification.rows` come from any stage.
"""

import math
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path

from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.provenance import durable
from pidpanel.report.html import Page, PageSection, Paragraph, Table, render
from pidpanel.report.text import number, unit
from pidpanel.verification.experiments import UNKNOWN
from pidpanel.verification.rows import Row, read_rows


def percent(row: Row, value: float, sign: str = "") -> str:
    """Return an error or tolerance: relative in %, or in the unit where the reference is 0."""
    if row.reference:
        text = f"{100 * value:{sign}.2g}"
        if "e" in text:
            text = (sign if value > 0 else "") + number(100 * value, 2)
        text += " %"
    else:
        plus = sign if value > 0 else ""
        text = plus + number(value, 2) + (f" {row.unit}" if row.unit != "1" else "")
    return text.replace("-", "−")


def _table(caption: str, rows: Sequence[Row], *, folded: bool = False) -> Table:
    return Table(
        caption,
        ["quantity", "computed", "reference", "unit", "error", "tolerance", "verdict", "method"],
        [
            [
                row.quantity,
                number(row.computed, 4),
                number(row.reference, 4),
                unit(row.unit),
                percent(row, row.error, "+"),
                percent(row, row.tolerance) if row.has_tolerance else "–",
                ("met" if row.met else "NOT MET") if row.has_tolerance else "",
                row.method,
            ]
            for row in rows
        ],
        folded=folded,
    )


def _section(case: str, rows: Sequence[Row], index: int) -> PageSection:
    compared = [row for row in rows if row.has_tolerance]
    sources = "; ".join(dict.fromkeys(row.source for row in rows))
    tables = [_table(f"Reference: {sources}", compared)]
    extras = [row for row in rows if not row.has_tolerance]
    if extras:
        tables.append(
            _table(f"{len(extras)} more numbers, shown without a tolerance", extras, folded=True)
        )
    return PageSection(f"case-{index}", case, tables)


def _share_of_tolerance(row: Row) -> float:
    """Return |error| over the tolerance; infinite where the number is NaN, or should be exact."""
    error = abs(row.error)
    if error == 0:
        return 0.0
    return math.inf if math.isnan(error) or row.tolerance == 0 else error / row.tolerance


def _by_case(rows: Sequence[Row]) -> dict[str, list[Row]]:
    cases: dict[str, list[Row]] = {}
    for row in rows:
        cases.setdefault(row.case, []).append(row)
    return cases


def verification_page(rows: Sequence[Row], steps: Sequence[tuple[str, str]]) -> Page:
    """Return the page of all rows, in their order."""
    cases = _by_case(rows)
    overview = []
    for case, members in cases.items():
        compared = [row for row in members if row.has_tolerance]
        if not compared:
            raise ValueError(f"case '{case}': no row with a tolerance")
        worst = max(compared, key=_share_of_tolerance)
        met = sum(row.met for row in compared)
        overview.append(
            [
                case,
                f"{met} of {len(compared)}",
                "met" if met == len(compared) else "NOT MET",
                f"{worst.quantity}: {percent(worst, worst.error, '+')}, tolerance "
                f"{percent(worst, worst.tolerance)}",
            ]
        )
    missed = [row for row in rows if row.has_tolerance and not row.met]
    count = sum(row.has_tolerance for row in rows)
    summary = [
        f"{count - len(missed)} of {count} numbers agree with their reference within their "
        "tolerance."
    ]
    return Page(
        title="Verification: computed results against known references",
        facts=[("Software", f"pidpanel {version('pidpanel')}, LIGGGHTS {VERSION}")],
        summary=summary,
        warnings=[
            f"{row.case}, {row.quantity}: error {percent(row, row.error, '+')}, tolerance "
            f"{percent(row, row.tolerance)}."
            for row in missed
        ],
        claims=Table(
            "Every case with its worst number",
            ["case", "numbers met", "verdict", "worst number"],
            overview,
        ),
        sections=[_section(case, members, i) for i, (case, members) in enumerate(cases.items())],
        steps=steps,
    )


def write_verification_page(rows: Iterable[Path], file: Path) -> None:
    """Write the page of the verification from files of rows, in their order."""
    steps = [
        ("From the root of the project:", "make verification"),
        (
            "The numbers of this report are in results/verification/<stage>/<case>.csv, one "
            "row each.",
            "",
        ),
    ]
    page = verification_page([row for path in rows for row in read_rows(path)], steps)
    durable.write_text(file, render(page))


def validation_page(rows: Sequence[Row]) -> Page:
    """Return the page of experiments: measured, computed, difference, what was not known."""
    cases = _by_case(rows)
    sections = []
    for index, (case, members) in enumerate(cases.items()):
        table = Table(
            f"Measured: {members[0].source}. Computed: {members[0].method}.",
            ["quantity", "measured", "computed", "unit", "difference"],
            [
                [
                    row.quantity,
                    number(row.reference, 4),
                    number(row.computed, 4),
                    unit(row.unit),
                    "–" if math.isnan(row.error) else percent(row, row.error, "+"),
                ]
                for row in members
            ],
        )
        paragraph = Paragraph(f"Not known: {UNKNOWN[case]}")
        sections.append(PageSection(f"case-{index}", case, [paragraph, table]))
    return Page(
        title="Validation: experiments that others made",
        facts=[("Software", f"pidpanel {version('pidpanel')}, LIGGGHTS {VERSION}")],
        summary=[
            "No measurement of a honeycomb panel with particles could be had with all its inputs, "
            "so that no number here is of a whole panel.",
            f"{len(cases)} experiments on single impacts and beds are computed from their stated "
            "inputs. Nothing is fitted, and no number has a tolerance.",
        ],
        sections=sections,
        steps=[("From the root of the project:", "make validation")],
    )


def write_validation_page(rows: Iterable[Path], file: Path) -> None:
    """Write the page of the validation from files of rows, in their order."""
    page = validation_page([row for path in rows for row in read_rows(path)])
    durable.write_text(file, render(page))
