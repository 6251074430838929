"""Computed curves in the units of measured ones."""

import numpy as np
import pytest
import xarray as xr

from pidpanel.measurement.computed import computed_psd

FREQUENCY = np.array([50.0, 80.0, 125.0])
PSD = np.array([200.0, 500.0, 30.0])  # (m/s²)²/Hz
PLACE = {"scenario": "s", "point": "P"}


def curves(name, values, error_name, error, **more):
    """A response with a second point, whose values must not be taken."""
    values, error = ([column, np.full(3, 7.0)] for column in (values, error))
    dims = ("scenario", "point", "frequency")
    return xr.Dataset(
        {name: (dims, [values]), error_name: (dims, [error]), **more},
        coords={"scenario": ["s"], "point": ["P", "other"], "frequency": FREQUENCY},
    )


def under_sound(error=0.1):
    return curves("acceleration_psd", PSD, "acceleration_psd_log_error", np.full(3, error))


def test_a_psd_under_sound_is_in_g():
    computed = computed_psd(under_sound(), PLACE, over_base=False)
    np.testing.assert_array_equal(computed.frequency, FREQUENCY)
    np.testing.assert_allclose(computed.psd, PSD / 9.80665**2, rtol=1e-12)
    np.testing.assert_array_equal(computed.log_error, 0.1)


@pytest.mark.parametrize("error", [np.nan, [0.1, np.nan, 0.1]])
def test_a_psd_without_all_its_errors_has_none(error):
    assert computed_psd(under_sound(error), PLACE, over_base=False).log_error is None
    without = under_sound().drop_vars("acceleration_psd_log_error")
    assert computed_psd(without, PLACE, over_base=False).log_error is None


@pytest.mark.parametrize("values", [[np.nan] * 3, [1.0, np.inf, 2.0]])
def test_where_no_motion_is_steady_there_is_no_curve(values):
    dataset = curves("acceleration_psd", values, "acceleration_psd_log_error", np.zeros(3))
    assert computed_psd(dataset, PLACE, over_base=False) is None


def test_a_psd_over_that_of_the_supports_has_no_unit():
    source = np.array([4.0, 5.0, 6.0])
    dataset = curves(
        "absolute_acceleration_psd", PSD, "log_error", np.full(3, 0.2),
        input_psd=(("frequency",), source),
    )  # fmt: skip
    computed = computed_psd(dataset, PLACE, over_base=True)
    np.testing.assert_allclose(computed.psd, [50.0, 100.0, 5.0], rtol=1e-12)
    np.testing.assert_allclose(
        computed_psd(dataset, PLACE, over_base=False).psd, PSD / 9.80665**2, rtol=1e-12
    )


def test_a_sine_has_the_square_of_its_transmissibility_and_twice_the_error_of_its_logarithm():
    amplitude = np.array([1.0, 3.0, 0.5]) * 2.5 * 9.80665
    dataset = curves("acceleration", amplitude, "acceleration_log_error", np.full(3, 0.05))
    dataset.attrs["acceleration_g"] = 2.5
    computed = computed_psd(dataset, PLACE, over_base=True)
    np.testing.assert_allclose(computed.psd, [1.0, 9.0, 0.25], rtol=1e-12)
    np.testing.assert_allclose(computed.log_error, 0.1, rtol=1e-12)
