"""The neutral row: its error, its verdict, its file."""

import math
import subprocess
import sys
from pathlib import Path

import pytest

from pidpanel.verification import COLUMNS, Row, read_rows, write_rows


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
    # red: the sign of a negative reference not taken off
    assert row(99.0, 100.0).error == pytest.approx(-0.01)
    assert row(-99.0, -100.0).error == pytest.approx(0.01)


def test_where_the_truth_is_nothing_the_error_is_what_was_computed():
    assert row(-0.003, 0.0).error == -0.003
    assert row(-0.003, 0.0).met and not row(-0.03, 0.0).met


def test_a_row_without_tolerance_is_shown_and_not_held():
    assert not row(1.0, 1.0, math.nan).held and row(1.0, 1.0).held


def test_what_is_not_a_number_meets_nothing():
    # red: met as not (|error| > tolerance)
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
    assert not shown.held and math.isnan(shown.at)


def test_a_file_of_other_columns_is_named(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_text("case,quantity\nBeam,f\n")
    with pytest.raises(ValueError, match=r"rows\.csv:1: \['case', 'quantity'\]"):
        read_rows(path)
    assert "error" not in COLUMNS  # it follows from the others


def test_a_missed_number_is_named_and_fails(tmp_path):
    def verified(*rows):
        write_rows(tmp_path / "rows.csv", rows)
        workflow = Path(__file__).parents[1] / "workflow"
        return subprocess.run(
            [sys.executable, "-m", "scripts.verified", tmp_path / "said.txt", tmp_path / "rows.csv"],
            cwd=workflow, capture_output=True, text=True, check=False,
        )  # fmt: skip

    assert verified(row(100.5, 100.0), row(120.0, 100.0, math.nan)).returncode == 0
    assert (tmp_path / "said.txt").read_text() == "1 of 1 numbers within their tolerance\n"
    missed = verified(row(100.5, 100.0), row(102.0, 100.0))
    assert missed.returncode == 1
    assert "Beam, f₁: 102 Hz against 100, +2.00%, allowed 1.00%" in missed.stderr
    assert "1 of 2 numbers miss their truth" in missed.stderr
