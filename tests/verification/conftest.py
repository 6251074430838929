"""Rows of computed numbers and their references, and the tables that `make` writes of them."""

import html
import math
from importlib.metadata import version
from operator import itemgetter

import pandas as pd
import pytest

from pidpanel.coupon.liggghts.process import VERSION

# Mark of the tests → title of their page.
TITLES = {
    "verification": "Verification: computed values against known references",
    "validation": "Validation: experiments that others made",
}
STYLE = "body{font-family:sans-serif;margin:2em}td,th{padding:.1em .6em;text-align:left}"
ROWS = []
"""(number of the test, row) of all reports."""


def error_of(computed, reference):
    """(computed − reference)/|reference|; the computed value where the reference is 0."""
    return computed if reference == 0 else (computed - reference) / abs(reference)


def verdict_of(error, tolerance):
    """Nothing without a tolerance; what is not a number meets none."""
    if math.isnan(tolerance):
        return ""
    return "met" if abs(error) <= tolerance else "NOT MET"


@pytest.fixture
def record(request):
    """(quantity, computed, reference) → the error of a row, which the table shows.

    ``case``, ``method`` and ``source`` of the reference are texts. A test with an \\|error\\| above a
    ``tolerance`` fails at its end; a row without one is only shown.
    """
    number = request.session.items.index(request.node)

    def add(quantity, computed, reference, *, case, method, source,
            unit="1", tolerance=math.nan, unknown=""):  # fmt: skip
        error = error_of(float(computed), float(reference))
        row = {
            "case": case, "quantity": quantity, "computed": float(computed),
            "reference": float(reference), "unit": unit, "error": error, "tolerance": float(tolerance),
            "verdict": verdict_of(error, tolerance), "method": method, "source": source,
            "unknown": unknown,
        }  # fmt: skip
        request.node.user_properties.append(("row", (number, row)))
        return error

    return add


def rows_in(properties):
    return [tuple(value) for name, value in properties if name == "row"]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    result = yield
    missed = [
        "{case}, {quantity}: {computed:g} {unit}, reference {reference:g}, error {error:+.2g}, "
        "tolerance {tolerance:g}".format(**row)
        for _, row in rows_in(item.user_properties)
        if row["verdict"] == "NOT MET"
    ]
    if missed:
        pytest.fail("\n".join(missed), pytrace=False)
    return result


def pytest_runtest_logreport(report):
    if report.when == "call":
        ROWS.extend(rows_in(report.user_properties))


def pytest_sessionfinish(session):
    kind = session.config.option.markexpr
    if kind not in TITLES or not ROWS or hasattr(session.config, "workerinput"):
        return
    folder = session.config.rootpath / "results" / kind
    folder.mkdir(parents=True, exist_ok=True)
    table = pd.DataFrame([row for _, row in sorted(ROWS, key=itemgetter(0))])
    table.to_csv(folder / f"{kind}.csv", index=False, na_rep="nan", lineterminator="\n")
    (folder / f"{kind}.html").write_text(page_of(TITLES[kind], table), encoding="utf-8")


def page_of(title, table):
    """A table for each case; columns in which nothing stands are left out."""
    compared = table["verdict"] != ""
    met = f"{sum(table['verdict'] == 'met')} of {sum(compared)} numbers are within their tolerance."
    none = "Nothing is fitted, and no number has a tolerance."
    parts = [
        f"<!DOCTYPE html><meta charset='utf-8'><title>{title}</title><style>{STYLE}</style>",
        f"<h1>{title}</h1><p>pidpanel {version('pidpanel')}, LIGGGHTS {VERSION}</p>",
        f"<p>{met if compared.any() else none}</p>",
    ]
    for case, rows in table.groupby("case", sort=False):
        shown = rows.drop(columns=["case", "unknown"]).replace("", math.nan)
        parts += [f"<h2>{html.escape(case)}</h2>"]
        parts += [f"<p>Not known: {html.escape(text)}</p>" for text in set(rows["unknown"]) - {""}]
        parts += [shown.dropna(axis=1, how="all").to_html(
            index=False, border=0, na_rep="", float_format="{:.4g}".format
        )]  # fmt: skip
    return "\n".join(parts)
