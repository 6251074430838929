"""The pages of verification and validation: computed values with known or measured ones.

The rows of `pidpanel.verification.rows` come from any stage.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.provenance import durable
from pidpanel.report.html import Fragment, Page, PageSection, render
from pidpanel.report.text import number
from pidpanel.verification.experiments import UNKNOWN
from pidpanel.verification.rows import Row, read_rows


def percent(row: Row, value: float, sign: str = "") -> str:
    """Return an error or tolerance: relative in %, or in the unit where the reference is 0."""
    sign = sign if value else ""
    if row.reference:
        text = f"{100 * value:{sign}.2g}"
        if "e" in text:
            text = (sign if value > 0 else "") + number(100 * value, 2)
        text += " %"
    else:
        plus = sign if value > 0 else ""
        text = plus + number(value, 2) + (f" {row.unit}" if row.unit != "1" else "")
    return text.replace("-", "−")


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


def _worst(case: str, rows: Sequence[Row]) -> dict[str, Any]:
    """Return how many numbers of a case are met, and its worst."""
    compared = [row for row in rows if row.has_tolerance]
    if not compared:
        raise ValueError(f"case '{case}': no row with a tolerance")
    return {
        "name": case,
        "met": sum(row.met for row in compared),
        "count": len(compared),
        "worst": max(compared, key=_share_of_tolerance),
    }


def verification_page(rows: Sequence[Row]) -> Page:
    """Return the page of all rows, in their order."""
    cases = _by_case(rows)
    overview = [_worst(case, members) for case, members in cases.items()]
    missed = [row for row in rows if row.has_tolerance and not row.met]
    count = sum(row.has_tolerance for row in rows)
    return Page(
        title="Verification: computed results against known references",
        facts=[("Software", f"pidpanel {version('pidpanel')}, LIGGGHTS {VERSION}")],
        summary=[
            f"{count - len(missed)} of {count} numbers agree with their reference within their "
            "tolerance."
        ],
        warnings=[
            f"{row.case}, {row.quantity}: error {percent(row, row.error, '+')}, tolerance "
            f"{percent(row, row.tolerance)}."
            for row in missed
        ],
        claims=Fragment("verification.html", {"cases": overview, "percent": percent}),
        sections=[
            PageSection(f"case-{index}", case, [Fragment("verification_case.html", values)])
            for index, (case, members) in enumerate(cases.items())
            for values in ({"rows": members, "percent": percent},)
        ],
        steps=[
            ("From the root of the project:", "make verification"),
            (
                "The numbers of this report are in results/verification/<stage>/<case>.csv, one "
                "row each.",
                "",
            ),
        ],
    )


def _experiment(case: str, rows: Sequence[Row]) -> Fragment:
    """Return an experiment: a row per quantity, with a column per way of computing all of them."""
    quantities: dict[str, dict[str, Row]] = {}
    for row in rows:
        quantity, _, variant = row.quantity.rpartition(", ")
        quantities.setdefault(quantity, {})[variant] = row
    values = {"rows": rows, "percent": percent, "unknown": UNKNOWN.get(case)}
    variants = {tuple(members) for members in quantities.values()}
    if len(quantities) > 1 and len(variants) == 1 and len(variants.pop()) > 1:
        return Fragment("validation_variants.html", {**values, "quantities": quantities})
    return Fragment("validation.html", values)


def validation_page(rows: Sequence[Row]) -> Page:
    """Return the page of experiments: measured, computed, difference, what was not known."""
    cases = _by_case(rows)
    return Page(
        title="Validation: experiments that others made",
        facts=[("Software", f"pidpanel {version('pidpanel')}, LIGGGHTS {VERSION}")],
        summary=[
            "No measurement of a honeycomb panel with particles is available with all its inputs. "
            "So no number here describes a whole panel.",
            f"The page compares {len(cases)} experiments on single impacts and beds with "
            "computations from their stated inputs. Nothing is fitted, and no number has a "
            "tolerance.",
        ],
        sections=[
            PageSection(f"case-{index}", case, [_experiment(case, members)])
            for index, (case, members) in enumerate(cases.items())
        ],
        steps=[("From the root of the project:", "make validation")],
    )


def write_page(page_of: Callable[[list[Row]], Page], rows: Iterable[Path], file: Path) -> None:
    """Write a page from files of rows, in their order."""
    page = page_of([row for path in rows for row in read_rows(path)])
    durable.write_text(file, render(page))
