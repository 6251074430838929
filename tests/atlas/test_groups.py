"""The drive that gives a bed its groups."""

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from atlas_design import GRAVITY, Groups, frequency, speed, stroke
from scipy.special import beta

from pidpanel.atlas.groups import HERTZ_DURATION, USUAL, is_hard
from pidpanel.paths import PROJECT

GROUPS = Groups(0.6, 30.0, 0.2, 0.8, 0.3, 3.0, 10.0, "flat")


def test_the_drive_has_the_acceleration_and_the_stroke_of_the_groups():
    small = replace(USUAL, radius=0.5e-3)
    assert stroke(GROUPS, small) == pytest.approx(0.2 * 0.4 * 10e-3, rel=1e-12)
    omega = 2 * math.pi * frequency(GROUPS, small)
    assert omega**2 * stroke(GROUPS, small) == pytest.approx(30 * 9.80665, rel=1e-12)
    assert speed(GROUPS, small) == pytest.approx(omega * stroke(GROUPS, small), rel=1e-12)


def test_a_particle_four_times_as_large_has_half_the_frequency():
    # √(g/d) is the only frequency of hard particles under gravity
    small, large = (frequency(GROUPS, replace(USUAL, radius=r)) for r in (1e-3, 4e-3))
    assert large == pytest.approx(small / 2, rel=1e-12)


def test_the_particles_that_give_a_scale_are_those_of_the_study_of_the_atlas():
    study = yaml.safe_load((PROJECT / "workflow" / "studies" / "atlas.yaml").read_text())
    particles = study["coupon"]["particles"]
    assert 2 * USUAL.radius == pytest.approx(1e-3 * particles["diameter_mm"], rel=1e-12)
    assert USUAL.density == particles["density_kg_m3"]
    assert USUAL.youngs_modulus == pytest.approx(1e6 * particles["youngs_modulus_mpa"], rel=1e-12)
    assert USUAL.poissons_ratio == particles["poissons_ratio"]


def test_gravity_lies_along_the_motion_across_it_or_is_none():
    # the motion is along z.
    gravity = {name: size * np.array(way.split(), float) for name, (size, way) in GRAVITY.items()}
    np.testing.assert_array_equal(gravity["flat"], [0, 0, -1])
    assert gravity["upright"][2] == 0 and np.linalg.norm(gravity["upright"]) == 1
    np.testing.assert_array_equal(gravity["none"], [0, 0, 0])


@pytest.mark.parametrize(("modulus", "gamma"), [(5e8, 20.0), (5e8, 300.0), (1e8, 2.0)])
def test_soft_particles_are_hard_where_their_impacts_are_short_and_shallow(modulus, gamma):
    # as `ElasticSphere` has them
    impact = replace(USUAL, youngs_modulus=modulus)
    f = np.geomspace(5, 3000, 200)
    v = gamma * 9.80665 / (2 * np.pi * f)
    lasts = np.array([impact.wall_contact_time(x) for x in v.tolist()]) * f
    deep = np.array([impact.wall_overlap(x) for x in v.tolist()]) / impact.radius
    found = is_hard(impact, f, gamma)
    assert found.tolist() == ((lasts <= 0.02) & (deep <= 0.05)).tolist()
    assert 0 < found.sum() < len(f)


def test_a_bed_that_is_pressed_harder_is_as_hard_as_a_softer_one_on_the_ground():
    # with equal Γ over its own gravity and W: √4 times the frequency
    f = np.geomspace(50, 5000, 40)
    for gamma in (5.0, 60.0):
        soft = is_hard(replace(USUAL, youngs_modulus=USUAL.youngs_modulus / 4), f, gamma)
        assert is_hard(USUAL, 2 * f, 4 * gamma, gravity=4.0).tolist() == soft.tolist()
        assert 0 < soft.sum() < len(f)


def test_a_hertz_contact_lasts_as_long_as_its_integral_in_closed_form():
    # x = u^(2/5): 2 ∫₀¹ dx/√(1 − x^(5/2)) = 4/5 B(2/5, 1/2)
    assert pytest.approx(0.8 * beta(0.4, 0.5), rel=1e-6) == HERTZ_DURATION
