"""What the surroundings change at the first modes of a panel."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad

from pidpanel.surroundings.modes import mode_accelerations

FREQUENCY, MASS, RATIO = np.array([60.0, 150.0]), np.array([1.5, 0.8]), np.array([1e-3, 2e-3])
LOAD, PRESSURE = np.array([0.3, 0.02]), 40.0  # [m⁴], [Pa²/Hz]
ADDED, RESISTANCE = np.array([0.4, 0.1]), np.array([3.0, 1.0])  # [kg], [N s/m]


class Field(SimpleNamespace):
    def spectrum(self, frequency):
        return np.full(frequency.shape, PRESSURE)

    def __call__(self, frequency):
        return np.tile(np.diag(LOAD), (frequency.size, 1, 1))


def air(frequency):
    omega = 2 * np.pi * frequency[:, None, None]
    return -(omega**2) * np.diag(ADDED) + 1j * omega * np.diag(RESISTANCE)


def peak_rms(index, added, resistance):
    """The rms velocity of an oscillator by quadrature, times its frequency in air."""
    natural = 2 * np.pi * FREQUENCY[index]
    stiffness, mass = natural**2 * MASS[index], MASS[index] + added
    damping = 2 * RATIO[index] * natural * MASS[index] + resistance
    resonance = np.sqrt(stiffness / mass)

    def square(frequency):
        omega = 2 * np.pi * frequency
        return abs(omega / (stiffness - omega**2 * mass + 1j * omega * damping)) ** 2

    middle = resonance / (2 * np.pi)
    parts = [0, 0.9 * middle, middle, 1.1 * middle, 100 * middle]
    total = sum(quad(square, *ends, limit=500)[0] for ends in itertools.pairwise(parts))
    return resonance * np.sqrt(PRESSURE * LOAD[index] * total)


@pytest.mark.parametrize("is_wet", [False, True])
def test_a_mode_alone_is_an_oscillator_in_white_noise(is_wet):
    # quadrature ends at 100 f, where 1e-5 is left
    found = mode_accelerations(FREQUENCY, MASS, RATIO, Field(), air if is_wet else None)
    expected = [
        peak_rms(index, is_wet * ADDED[index], is_wet * RESISTANCE[index]) for index in range(2)
    ]
    assert found == pytest.approx(expected, rel=1e-4)
