"""The shapes move exactly between impulses."""

import numpy as np
import pytest

from pidpanel.coupled.integration import drift_free_velocity, energy, free_motion

STEP = 1e-3


def moved(omega, ratio, q, speed, steps):
    own, other = free_motion(np.array([omega]), np.array([ratio]), STEP)
    state = np.array([[q], [speed]])
    for _ in range(steps):
        state = own * state + other * state[::-1]
    return state[:, 0]


@pytest.mark.parametrize(
    ("omega", "ratio"), [(30.0, 0.01), (5000.0, 0.3), (200.0, 2.5), (80.0, 1.0)]
)
def test_a_shape_moves_as_the_closed_form(omega, ratio):
    time, q, speed = 25 * STEP, 0.3, -4.0
    root = np.sqrt(complex(ratio**2 - 1)) * omega
    if ratio == 1.0:
        wanted = np.exp(-omega * time) * (q + (speed + omega * q) * time)
    else:
        a, b = -ratio * omega + root, -ratio * omega - root
        first = (speed - b * q) / (a - b)
        wanted = (first * np.exp(a * time) + (q - first) * np.exp(b * time)).real
    assert moved(omega, ratio, q, speed, 25)[0] == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_a_rigid_body_keeps_its_speed():
    assert moved(0.0, 0.0, 1.0, 2.0, 500) == pytest.approx([2.0, 2.0], rel=1e-12)


def test_energy_is_kept_without_damping_and_is_that_of_its_parts():
    mass, omega = np.array([2.0]), np.array([40.0])
    before = energy(mass, omega, np.array([[0.1], [3.0]]))
    assert before == pytest.approx(0.5 * 2 * (9 + 16), rel=1e-14)
    after = moved(40.0, 0.0, 0.1, 3.0, 400)[:, None]
    assert energy(mass, omega, after) == pytest.approx(before, rel=1e-10)


def test_a_free_shape_comes_back_to_its_place_after_a_period():
    # impulse by impulse, of forces that are linear between rows; their sum need not be zero
    rng = np.random.default_rng(1)
    force = rng.standard_normal((13, 2))
    force[-1] = force[0]
    mass = np.array([2.0, 50.0])
    start = drift_free_velocity(force, mass, STEP, 4)
    place, speed = np.zeros(2), start.copy()
    reach = 0.0
    for row in range(12):
        for part in range(4):
            speed += STEP * (force[row] + (force[row + 1] - force[row]) * part / 4) / mass
            place += STEP * speed
            reach = max(reach, np.abs(place).max())
    assert np.abs(place).max() < 1e-12 * reach
    # slower by its mass
    alone = drift_free_velocity(force[:, :1], np.array([4.0]), STEP, 4)
    assert alone == pytest.approx(start[:1] / 2, rel=1e-12)
