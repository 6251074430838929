"""What maps over the panel take from the PSDs: errors of their points, dampers on fewer lines."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from pidpanel.response.mapping import _dampers, _error_of_points

KEY = ("stated", "s")


def psds(psd, error=None):
    """Of points (nf, n) on lines 2 Hz apart."""
    lines = 2.0 * np.arange(len(psd))
    names = ("reading", "scenario", "frequency", "point")
    values = {"acceleration_psd": (names, np.array(psd, float)[None, None])}
    if error is not None:
        values["acceleration_psd_log_error"] = (names, np.array(error, float)[None, None])
    return xr.Dataset(values, {"reading": ["stated"], "scenario": ["s"], "frequency": lines})


def test_the_error_is_half_of_that_of_the_mean_square_and_of_the_worst_point():
    # red: the least; without ½; a point at rest; the error without its PSD
    found = _error_of_points(psds([[1, 5, 0], [3, 5, 0]], [[0.2, 0.1, 9], [0.4, 0.1, 9]]), *KEY)
    assert found == pytest.approx((0.2 + 1.2) / (2 * 4))
    small = _error_of_points(psds([[0.1], [0.3]], [[0.2], [0.4]]), *KEY)
    assert small == pytest.approx(found)
    assert np.isnan(_error_of_points(psds([[1.0], [2.0]]), *KEY))
    assert np.isnan(_error_of_points(psds([[0.0], [0.0]], [[0.1], [0.1]]), *KEY))


def test_dampers_are_read_on_the_lines_of_the_maps():
    # red: patches of the file in their order; the bare panel with a damper
    lines, coarse = np.array([10.0, 20.0, 40.0]), np.array([15.0, 30.0])
    names = ("reading", "scenario", "frequency", "patch")
    values = np.array([[1.0, 10], [3, 20], [7, 40]])[None, None]
    psd = xr.Dataset(
        {"equivalent_damping": (names, values), "apparent_mass": (names, 2 * values)},
        {"reading": ["stated"], "scenario": ["s"], "frequency": lines, "patch": ["a", "b"]},
    )
    panel = SimpleNamespace(coarse_frequency=coarse)
    scenario = SimpleNamespace(is_bare=False, label="s", patches=("b", "a"), factor=2.5)
    damping, mass, factor = _dampers(panel, psd, "stated", scenario)
    np.testing.assert_allclose(damping, [[15, 30], [2, 5]])
    np.testing.assert_allclose(mass, 2 * damping)
    assert factor == 2.5
    bare = _dampers(panel, psd, "stated", SimpleNamespace(is_bare=True, factor=0.5))
    assert bare[0].shape == bare[1].shape == (0, 2) and bare[2] == 0.5
