"""The neutral row: its error, its verdict, its file."""

import math

import pytest

from pidpanel.verification.rows import (
    COLUMNS,
    Row,
    ToleranceMissedError,
    confirm,
    read_rows,
    verify,
    write_rows,
)
from tests.jobs import call


def row(computed, reference, tolerance=0.01, **more):
    values = {
        "case": "Beam",
        "quantity": "f₁",
        "unit": "Hz",
        "method": "30 × 20 elements",
        "source": "Navier",
    }
    return Row(computed=computed, reference=reference, tolerance=tolerance, **values, **more)


def test_an_error_is_relative_to_the_size_of_the_reference():
    assert row(99.0, 100.0).error == pytest.approx(-0.01)
    assert row(-99.0, -100.0).error == pytest.approx(0.01)


def test_where_the_truth_is_nothing_the_error_is_what_was_computed():
    assert row(-0.003, 0.0).error == -0.003
    assert row(-0.003, 0.0).met and not row(-0.03, 0.0).met


def test_a_row_without_tolerance_is_shown_and_not_held():
    assert not row(1.0, 1.0, math.nan).has_tolerance and row(1.0, 1.0).has_tolerance


def test_what_is_not_a_number_meets_nothing():
    assert not row(math.nan, 1.0).met


def test_rows_come_back_from_their_file_as_they_were(tmp_path):
    rows = [
        row(0.1 + 0.2, 0.3, at=1.0, resolution=48.0),
        row(1e-300, 0.0, tolerance=1.0, at=2.0, resolution=1.0),
    ]
    write_rows(tmp_path / "rows.csv", rows)
    assert read_rows(tmp_path / "rows.csv") == rows
    write_rows(tmp_path / "shown.csv", [row(1.0, 1.0, math.nan)])
    (shown,) = read_rows(tmp_path / "shown.csv")
    assert not shown.has_tolerance and math.isnan(shown.at)


def test_a_file_of_other_columns_is_named(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_text("case,quantity\nBeam,f\n")
    with pytest.raises(ValueError, match=r"rows\.csv:1: columns \['case', 'quantity'\]"):
        read_rows(path)
    assert "error" not in COLUMNS  # it follows from the others


def test_numbers_within_their_tolerance_are_counted_and_rows_without_one_are_not():
    rows = [row(100.5, 100.0), row(120.0, 100.0, math.nan)]
    assert confirm(rows) == "1 of 1 numbers within their tolerance"


def test_a_missed_number_is_named_and_refused():
    rows = [row(100.5, 100.0), row(102.0, 100.0), row(97.0, 100.0), row(1.0, 9.0, math.nan)]
    with pytest.raises(ToleranceMissedError) as missed:
        confirm(rows)
    assert str(missed.value).splitlines() == [
        "Beam, f₁: 102 Hz, reference 100, error +2.00%, tolerance 1.00%",
        "Beam, f₁: 97 Hz, reference 100, error -3.00%, tolerance 1.00%",
        "2 of 3 numbers miss their tolerance",
    ]


def test_a_missed_number_ends_the_script_and_leaves_no_file(tmp_path):
    write_rows(tmp_path / "rows.csv", [row(102.0, 100.0)])
    files = {"rows": [tmp_path / "rows.csv"]}, {"verdict": tmp_path / "verified.txt"}
    with pytest.raises(ToleranceMissedError, match="1 of 1 numbers miss their tolerance"):
        call("verified", "", *files)
    assert not (tmp_path / "verified.txt").exists()


def test_a_case_that_a_stage_does_not_have_is_refused_with_those_that_it_has():
    with pytest.raises(ValueError, match=r"drum: not a verification case of sound: .*field"):
        verify("sound", "drum")
