"""C_e and m_a as numbers, and the loss factor of a patch."""

import numpy as np
import pytest

from pidpanel.damping.laws import ConstantDamper, PaperLaw
from pidpanel.damping.models import correlated_covariance

F = np.array([20.0, 77.0, 2000.0])


def test_two_numbers_hold_everywhere():
    damper = ConstantDamper(equivalent_damping=2000.0, apparent_mass=3.0)
    for fill, gamma in ((0.02, 1e-3), (np.nan, np.nan), (1.0, 1e3)):
        found = damper(F, fill, gamma)
        assert (found.equivalent_damping == 2000).all() and (found.apparent_mass == 3).all()
        assert found.inside.all() and (found.equivalent_damping_error == 0).all()
    assert not damper.depends_on_acceleration and damper.nodes is None
    assert (damper.covariance(F, 0.5, 1.0) == 0).all()


def test_a_loss_factor_is_the_energy_lost_per_cycle_over_2_pi_times_the_kinetic_energy():
    # of a sine of any amplitude: π C_e ω W² over 2π · ½ m″ (ωW)²
    damper = ConstantDamper(loss_mass=0.1 * 5.0, apparent_mass=1.0)
    amplitude, omega = 1e-4, 2 * np.pi * F
    lost = np.pi * damper(F, 0.5, 1.0).equivalent_damping * omega * amplitude**2
    kinetic = 0.5 * 5.0 * (omega * amplitude) ** 2
    np.testing.assert_allclose(lost / (2 * np.pi * kinetic), 0.1)


def test_a_damper_weighs_its_apparent_mass_unless_another_is_given():
    assert ConstantDamper(equivalent_damping=5.0).mass_per_area(0.5) == 0
    assert ConstantDamper(apparent_mass=3.0).mass_per_area(0.5) == 3
    assert ConstantDamper(apparent_mass=3.0, weight=5.0).mass_per_area(0.5) == 5
    assert ConstantDamper(apparent_mass=3.0, weight=0.0).mass_per_area(0.5) == 0
    bare = ConstantDamper(9.0, apparent_mass=3.0, apparent_mass_error=1.0).without_mass()
    assert bare.mass_per_area(0.5) == 3
    assert (bare(F, 0.5, 1.0).apparent_mass == 0).all()
    assert (bare(F, 0.5, 1.0).equivalent_damping == 9).all()
    assert bare.nodes is None


def test_its_errors_are_the_same_at_every_frequency_and_patch():
    damper = ConstantDamper(50.0, relative_error=0.1, apparent_mass=3.0, apparent_mass_error=0.5)
    np.testing.assert_allclose(damper(F, 0.5, 1.0).equivalent_damping_error, 5.0)
    covariance = damper.covariance(F, 0.5, 1.0)
    expected = np.kron(np.diag([0.01, 0.25]), np.ones((3, 3)))
    np.testing.assert_allclose(covariance, expected)
    other = damper.cross_covariance(F, (0.5, 1.0), (0.9, 7.0))
    np.testing.assert_array_equal(other, covariance)
    by_kind = ConstantDamper(5, relative_error=0.1), ConstantDamper(apparent_mass_error=1)
    for one in (damper, *by_kind):
        assert one.nodes is not None and one.nodes.shape == (1,)


def test_errors_that_go_together_have_the_largest_variance_of_a_mean():
    # against every correlation between neighbours that halves it: (σ₁ + … + σₙ)²/n²
    errors = np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.0])
    mean = np.array([1, 1, 1, 0, 0, 0]) / 3
    assert mean @ correlated_covariance(errors, errors) @ mean == pytest.approx(0.2**2)


def test_the_law_has_neither_errors_nor_mass():
    law = PaperLaw(printed=False)
    assert law.nodes is None and np.isnan(law.mass_per_area(0.5))
    assert law.covariance(F, 0.5, 1.0).tolist() == np.zeros((6, 6)).tolist()
    assert law.cross_covariance(F, (0.5, 1.0), (0.7, 2.0)).shape == (6, 6)
