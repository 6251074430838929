"""Margins to limits: of flat PSDs, of rms values, and their verdicts."""

import math

import numpy as np
import pandas as pd
import pytest

from pidpanel.severity.margins import ROW, band_rows, rms_rows, with_margins
from pidpanel.severity.tables import Bursts, PointMotion
from pidpanel.spectra.break_points import BreakPoints
from tests.severity.motions import ERROR, WHERE, motion


def table(rows):
    return with_margins(pd.DataFrame(list(rows), columns=list(ROW)))


def limit(psd, low=20.0, high=500.0):
    return BreakPoints(np.array([low, high]), np.full(2, psd))


def test_the_error_of_a_margin_is_what_an_rms_larger_by_its_error_takes_from_it():
    limits = {"P": limit(0.5)}
    stated = table(band_rows(motion(0.1), limits))
    larger = table(band_rows(motion(0.1 * (1 + ERROR) ** 2), limits))
    lost = stated["margin_db"] - larger["margin_db"]
    assert len(lost) > 10
    np.testing.assert_allclose(stated["margin_error_db"], lost, rtol=1e-9)


def test_a_margin_is_that_of_flat_psds_at_points_with_limits_alone():
    limits = {"second": limit(0.4, 60.0, 300.0)}
    rows = table(band_rows(motion(0.1, points=("first", "second")), limits))
    assert set(rows["point"]) == {"second"}
    np.testing.assert_allclose(rows["margin_db"], 10 * math.log10(4), rtol=1e-9)
    np.testing.assert_allclose(rows["value"], 0.1, rtol=1e-9)
    np.testing.assert_allclose(rows["limit"], 0.4, rtol=1e-9)
    assert rows["center_hz"].between(60, 300).all() and len(rows) == 7
    still = table(band_rows(motion(0.0, points=("second",)), limits))
    assert np.isinf(still["margin_db"]).all()


def test_margins_are_of_all_bands_that_the_response_and_the_limit_share():
    lines = np.array([20.0, 60.0, 200.0, 500.0])
    moved = PointMotion(WHERE, ["P"], lines, np.full((4, 1), 0.1), np.zeros(1), Bursts.none(1))
    wide = BreakPoints(np.array([10.0, 100.0, 1000.0]), np.full(3, 0.4))
    rows = table(band_rows(moved, {"P": wide}))
    # bands whose centres 10^(n/10) lie within 20 to 500 Hz
    centres = rows["center_hz"].round(1).tolist()
    assert (centres[0], centres[-1], len(centres)) == (25.1, 398.1, 13)
    short = BreakPoints(np.array([30.0, 100.0, 300.0]), np.full(3, 0.4))
    centres = table(band_rows(moved, {"P": short}))["center_hz"].round(1).tolist()
    assert (centres[0], centres[-1]) == (31.6, 251.2)


def summary(value, error):
    """A row of ``response/summary.csv`` at P, and ones that count for nothing."""
    row = {"scenario": "A", "point": "P", "status": "ok", "acceleration_rms_g": value}
    row["acceleration_rms_error_g"] = error
    others = {"point": "Q"}, {"status": "held", "acceleration_rms_g": 0.0}, {"status": "unstable"}
    return pd.DataFrame([row, *({**row, **changed} for changed in others)])


@pytest.mark.parametrize(
    ("value", "error", "verdict"),
    [
        (20.0, 2.4, "met"),
        (20.0, 2.6, "not decided"),
        (30.0, 2.6, "not decided"),
        (30.0, 2.4, "exceeded"),
        (24.9, math.nan, "met"),
        (25.1, math.nan, "exceeded"),
        (25.001, 0.0, "met"),  # an input notched to the limit, to within rounding
    ],
)
def test_a_limit_is_decided_beyond_two_standard_errors(value, error, verdict):
    (row,) = with_margins(rms_rows(summary(value, error), {"P": 25.0})).itertuples()
    assert row.verdict == verdict
    assert row.limit / row.value == pytest.approx(1 + row.margin_of_safety)
    assert row.value * 10 ** (row.margin_db / 20) == pytest.approx(25.0)


def test_margins_of_a_flat_psd_and_of_its_rms_are_equal():
    # both are 20 lg of a ratio of amplitudes, and so are their margins of safety and errors
    bands = table(band_rows(motion(0.1), {"P": limit(0.4)}))
    (rms,) = with_margins(rms_rows(summary(7.0, ERROR * 7.0), {"P": 14.0})).itertuples()
    for column in ("margin_db", "margin_error_db", "margin_of_safety"):
        np.testing.assert_allclose(bands[column], getattr(rms, column), rtol=1e-9)
    assert set(bands["verdict"]) == {rms.verdict}
