"""Third octaves add up to the whole."""

import numpy as np
import pytest

from pidpanel.solve import bands


def test_bands_that_adjoin_add_up_to_the_whole():
    frequency = np.geomspace(50, 3000, 1500)
    psd = 1 / ((frequency / 400) ** 2 - 1 + 0.02j * frequency / 400)
    psd = np.abs(psd) ** 2
    _, edge = bands.third_octaves(100, 2000)
    edge[0, 0], edge[-1, 1] = frequency[0], frequency[-1]
    whole = np.trapezoid(psd, frequency)
    # linear interpolation at the edges: no other rule lies behind both sides
    assert np.sum(bands.band_rms(frequency, psd, edge) ** 2) == pytest.approx(whole, rel=1e-12)


def test_white_noise_fills_each_band_with_its_width():
    frequency = np.linspace(10, 5000, 900)
    _, edge = bands.third_octaves(100, 2000)
    rms = bands.band_rms(frequency, np.full((900, 2), 4.0), edge)
    assert rms.shape == (len(edge), 2)
    assert rms[:, 1] ** 2 == pytest.approx(4 * np.diff(edge)[:, 0], rel=1e-12)


def test_a_range_holds_the_bands_whose_centres_lie_in_it():
    centre, edge = bands.third_octaves(30, 2000)
    assert centre[[0, -1]].round(1).tolist() == [31.6, 1995.3]
    assert edge[0, 0] == 30 and edge[-1, 1] == 2000
    assert edge[1:, 0] == pytest.approx(edge[:-1, 1])


def test_half_the_rms_is_six_decibels():
    assert bands.reduction(2.0, 1.0) == pytest.approx(6.0206, abs=1e-4)


def test_a_centre_at_either_end_of_the_range_belongs_to_it():
    # lg of 10^(N/10) is off by rounding
    centre, _ = bands.third_octaves(10**2.1, 10**2.9)
    np.testing.assert_allclose(centre, 10 ** (np.arange(21, 30) / 10))
