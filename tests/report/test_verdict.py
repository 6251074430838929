"""How far a reading is from the coupled run."""

import numpy as np
import pytest

from pidpanel.report.verdict_files import BAND_LIMIT, RMS_LIMIT, CoupledRun, distance

BANDS = np.array([5.0, 8.0, 3.0, 0.7])


def run(rms_error=0.0, band_error=0.0):
    return CoupledRun(10.0, rms_error, BANDS, np.full(4, band_error))


def shifted(db, band):
    return BANDS * np.where(np.arange(4) == band, 10 ** (db / 20), 1.0)


@pytest.mark.parametrize(
    ("rms", "band_db", "holds"),
    [(10.0, 0.0, "yes"), (10.0 * (1 + 1.01 * 0.03), 0.0, "no"), (10.0, -0.51, "no"),
     (10.0 * (1 - 0.99 * 0.03), 0.49, "yes")],
)  # fmt: skip
def test_both_limits_hold_of_an_exact_run(rms, band_db, holds):
    assert RMS_LIMIT == 0.03
    found = distance(rms, shifted(band_db, 2), run())
    assert found.holds == holds
    assert found.difference == pytest.approx(rms / 10.0 - 1, abs=1e-12)
    assert found.band_difference_db == pytest.approx(band_db, abs=1e-12)
    assert found.band == (2 if band_db else 0)


def test_a_band_far_below_the_highest_does_not_count():
    assert 20 * np.log10(BANDS.max() / BANDS[3]) > 20
    assert distance(10.0, shifted(9.0, 3), run()).holds == "yes"
    assert distance(10.0, shifted(9.0, 2), run()).holds == "no"


@pytest.mark.parametrize(("depth", "holds"), [(19.9, "no"), (20.1, "yes")])
def test_a_band_counts_to_twenty_decibels_below_the_highest(depth, holds):
    bands = np.array([1.0, 10 ** (-depth / 20)])
    coupled = CoupledRun(10.0, 0.0, bands, np.zeros(2))
    assert distance(10.0, bands * [1.0, 2.0], coupled).holds == holds


@pytest.mark.parametrize(("off", "holds"), [(0.29, "yes"), (0.31, "open"), (0.69, "open"), (0.71, "no")])  # fmt: skip
def test_an_error_of_the_run_leaves_open_what_it_could_decide(off, holds):
    assert BAND_LIMIT == 0.5  # ± 2 · 0.1 dB
    assert distance(10.0, shifted(off, 1), run(band_error=0.1)).holds == holds


def test_no_weighs_more_than_open():
    assert distance(12.0, BANDS, run(band_error=0.3)).holds == "no"


def test_the_error_of_a_run_is_relative_to_its_rms():
    assert distance(10.0, BANDS, run(rms_error=0.2)).coupled_g_rms_relative_error == pytest.approx(
        0.02
    )
