"""What a row says is the response in the unit of its column; errors of dampers of any size."""

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response import tables
from pidpanel.solve import uncertainty
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.model import PanelResponse

FLAT = np.linspace(100.0, 104.0, 5)


def flat(displacement_psd, inside):
    """A response with one displacement PSD at 100 to 104 Hz, at two points."""
    psd = np.full((5, 2, 1, 1), displacement_psd + 0j)
    zero, loads = np.zeros((1, 5)), np.array([0])
    read, motion, cells = np.array([3.0]), np.array([4.0]), np.full((1, 2), np.nan)
    return LayoutResponse(
        PanelResponse(FLAT, psd), loads, read, motion, cells, motion, zero, zero, inside[None], 1
    )


BARE = flat(4e-12, np.ones(5, bool))
FOUND = flat(1e-12, np.array([True, True, True, True, False]))


def test_a_row_holds_the_response_in_the_units_of_its_columns():
    # w_rms = √(1e-12 · 4) = 2 µm; a by ω⁴ and v by ω² in trapezoids of 1 Hz
    omega = 2 * np.pi * FLAT
    expected = {
        "displacement_rms_mm": 2e-3,
        "velocity_rms_m_s": np.sqrt(np.trapezoid(omega**2 * 1e-12, FLAT)),
        "acceleration_rms_g": np.sqrt(np.trapezoid(omega**4 * 1e-12, FLAT)) / STANDARD_GRAVITY,
        "reduction_db": 20 * np.log10(2),
        "diagonal_form_error_db": -20 * np.log10(2),
        "outside_run_points_share": 0.2,
        "damping_read_at_g": 3.0,
        "patch_motion_g": 4.0,
    }
    columns = tables.summary_columns(
        FOUND, BARE, thickness=0.02, power_balance_error=0.0, full=BARE.response,
        read_at_g=3.0, patch_motion_g=4.0,
    )  # fmt: skip
    for name, value in expected.items():
        np.testing.assert_allclose(columns[name], value, rtol=1e-12, err_msg=name)


@pytest.mark.parametrize(("thickness", "beyond"), [(1.95e-5, True), (2.05e-5, False)])
def test_a_deflection_above_a_tenth_of_the_thickness_is_beyond_the_linear_plate(thickness, beyond):
    # w_rms = 2 µm
    columns = tables.summary_columns(
        FOUND, BARE, thickness=thickness, power_balance_error=0.0, full=BARE.response,
        read_at_g=3.0, patch_motion_g=4.0,
    )  # fmt: skip
    assert columns["beyond_linear_plate"].tolist() == [beyond] * 2


def test_stress_is_told_in_mpa_and_strain_in_microstrain_with_three_sigma():
    # flat PSDs over 4 Hz
    psd = np.broadcast_to([4e-12, 1e12], (5, 1, 2))
    strain, stress = tables.stress_rows(FLAT, psd, {"strain_xx": "1", "von_mises": "Pa"}, ["a"])
    assert (strain["unit"], stress["unit"]) == ("microstrain", "MPa")
    assert (strain["rms"], strain["three_sigma"]) == pytest.approx((4.0, 12.0))
    assert (stress["rms"], stress["three_sigma"]) == pytest.approx((2.0, 6.0))


# ------------------------------------------------------------------------ uncertainty


def test_the_error_of_a_stress_is_half_that_of_its_mean_square():
    frequency = np.linspace(10.0, 110.0, 101)
    psd = np.array([[[4.0, 0.0]]]) * np.ones((101, 1, 1))
    log_error = np.where(frequency < 60, 0.3, 0.1)[:, None]
    rows = tables.stress_rows(frequency, psd, {"sigma": "Pa", "tau": "Pa"}, ["A"], log_error)
    assert [row["relative_error"] for row in rows] == pytest.approx([0.1, 0.0], abs=1e-3)
    assert rows[0]["three_sigma"] == pytest.approx(3 * rows[0]["rms"])
    assert rows[0]["rms"] == pytest.approx(20 / 1e6 if rows[0]["unit"] == "MPa" else 20)


def test_rows_without_errors_say_so():
    row = {"acceleration_rms_g": 3.0, "damping_read_at_g": np.nan}
    got = tables.error_columns(row, None)
    assert np.isnan(got["acceleration_rms_error_g"]) and np.isnan(got["reduction_error_db"])


def test_the_error_of_a_reduction_is_that_of_the_rms_in_decibels():
    row = {"acceleration_rms_g": 3.0, "damping_read_at_g": 50.0}
    errors = uncertainty.StandardErrors(np.zeros((1, 1)), np.array([0.02]), np.array([0.1]))
    got = tables.error_columns(row, errors)
    assert got["acceleration_rms_error_g"] == pytest.approx(0.06)
    # 20 lg 1.02 = 0.172 to first order 0.1737
    assert got["reduction_error_db"] == pytest.approx(0.1737, rel=1e-3)
    assert got["damping_read_at_error_g"] == pytest.approx(5.0)
