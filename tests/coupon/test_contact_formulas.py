"""The Rayleigh time against the wave equation that its fit stands for."""

import numpy as np
import pytest
from scipy.optimize import brentq

from pidpanel.coupon import contact


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
    # red: 2 * (1 + poissons_ratio) → 2 / …; 0.1631 → 0.17941 in `rayleigh_time`
    radius, density, modulus = 2e-3, 1190.0, 5e7
    shear_wave = np.sqrt(modulus / (2 * (1 + nu)) / density)
    time = np.pi * radius / (rayleigh_share(nu) * shear_wave)
    assert contact.rayleigh_time(radius, density, modulus, nu) == pytest.approx(time, rel=3e-3)


def test_the_bias_of_a_soft_sphere_grows_with_its_contact_and_is_none_of_the_material_itself():
    # 2.5 of the difference of contact times over the period, as measured
    # red: - → + in `modulus_bias`; max → min
    assert contact.modulus_bias(0.02, 0.005) == pytest.approx(0.0375)
    assert contact.modulus_bias(0.005, 0.005) == 0.0
    assert contact.modulus_bias(0.001, 0.005) == 0.0


def test_the_bias_of_a_bed_that_crosses_is_that_of_its_overlaps_where_they_say_more():
    # 1.5 of the difference of overlaps over the radius, as measured; the larger of the two
    # red: overlap - material_overlap → +; the sum of the two in place of the larger
    assert contact.modulus_bias(0.01, 0.01, 0.05, 0.01) == pytest.approx(0.06)
    assert contact.modulus_bias(0.03, 0.005, 0.05, 0.01) == pytest.approx(0.0625)
    assert contact.modulus_bias(0.01, 0.01, 0.01, 0.02) == 0.0


def test_a_modulus_serves_up_to_the_very_limits_of_time_and_depth():
    # a choice whose contact lasts and sinks in just as long and deep as allowed is taken, one a
    # thousandth beyond is not
    # red: * frequency → / frequency; overlap_per_radius * radius → / radius; <= → < modulus >=
    radius, density, nu, speed, frequency = 1e-3, 1190.0, 0.35, 0.15, 100.0
    args = (radius, density, 5e7, nu, speed)
    time = contact.wall_contact_time(*args) * frequency
    depth = contact.wall_overlap(*args) / radius

    def chosen(time, depth):
        return contact.softest_modulus(
            (5e7,), 3.2e9, radius=radius, density=density, poissons_ratio=nu, speed=speed,
            frequency=frequency, contact_time_per_period=time, overlap_per_radius=depth,
        )  # fmt: skip

    assert chosen(1.001 * time, 1.001 * depth) == 5e7
    assert chosen(0.999 * time, 1.001 * depth) == 3.2e9
    assert chosen(1.001 * time, 0.999 * depth) == 3.2e9
