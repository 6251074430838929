"""The page of verification: what every stage computes beside what is known.

The rows of `pidpanel.verification.rows` come from any stage. Cases with a curve or a convergence to
show have a figure (`PRESENTATIONS`), all others a table alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.report import style
from pidpanel.report.html import Block, Page, PageSection, Paragraph, Picture, Table
from pidpanel.report.text import number, unit
from pidpanel.report.write import write_page
from pidpanel.verification.coupon import shaken
from pidpanel.verification.figures import (
    differences,
    floor_figure,
    slug_figure,
    spheres_text,
)
from pidpanel.verification.rows import Row, read_rows


@dataclass(frozen=True)
class Presentation:
    """What the section of a case has besides its table: an anchor, a text and a figure."""

    name: str
    text: str
    caption: str
    figure: Callable[[Sequence[Row]], Figure]


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


PRESENTATIONS = {
    shaken.SLUG: Presentation(
        "slug",
        "A perfectly inelastic body in a shaken box is collected by one wall, thrown, and "
        "collides with the other. LIGGGHTS has no perfectly inelastic sphere (it rejects e ≤ "
        f"0.05). A bed of spheres with e = {shaken.BED_RESTITUTION:g} and friction represents "
        "the body, in a narrow hexagonal cell without friction. With more spheres, less of "
        "their speed survives a landing. The gap L is the free path of their centre of mass. "
        "The spheres are hard, so that the largest overlap is 0.2 % of the amplitude; soft "
        "spheres rebound together like one spring. Beyond L = πA the body of the closed form "
        "leaves a wall at the instant at which it lands. A bed of spheres disperses there and "
        "dissipates less.",
        "Energy per cycle against the clear gap, closed form and LIGGGHTS. The maximum, 4, is at "
        "L = πA; it is the bound shown with every case of a study.",
        slug_figure,
    ),
    shaken.FLOOR: Presentation(
        "floor",
        "The same beds on a shaken floor under gravity, without a lid. The body rests on the floor "
        "until the floor falls away from it, flies, and lands without rebound. Near Γ = 3.3 it has "
        "no time to rest: the small rebound of a bed of spheres then makes it miss its next throw.",
        "Energy per cycle against the acceleration of the floor, closed form and LIGGGHTS; "
        "dissipation starts at Γ = 1.",
        floor_figure,
    ),
}
"""Cases with more than a table."""


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
    entry = PRESENTATIONS.get(case)
    blocks: list[Block] = []
    if entry:
        blocks.append(Paragraph(entry.text))
        blocks.append(Picture(entry.name, style.png(entry.figure(rows)), entry.caption))
    compared = [row for row in rows if row.has_tolerance]
    sources = "; ".join(dict.fromkeys(row.source for row in rows))
    blocks.append(_table(f"Reference: {sources}", compared))
    extras = [row for row in rows if not row.has_tolerance]
    if extras:
        blocks.append(
            _table(f"{len(extras)} more numbers, shown without a tolerance", extras, folded=True)
        )
    return PageSection(entry.name if entry else f"case-{index}", case, blocks)


def _share_of_tolerance(row: Row) -> float:
    """Return |error| over the tolerance; infinite where the number is NaN, or should be exact."""
    error = abs(row.error)
    if error == 0:
        return 0.0
    return math.inf if math.isnan(error) or row.tolerance == 0 else error / row.tolerance


def verification_page(rows: Sequence[Row], steps: Sequence[tuple[str, str]]) -> Page:
    """Return the page of all rows, in their order; call it within `style.context`."""
    cases: dict[str, list[Row]] = {}
    for row in rows:
        cases.setdefault(row.case, []).append(row)
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
    for case in (shaken.SLUG, shaken.FLOOR):
        if case in cases:
            errors = ", ".join(
                f"{number(float(np.mean(values)), 2)} with {spheres_text(size)}"
                for size, values in differences(cases[case]).items()
            )
            summary.append(f"{case}: mean difference in E/(m A²ω²) {errors}.")
    return Page(
        title="Verification: computed results against known references",
        facts=[
            ("Software", f"pidpanel {version('pidpanel')}, LIGGGHTS {VERSION}"),
        ],
        assumptions=[],
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


def write_verification_page(rows: Iterable[Path], file: Path, figures: Path) -> None:
    """Write the page and the figures of the verification from files of rows, in their order."""
    steps = [
        ("From the root of the project:", "make verification"),
        (
            "The numbers of this report are in results/verification/<stage>/<case>.csv, one "
            "row each; figures are in results/verification/figures/.",
            "",
        ),
    ]
    with style.context():
        page = verification_page([row for path in rows for row in read_rows(path)], steps)
    write_page(page, file, figures)
