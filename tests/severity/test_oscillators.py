"""Vibration response spectra against pyYeti, and Miles' equation where it is exact."""

import numpy as np
import pytest
import scipy.integrate

from pidpanel.severity.oscillators import miles, response_spectrum

BREAKS, LEVELS = [20, 80, 500, 2000], [0.01, 0.04, 0.04, 0.01]
NATURAL = np.array([25.0, 50.0, 100.0, 300.0, 800.0, 1500.0])
PYYETI = {
    10: [2.12926, 4.36019, 7.82033, 13.72191, 18.17575, 18.46352],
    50: [4.91085, 9.86747, 17.66298, 30.67257, 39.81830, 39.95102],
}
"""`pyyeti.srs.vrs` 1.4.7 of this spectrum with lines 0.02 Hz apart, linear between them [g rms]."""


def spectrum(frequency):
    return np.exp(np.interp(np.log(frequency), np.log(BREAKS), np.log(LEVELS)))


@pytest.mark.parametrize("quality", PYYETI)
def test_spectra_are_those_of_pyyeti(quality):
    frequency = np.geomspace(20, 2000, 800)
    psd = np.stack([spectrum(frequency), 4 * spectrum(frequency)], axis=1)
    rms = response_spectrum(frequency, psd, NATURAL, quality)
    np.testing.assert_allclose(rms[:, 0], PYYETI[quality], rtol=2e-4)
    np.testing.assert_allclose(rms[:, 1], 2 * rms[:, 0])


@pytest.mark.parametrize("quality", [5.0, 25.0])
def test_miles_equation_holds_for_a_flat_psd(quality):
    # its exact form has 1 + 1/Q²
    frequency = np.array([0.01, 1e4])
    psd = np.full((2, 1), 0.02)
    natural = np.array([50.0, 100.0])
    exact = miles(frequency, psd, natural, quality) * np.sqrt(1 + 1 / quality**2)
    np.testing.assert_allclose(
        response_spectrum(
            np.linspace(0.01, 1e4, 20001), np.full((20001, 1), 0.02), natural, quality
        ),
        exact,
        rtol=3e-3,  # what lies above 10 kHz
    )


@pytest.mark.parametrize("frequency", [[80.0, 120.0, 120.1], [79.9, 80.0, 120.0]])
def test_a_resonance_between_two_lines_is_resolved(frequency):
    # by quadrature of the complex transfer function
    # in the last, or at the natural frequency
    def square(f):
        r = f / 100
        return abs((1 + 1j * r / 50) / (1 - r**2 + 1j * r / 50)) ** 2

    exact, _ = scipy.integrate.quad(square, frequency[0], frequency[-1], points=[98, 100, 102])
    rms = response_spectrum(np.array(frequency), np.ones((3, 1)), np.array([100.0]), 50.0)
    assert rms**2 == pytest.approx(exact, rel=2e-3)


def test_a_heavily_damped_oscillator_needs_lines_far_above_its_own():
    def square(f):
        r = f / 100
        return abs((1 + 1j * r / 0.3) / (1 - r**2 + 1j * r / 0.3)) ** 2

    exact, _ = scipy.integrate.quad(square, 5.0, 1400.0, points=[50, 100, 300])
    rms = response_spectrum(np.array([5.0, 1400.0]), np.ones((2, 1)), np.array([100.0]), 0.3)
    assert rms**2 == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("shift", [-3, -1, 0, 1, 3])
def test_miles_equation_at_a_step_has_the_mean_of_both_sides(shift):
    edge = 10**2.05
    frequency = np.array([20.0, np.nextafter(edge, 0), edge, 2000.0])
    psd = np.array([[3.0], [3.0], [1.0], [1.0]])
    natural = np.array([edge * (1 + shift * 2.3e-16), 50.0, 500.0])
    expected = np.sqrt(np.pi / 2 * 10 * natural * [2.0, 3.0, 1.0])
    np.testing.assert_allclose(miles(frequency, psd, natural, 10.0)[:, 0], expected, rtol=1e-8)
