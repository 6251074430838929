"""Random motion of the supports: Miles' oscillator, the solver against transfer functions."""

import numpy as np
import pytest
from moving import APPARENT, DAMPING, WHITE, solved

from pidpanel.base.random import force_slopes, interface_force_psd
from pidpanel.solve.layout import DamperLayout, Load, layouts
from pidpanel.solve.lines import frequency_grid, root_mean_square
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.supports import TABLE_MASS, BaseExcitation

MASS, OWN, RATIO, LEVEL = 2.0, 50.0, 0.05, 3.0
"""Of an oscillator [kg, Hz, 1] and PSD of the acceleration of its base [(m/s²)²/Hz]."""


def oscillator(frequency, damping=0.0, mass=0.0):
    """(nf,) PSDs of absolute acceleration and force with a dashpot [N s/m] and mass [kg] on it."""
    area = 1.0
    basis = ModalBasis([OWN, 0.0], [MASS, TABLE_MASS * MASS], [RATIO, RATIO])
    patches = Patches(np.ones((1, 2, 2)), [area])
    excitation = BaseExcitation(
        lambda f: np.full(f.shape, LEVEL), np.array([-MASS, TABLE_MASS * MASS])
    )
    points = np.zeros((2, 2, 2))
    points[0] = [[1, 1], [1, 0]]
    points[1] = [[MASS, MASS], [area, area]]
    panel = ModalPanel(basis, patches, frequency, points, frequency)
    load = Load(0, lambda f, _gamma: (0 * f + damping, 0 * f + mass, f > 0), False)
    (answer,) = layouts(panel, excitation, [DamperLayout((load,) if damping or mass else ())])
    cross = answer.response.cross_psd
    force = interface_force_psd(
        frequency, cross[:, 1], answer.loads, answer.equivalent_damping, answer.apparent_mass
    )
    omega = 2 * np.pi * frequency
    return omega**4 * cross[:, 0, 0, 0].real, omega**4 * cross[:, 0, 1, 1].real, force


def test_an_oscillator_on_a_moving_base_has_its_closed_forms():
    # red: no factor 1 + (2ζr)²; force without the mass of the damper
    frequency = np.array([1.0, 20.0, 49.0, 50.0, 53.0, 120.0, 900.0])
    r = frequency / OWN
    absolute, relative, force = oscillator(frequency)
    below = (1 - r**2) ** 2 + (2 * RATIO * r) ** 2
    np.testing.assert_allclose(absolute, LEVEL * (1 + (2 * RATIO * r) ** 2) / below, rtol=1e-6)
    np.testing.assert_allclose(relative, LEVEL * r**4 / below, rtol=1e-6)
    np.testing.assert_allclose(force, MASS**2 * absolute, rtol=1e-12)


def test_a_damper_is_fixed_to_the_sky_and_its_mass_to_the_panel():
    # red: dampers on the relative motion
    frequency, C, m = np.array([3.0, 30.0, 45.0, 60.0, 400.0]), 40.0, 0.5
    omega = 2 * np.pi * frequency
    k, c = MASS * (2 * np.pi * OWN) ** 2, 2 * RATIO * MASS * 2 * np.pi * OWN
    link = k + 1j * omega * c
    ratio = link / (link - omega**2 * (MASS + m) + 1j * omega * C)
    absolute, _, force = oscillator(frequency, C, m)
    np.testing.assert_allclose(absolute, LEVEL * np.abs(ratio) ** 2, rtol=1e-6)
    whole = ((MASS + m) + C / (1j * omega)) * ratio
    np.testing.assert_allclose(force, LEVEL * np.abs(whole) ** 2, rtol=1e-6)


def test_the_rms_of_an_oscillator_is_that_of_miles():
    # red: two-sided PSDs
    frequency = frequency_grid(2e-3, 1e7, RATIO)
    absolute, _, _ = oscillator(frequency)
    exact = LEVEL * np.pi * OWN * (1 + 4 * RATIO**2) / (4 * RATIO)
    # the rule on lines even in ln f by h = ζ/4 is h²/6 high, 2.6e-5
    assert root_mean_square(frequency, absolute) ** 2 == pytest.approx(exact, rel=4e-5)


@pytest.mark.parametrize("loaded", [False, True])
def test_the_solver_agrees_with_transfer_functions(panel, loaded):
    # red: factors of the excitation without the translation
    frequency = np.array([30.0, 65.0, 130.0, 224.0, 390.0])
    modal = ModalPanel(panel.modal, panel.patches, frequency, panel.observed, frequency)
    load = Load(0, lambda f, _gamma: (0 * f + DAMPING, 0 * f + APPARENT, f > 0), False)
    (answer,) = layouts(modal, panel.excitation, [DamperLayout((load,) if loaded else ())])
    motion, force, _ = solved(panel, frequency, *((DAMPING, APPARENT) if loaded else ()))
    psd = np.einsum("fpii->fpi", answer.response.cross_psd).real
    np.testing.assert_allclose(psd, WHITE * np.abs(motion) ** 2, rtol=1e-5)
    pulled = interface_force_psd(
        frequency, answer.response.cross_psd[:, -1], answer.loads, answer.equivalent_damping,
        answer.apparent_mass,
    )  # fmt: skip
    np.testing.assert_allclose(pulled, WHITE * np.abs(force) ** 2, rtol=1e-5)


def test_the_slopes_of_the_force_are_those_of_the_solver(panel):
    # red: m_a in the place of C_e; the force without the pull of the dampers
    frequency = np.array([30.0, 65.0, 130.0, 224.0, 390.0])
    modal = ModalPanel(panel.modal, panel.patches, frequency, panel.observed, frequency)
    solver = PanelSolver(modal, panel.excitation)

    def answer(damping, mass):
        load = Load(0, lambda f, _gamma: (0 * f + damping, 0 * f + mass, f > 0), False)
        (response,) = layouts(modal, panel.excitation, [DamperLayout((load,))])
        psd = interface_force_psd(
            frequency, response.response.cross_psd[:, -1], response.loads,
            response.equivalent_damping, response.apparent_mass,
        )  # fmt: skip
        return response, psd

    response, psd = answer(DAMPING, APPARENT)
    slopes = force_slopes(solver, response, psd)
    h = 1e-3
    up, down = answer(DAMPING * np.exp(h), APPARENT)[1], answer(DAMPING * np.exp(-h), APPARENT)[1]
    np.testing.assert_allclose(slopes.of_damping[0, :, 0], np.log(up / down) / (2 * h), atol=1e-4)
    up, down = answer(DAMPING, APPARENT + h)[1], answer(DAMPING, APPARENT - h)[1]
    np.testing.assert_allclose(slopes.of_mass[0, :, 0], np.log(up / down) / (2 * h), atol=1e-4)
    assert np.abs(slopes.of_damping).max() > 0.1
