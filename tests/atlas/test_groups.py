"""The drive that gives a bed its groups."""

import math

import pytest

from pidpanel.atlas.groups import Bead, Groups, frequency, speed, stroke

GROUPS = Groups(0.6, 30.0, 0.2, 0.8, 0.3, 3.0, 10.0, "flat")


def test_the_drive_has_the_acceleration_and_the_stroke_of_the_groups():
    # red: the depth in place of the clear gap; Γ without g
    bead = Bead(diameter=1e-3)
    assert stroke(GROUPS, bead) == pytest.approx(0.2 * 0.4 * 10e-3, rel=1e-12)
    omega = 2 * math.pi * frequency(GROUPS, bead)
    assert omega**2 * stroke(GROUPS, bead) == pytest.approx(30 * 9.80665, rel=1e-12)
    assert speed(GROUPS, bead) == pytest.approx(omega * stroke(GROUPS, bead), rel=1e-12)


def test_a_particle_four_times_as_large_has_half_the_frequency():
    # √(g/d) is the only frequency of hard particles under gravity
    small, large = (frequency(GROUPS, Bead(diameter=d)) for d in (1e-3, 4e-3))
    assert large == pytest.approx(small / 2, rel=1e-12)
