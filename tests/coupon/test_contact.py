"""Closed forms of one contact, against integration of its equation of motion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pidpanel.coupon import contact

R, RHO, E, NU, V = 1e-3, 1190.0, 5e7, 0.35, 0.15


def impact():
    """m δ̈ = −(4/3) E* √R δ^{3/2} from δ̇ = V until δ = 0: deepest overlap and duration."""
    mass = RHO * 4 / 3 * np.pi * R**3
    stiffness = 4 / 3 * E / (2 * (1 - NU**2)) * np.sqrt(R)

    def rate(_, y):
        return [y[1], -stiffness / mass * max(y[0], 0.0) ** 1.5]

    def apart(_, y):
        return y[0]

    apart.terminal, apart.direction = True, -1
    run = solve_ivp(rate, (0, 1e-3), [0.0, V], events=apart, rtol=1e-10, atol=1e-16, max_step=1e-6)
    return run.y[0].max(), run.t_events[0][-1]


def test_overlap_and_duration_are_those_of_the_integrated_impact():
    overlap, duration = impact()
    # the integration is good to 1e-7, its sampling of the maximum to 1e-6
    assert contact.wall_overlap(R, RHO, E, NU, V) == pytest.approx(overlap, rel=1e-5)
    assert contact.wall_contact_time(R, RHO, E, NU, V) == pytest.approx(duration, rel=1e-5)


def choose(choices=(5e7, 2e8, 8e8), frequency=100.0, speed=0.15, time=0.02, overlap=0.1):
    return contact.softest_modulus(
        choices, 3.2e9, radius=R, density=RHO, poissons_ratio=NU, speed=speed,
        frequency=frequency, contact_time_per_period=time, overlap_per_radius=overlap,
    )  # fmt: skip


def test_the_softest_modulus_that_is_fast_enough_is_taken():
    assert choose(frequency=100.0) == 5e7
    assert choose(frequency=300.0, speed=0.05) in (2e8, 8e8)


def test_where_no_choice_is_stiff_enough_the_material_itself_is_taken():
    assert choose(frequency=2000.0, speed=0.008) == 3.2e9


def test_a_fast_drive_asks_for_stiffness_because_of_overlap():
    # at 10 m/s the 50 MPa sphere would sink in by 0.19 R
    assert contact.wall_overlap(R, RHO, 5e7, NU, 10.0) > 0.15 * R
    assert choose(frequency=30.0, speed=10.0) > 5e7


def test_a_choice_stiffer_than_the_material_is_never_taken():
    assert choose(choices=(7e10,), frequency=10.0) == 3.2e9
