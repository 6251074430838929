"""Air beside a panel: a disc that moves as one, whose impedance is known in closed form."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j1, struve

from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.sound.radiation import Air
from pidpanel.sound.wavenumber_table import WavenumberTable, chebyshev_nodes

DENSITY, SPEED, RADIUS = 1.2, 343.0, 0.5
AREA = np.pi * RADIUS**2
FREQUENCY = np.array([20.0, 109.0, 300.0, 700.0])


def over_distances(function):
    """∬ function(R) dA dA′ over a disc, by the density of the distance of two of its points."""

    def weighed(distance):
        u = distance / (2 * RADIUS)
        density = 4 * distance / (np.pi * RADIUS**2) * (np.arccos(u) - u * np.sqrt(1 - u**2))
        return density * function(distance)

    return AREA**2 * quad(weighed, 0, 2 * RADIUS, epsabs=0, epsrel=1e-11, limit=200)[0]


@pytest.fixture(scope="module")
def tables():
    """G = ∬ sin(kR)/(kR) and V = (1/2π) ∬ cos(kR)/R of the disc at Chebyshev nodes."""
    highest = 2 * np.pi * 800.0 / SPEED
    nodes = chebyshev_nodes(highest, 20)
    diffuse = [over_distances(lambda R, k=k: np.sinc(k * R / np.pi)) for k in nodes]
    volume = [over_distances(lambda R, k=k: np.cos(k * R) / R) / (2 * np.pi) for k in nodes]
    return [
        WavenumberTable(highest, nodes, np.array(values)[:, None, None])
        for values in (diffuse, volume)
    ]


def piston(frequency):
    """Z = ρcA [1 − J₁(2ka)/(ka) + i H₁(2ka)/(ka)] of a baffled piston (Rayleigh 1878)."""
    ka = 2 * np.pi * frequency / SPEED * RADIUS
    return DENSITY * SPEED * AREA * (1 - j1(2 * ka) / ka + 1j * struve(1, 2 * ka) / ka)


@pytest.mark.parametrize("sides", [1, 2])
def test_the_air_on_a_disc_is_that_of_a_baffled_piston(tables, sides):
    # iωZ for each wetted side: both signs, both parts; 20 nodes and quadrature leave 1e-9
    found = Air(DENSITY, SPEED, sides, *tables)(FREQUENCY)[:, 0, 0]
    expected = sides * 2j * np.pi * FREQUENCY * piston(FREQUENCY)
    np.testing.assert_allclose(found.real, expected.real, rtol=1e-8)
    np.testing.assert_allclose(found.imag, expected.imag, rtol=1e-8)
    # without mass the resistance is left
    light = Air(DENSITY, SPEED, sides, tables[0], None)(FREQUENCY)[:, 0, 0]
    np.testing.assert_array_equal(light, 1j * found.imag)


def test_air_weighs_on_a_slow_disc_as_8_3_rho_a_cubed(tables):
    # the added mass of a baffled piston at rest, 8ρa³/3 on each side, is carried along: the
    # stiffness falls by ω²M. At 1 Hz (ka)² = 1e-4
    (one,) = Air(DENSITY, SPEED, 2, *tables)(np.array([1.0]))[:, 0, 0]
    mass = 2 * 8 / 3 * DENSITY * RADIUS**3
    assert one.real == pytest.approx(-((2 * np.pi) ** 2) * mass, rel=1e-3)
    assert one.imag > 0


def test_air_lowers_and_widens_the_resonance_of_a_disc_on_a_spring(tables):
    # m (ω₀² − ω²) + iωZ by hand; a disc of 2 kg at 150 Hz, air on both sides
    frequency = np.linspace(100.0, 200.0, 401)
    (bare,) = bare_panels(
        frequency, ModalBasis([150.0], [2.0], 1e-3), [Patches(np.ones((0, 1, 1)), np.ones(0))],
        [[1.0]], np.ones(401), [[1.0]], Air(DENSITY, SPEED, 2, *tables),
    )  # fmt: skip
    none = np.zeros((0, 401))
    found = attach_dampers(bare, none, none).displacement_psd[:, 0]
    omega, own = 2 * np.pi * frequency, 2 * np.pi * 150.0
    stiffness = 2.0 * (own**2 - omega**2 + 2e-3j * own * omega)
    expected = np.abs(stiffness + 2j * omega * piston(frequency)) ** -2
    np.testing.assert_allclose(found, expected, rtol=1e-7)
    assert frequency[np.argmax(found)] < 140.0
