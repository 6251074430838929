"""Closed forms of one contact, against integration of its equation of motion."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from pidpanel.coupon import contact

R, RHO, E, NU, V = 1e-3, 1190.0, 5e7, 0.35, 0.15
SPHERE = contact.ElasticSphere(R, RHO, E, NU)
STIFF = contact.ElasticSphere(R, RHO, 3.2e9, NU)


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
    assert SPHERE.wall_overlap(V) == pytest.approx(overlap, rel=1e-5)
    assert SPHERE.wall_contact_time(V) == pytest.approx(duration, rel=1e-5)


def choose(choices=(5e7, 2e8, 8e8), frequency=100.0, speed=0.15, time=0.02, overlap=0.1):
    return contact.softest_modulus(
        choices, STIFF, speed=speed, frequency=frequency,
        contact_time_per_period=time, overlap_per_radius=overlap,
    )  # fmt: skip


def test_a_choice_stiffer_than_the_material_is_never_taken():
    assert choose(choices=(7e10,), frequency=10.0) == 3.2e9


def rayleigh_share(nu):
    """c_R over the shear wave's speed: (2 − x²)² = 4 √(1 − x²) √(1 − κx²), κ = (1 − 2ν)/(2 − 2ν)."""
    kappa = (1 - 2 * nu) / (2 - 2 * nu)
    return brentq(
        lambda x: (2 - x**2) ** 2 - 4 * np.sqrt(1 - x**2) * np.sqrt(1 - kappa * x**2), 0.8, 0.9999
    )


@pytest.mark.parametrize("nu", [0.2, 0.3, 0.35, 0.45])
def test_a_rayleigh_wave_crosses_half_the_girth_of_a_sphere_in_the_rayleigh_time(nu):
    # π R over c_R, whose share of the shear wave's speed the linear fit 0.1631 ν + 0.8766 meets
    # within 0.3 % from ν = 0.2 up
    radius, density, modulus = 2e-3, 1190.0, 5e7
    shear_wave = np.sqrt(modulus / (2 * (1 + nu)) / density)
    time = np.pi * radius / (rayleigh_share(nu) * shear_wave)
    sphere = contact.ElasticSphere(radius, density, modulus, nu)
    assert sphere.rayleigh_time == pytest.approx(time, rel=3e-3)


def test_a_modulus_serves_up_to_the_very_limits_of_time_and_depth():
    # a choice whose contact lasts and sinks in just as long and deep as allowed is taken, one a
    # thousandth beyond is not
    time, depth = SPHERE.wall_contact_time(0.15) * 100.0, SPHERE.wall_overlap(0.15) / R
    for longer, deeper, modulus in ((1.001, 1.001, 5e7), (0.999, 1.001, 2e8), (1.001, 0.999, 2e8)):
        assert choose(time=longer * time, overlap=deeper * depth) == modulus


def test_a_contact_rebounds_at_its_restitution_and_resists_slip_with_mindlins_stiffness():
    # m δ″ = −F(δ) − c(δ) δ′ until the spheres part
    material = contact.contact_material((2e8, 0.3), (2e8, 0.3), 0.3, 0.7)
    curvature, mobility = np.array([2e3]), np.array([2e6])

    def forces(depth):
        values = contact.contact_forces(material, np.array([depth]), curvature, mobility)
        return [float(value[0]) for value in values]

    def motion(_, state):
        elastic, viscous, _across = forces(max(state[0], 0.0))
        return [state[1], -mobility[0] * (elastic + viscous * state[1])]

    def parted(_, state):
        return state[0]

    parted.terminal, parted.direction = True, -1
    impact = solve_ivp(
        motion, (0, 1), [1e-12, 0.5], events=parted, rtol=1e-9, atol=1e-15, max_step=1e-5
    )
    assert -impact.y[1, -1] / 0.5 == pytest.approx(0.7, rel=1e-3)
    elastic, along, across = forces(1e-5)
    hertz = 4 / 3 * material.effective_modulus * np.sqrt(1e-5 / curvature[0]) * 1e-5
    assert elastic == pytest.approx(hertz)
    stiffnesses = 4 * material.effective_shear_modulus / material.effective_modulus
    assert across / along == pytest.approx(np.sqrt(stiffnesses))


def test_rolling_friction_of_either_side_is_in_the_words_of_the_law():
    smooth = contact.Constants.alike(1e7, 0.3, 0.7, 0.3)
    assert smooth.contact_model == "hertz tangential history"
    for name in ("rolling_friction", "wall_rolling_friction"):
        assert replace(smooth, **{name: 0.1}).contact_model.endswith("rolling_friction cdt")
