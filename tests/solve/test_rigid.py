"""A panel that can move as a rigid body: a mode at 0 Hz, without stiffness or damping of its own."""

import numpy as np
import pytest

from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches, ResponseError

FREQUENCY = np.linspace(20.0, 200.0, 9)
MASS, AREA, FORCE = 2.5, 0.04, 3.0


def heaving(ratio=0.02):
    """A mass that heaves, with a patch."""
    patch = Patches(np.full((1, 1, 1), AREA), np.array([AREA]))
    basis = ModalBasis([0.0], [MASS], ratio)
    push = np.full(FREQUENCY.size, FORCE)
    (bare,) = bare_panels(FREQUENCY, basis, [patch], [[1.0]], push, np.eye(1))
    return bare, basis, patch


@pytest.mark.parametrize(("damping", "mass"), [(0.0, 0.0), (900.0, 0.0), (900.0, 5.0)])
def test_a_rigid_panel_accelerates_as_force_over_mass_and_damper(damping, mass):
    # S_a = ω⁴ S_F / |−ω²(m + m_a A) + iω C_e A|²
    flat = np.ones((1, FREQUENCY.size))
    found = attach_dampers(heaving()[0], damping * flat, mass * flat).acceleration_psd[:, 0]
    omega = 2 * np.pi * FREQUENCY
    impedance = -(omega**2) * (MASS + mass * AREA) + 1j * omega * damping * AREA
    np.testing.assert_allclose(found, FORCE * omega**4 / np.abs(impedance) ** 2, rtol=1e-12)


def test_a_negative_frequency_is_refused():
    with pytest.raises(ResponseError, match=r"natural_frequency = .*-1\.0.* must not be negative"):
        ModalBasis([-1.0], [1.0], 0.01)
