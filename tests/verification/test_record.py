"""Rows: their errors and verdicts, and the test that records one outside its tolerance."""

import math
from types import SimpleNamespace

import pandas as pd
import pytest

from tests.verification.conftest import error_of, page_of, pytest_runtest_call, verdict_of


def test_an_error_is_relative_to_the_size_of_a_reference_that_is_not_zero():
    assert error_of(99.0, 100.0) == pytest.approx(-0.01)
    assert error_of(-99.0, -100.0) == pytest.approx(0.01)
    assert error_of(-0.003, 0.0) == -0.003


def test_what_is_not_a_number_meets_no_tolerance_and_a_row_without_one_has_no_verdict():
    assert [verdict_of(error, 0.01) for error in (-0.01, 0.011, math.nan)] == [
        "met", "NOT MET", "NOT MET",
    ]  # fmt: skip
    assert verdict_of(0.5, math.nan) == ""


def row(computed, verdict, tolerance=0.05):
    return {
        "case": "Beam <1>", "quantity": "f₁", "computed": computed, "reference": 100.0,
        "unit": "Hz", "error": computed / 100 - 1, "tolerance": tolerance, "verdict": verdict,
        "method": "", "source": "Navier", "unknown": "",
    }  # fmt: skip


def test_a_row_outside_its_tolerance_fails_its_test_at_the_end_and_stands_on_the_page():
    rows = [row(101.0, "met"), row(110.0, "NOT MET"), row(120.0, "", math.nan)]
    item = SimpleNamespace(user_properties=[("row", (0, values)) for values in rows])
    call = pytest_runtest_call(item)
    next(call)
    with pytest.raises(pytest.fail.Exception) as failed:
        call.send(None)
    assert str(failed.value) == "Beam <1>, f₁: 110 Hz, reference 100, error +0.1, tolerance 0.05"
    page = page_of("Verification", pd.DataFrame(rows))
    assert "1 of 2 numbers" in page and "<h2>Beam &lt;1&gt;</h2>" in page
    assert page.count("<td>NOT MET</td>") == 1
