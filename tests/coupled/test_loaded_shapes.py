"""Oscillators of a panel with what is not integrated, against closed forms."""

import numpy as np
import pytest

from pidpanel.coupled.excited_panel import loaded_shapes
from pidpanel.solve.model import ModalBasis

NATURAL, MASS = np.array([50.0, 120.0, 300.0]), np.array([1.5, 1.5, 2.0])
PANEL = ModalBasis(NATURAL, MASS, 0.01)
PER_AREA = 4.0
WHOLE = np.diag(MASS) / PER_AREA
EXTENT = (20.0, 1000.0)


def damper(overlap, damping, mass):
    def stiffness(frequency):
        omega = 2 * np.pi * frequency[:, None, None]
        return (1j * omega * damping - omega**2 * mass) * overlap

    return stiffness


def test_a_damper_on_the_whole_panel_lowers_all_frequencies_alike():
    found = loaded_shapes(PANEL, EXTENT, damper(WHOLE, 30.0, 2.0))
    ratio = np.sqrt(PER_AREA / (PER_AREA + 2.0))
    np.testing.assert_allclose(found.modal.natural_frequency, NATURAL * ratio, rtol=1e-12)
    # c/m of the panel, of its mass with the damper
    wanted = (2 * 0.01 * 2 * np.pi * NATURAL * PER_AREA + 30.0) / (PER_AREA + 2.0)
    have = 2 * found.modal.damping_ratio * found.modal.angular_frequency
    np.testing.assert_allclose(have, wanted, rtol=1e-12)


def test_the_new_shapes_have_the_response_of_the_whole_matrices():
    row = np.array([0.8, -0.5, 0.3])
    overlap, heavy = 0.05 * np.outer(row, row), 8.0
    found = loaded_shapes(PANEL, EXTENT, damper(overlap, 0.0, heavy))
    frequency, point = np.array([47.0, 111.0, 290.0]), np.array([[1.0, 0.6, -0.9]])
    seen = found.shape(point)
    for f in frequency:
        omega = 2 * np.pi * f
        stiffness = np.diag(PANEL.dynamic_stiffness(np.array([f]))[0]) - omega**2 * heavy * overlap
        whole = (point @ np.linalg.solve(stiffness, point.T))[0, 0]
        own = (seen**2 / found.modal.dynamic_stiffness(np.array([f]))).sum()
        # the damping of the bare panel counts with its diagonal
        assert abs(own - whole) < 0.02 * abs(whole)
    square = found.square(np.diag(1 / MASS))
    assert np.allclose(square, square.T)


def test_the_mass_of_the_air_makes_new_shapes():
    mass = 0.5 * (np.eye(3) + 0.4)

    def air(frequency):
        return -((2 * np.pi * frequency[:, None, None]) ** 2) * mass + 0j

    found = loaded_shapes(PANEL, EXTENT, air)
    square = np.linalg.eigvals(
        np.linalg.solve(np.diag(MASS) + mass, np.diag(MASS * (2 * np.pi * NATURAL) ** 2))
    )
    expected = np.sqrt(np.sort(square.real)) / (2 * np.pi)
    np.testing.assert_allclose(found.modal.natural_frequency, expected, rtol=1e-12)


def test_the_air_is_that_at_the_frequency_of_each_shape():
    # held beyond the range
    modal = ModalBasis([10.0, 50.0, 120.0, 3000.0], np.ones(4), 0.01)

    def resistance(frequency):
        return 5.0 + 2.0 * np.log(np.clip(frequency, *EXTENT))

    def air(frequency):
        return 1j * (2 * np.pi * frequency * resistance(frequency))[:, None, None] * np.eye(4)

    found = loaded_shapes(modal, EXTENT, air).modal
    wanted = modal.damping + resistance(modal.natural_frequency)
    np.testing.assert_allclose(found.damping, wanted, rtol=1e-12)


def test_a_slow_oscillator_has_its_damping():
    # 0.1 Hz, below a radian per second
    slow = ModalBasis([0.1, 100.0], [4.0, 1.0], 0.01)
    found = loaded_shapes(slow, EXTENT, damper(np.diag([1.0, 0.2]), 5.0, 0.0)).modal
    c = 2 * found.damping_ratio * found.angular_frequency
    wanted = (slow.damping + 5.0 * np.array([1.0, 0.2])) / slow.modal_mass
    np.testing.assert_allclose(c, wanted, rtol=1e-9)


def test_a_panel_that_is_free_keeps_its_motion_as_a_rigid_body():
    free = ModalBasis([0.0, 100.0], [4.0, 1.0], 0.01)
    found = loaded_shapes(free, EXTENT, damper(np.diag([1.0, 0.2]), 5.0, 1.0)).modal
    assert found.natural_frequency[0] == pytest.approx(0.0, abs=1e-4)
    assert np.isfinite(found.damping_ratio).all()


@pytest.mark.parametrize("power", [-1.5, 1.0])
def test_a_shape_has_the_resonance_of_the_mass_that_changes_with_frequency(power):
    # one oscillator, whose exact response is known
    modal, frequency = ModalBasis([100.0], [2.0], 0.01), np.linspace(60.0, 110.0, 4000)

    def air(frequency):
        omega = 2 * np.pi * frequency
        return (1j * omega * 4.0 - omega**2 * 0.8 * (frequency / 90) ** power)[:, None, None]

    found = loaded_shapes(modal, EXTENT, air)
    whole = modal.dynamic_stiffness(frequency) + air(frequency)[:, :, 0]
    own = found.modal.dynamic_stiffness(frequency) / found.vectors[0, 0] ** 2
    places, squares = [], []
    for stiffness in (whole, own):
        psd = 1 / np.abs(stiffness[:, 0]) ** 2
        places.append(frequency[np.argmax(psd)])
        squares.append(np.trapezoid(psd, frequency))
    assert places[1] == pytest.approx(places[0], rel=1e-3)
    assert squares[1] == pytest.approx(squares[0], rel=0.02)


def test_the_mass_of_a_shape_stays_positive():
    # before a close wall the mass falls by more than itself
    def air(frequency):
        omega = 2 * np.pi * frequency
        return (-(omega**2) * np.interp(frequency, [90, 130], [1.5, -0.5]))[:, None, None] + 0j

    found = loaded_shapes(ModalBasis([110.0], [1.0], 0.01), EXTENT, air).modal
    assert np.all(found.modal_mass > 0)
