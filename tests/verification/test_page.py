"""The page of verification: what it says of rows that hold, that do not, and of no tolerance."""

import math

import pytest

from pidpanel.report import html
from pidpanel.verification import page as verification_page
from pidpanel.verification.rows import COMPARISONS, Row
from tests.page_reader import blocks_of


def row(case, computed, reference, tolerance=math.nan, at=math.nan, resolution=math.nan, unit="1"):
    common = Row(case=case, unit=unit, tolerance=tolerance, method="with care", source="a book")
    return common.row(f"x at {at:g}", computed, reference, at, resolution)


@pytest.fixture(scope="module")
def rows():
    return [
        row(COMPARISONS["collision"]["case"], 0.91, 0.9, 0.02, 0.3, 0.1),
        row("Panel of Navier", 44.99, 45.0, 1e-3, unit="Hz"),
    ]


def told(rows):
    return verification_page.verification_page(rows)


def worst(page):
    """The last row of the cases with their worst numbers."""
    return blocks_of(page.claims)[0].rows[-1]


def test_a_number_beyond_its_tolerance_is_told_at_the_top_and_in_its_row(rows):
    good, bad = told(rows), told([*rows, row("Beam", 1.1, 1.0, 0.05, at=3.0)])
    assert good.warnings == [] and "NOT MET" not in html.render(good)
    assert bad.warnings == ["Beam, x at 3: error +10 %, tolerance 5 %."]
    assert worst(bad) == ["Beam", "0 of 1", "NOT MET", "x at 3: +10 %, tolerance 5 %"]
    assert bad.summary[0].startswith(
        f"{sum(r.has_tolerance for r in rows)} of {sum(r.has_tolerance for r in rows) + 1}"
    )


def test_a_number_that_is_none_is_the_worst_of_all(rows):
    page = told(
        [*rows, row("Beam", 1.01, 1.0, 0.05, at=1.0), row("Beam", math.nan, 1.0, 0.05, at=2.0)]
    )
    assert worst(page)[1:3] == ["1 of 2", "NOT MET"]
    assert worst(page)[3].startswith("x at 2")


def test_a_case_that_nothing_holds_is_refused():
    with pytest.raises(ValueError, match="case 'Beam': no row with a tolerance"):
        told([row("Beam", 1.0, 1.0)])
