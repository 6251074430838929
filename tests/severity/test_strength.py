"""Failure indices against the criteria solved for the factor of safety."""

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq

from pidpanel.severity.strength import (
    LayerStrength,
    core_index,
    maximum_stress_index,
    tsai_wu_index,
)

CARBON = LayerStrength(1500.0, 1200.0, 50.0, 200.0, 70.0)
METAL = LayerStrength(300.0, 300.0, 300.0, 300.0, 300.0 / np.sqrt(3))


def criterion(stress, ply):
    """F_i σ_i + F_ij σ_i σ_j; 1 is failure."""
    s1, s2, s12 = stress
    f1, f2 = 1 / ply.tension_1 - 1 / ply.compression_1, 1 / ply.tension_2 - 1 / ply.compression_2
    f11, f22 = 1 / (ply.tension_1 * ply.compression_1), 1 / (ply.tension_2 * ply.compression_2)
    return (
        f1 * s1
        + f2 * s2
        + f11 * s1**2
        + f22 * s2**2
        + (s12 / ply.shear) ** 2
        - np.sqrt(f11 * f22) * s1 * s2
    )


@pytest.mark.parametrize("ply", [CARBON, METAL], ids=["carbon", "metal"])
@pytest.mark.parametrize("stress", [(100.0, 5.0, 3.0), (10.0, 80.0, 20.0), (0.0, 0.0, 60.0)])
def test_stresses_over_the_index_fail_with_the_worst_signs(ply, stress):
    worst = min(
        brentq(lambda factor, s=signed: criterion(factor * s, ply) - 1, 1e-6, 1e6)
        for signs in itertools.product((1, -1), repeat=3)
        for signed in [np.multiply(signs, stress)]
    )
    assert float(tsai_wu_index(np.array(stress), ply)) == pytest.approx(1 / worst, rel=1e-9)


def test_an_isotropic_layer_follows_von_mises():
    # Tsai and Wu with equal strengths is von Mises; of the worst signs
    s1, s2, s12 = 100.0, 60.0, 40.0
    von_mises = np.sqrt(s1**2 + s2**2 + s1 * s2 + 3 * s12**2)
    assert float(tsai_wu_index(np.array([s1, s2, s12]), METAL)) == pytest.approx(von_mises / 300)


def test_no_stress_within_the_amplitudes_comes_nearer_to_failure():
    amplitude = np.array([200.0, 30.0, 25.0])
    draws = np.random.default_rng(1).uniform(-1, 1, (2000, 3)) * amplitude
    index = float(tsai_wu_index(amplitude, CARBON))
    assert max(criterion(draw / index, CARBON) for draw in draws) <= 1 + 1e-12


def test_the_maximum_stress_is_over_the_weaker_of_tension_and_compression():
    stress = np.array([[300.0, 10.0, 35.0], [-600.0, 0.0, 0.0], [0.0, 25.0, 14.0]])
    np.testing.assert_allclose(maximum_stress_index(stress, CARBON), 0.5)


def test_the_index_of_a_core_does_not_depend_on_the_signs_of_its_stresses():
    index = core_index(np.array([[-2.0, 0.3], [2.0, -0.3], [0.1, -0.6]]), (4.0, 1.0))
    np.testing.assert_allclose(index, [0.5, 0.5, 0.6])
