"""Contacts are as soft as the motion allows."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pidpanel.coupled.softening import (
    CHOICES,
    RmsMotion,
    softened,
    softest,
)
from tests.beds import hexagons

OWN, RADIUS, DENSITY, POISSON = 3.3e9, 1.25e-3, 1190.0, 0.35
BED = hexagons(OWN / 1e6, 2 * RADIUS * 1e3, poissons_ratio=POISSON)
LARGEST_BIAS, LARGEST_ERROR, PER_LAYER, PER_OVERLAP, FASTEST = 0.02, 0.035, 2.8, 1.0, 3.0
"""Measured in benchmarks/coupled.md, but for the first two, which are allowed."""


def motion(velocity, frequency=300.0):
    return RmsMotion(velocity, 2 * np.pi * frequency * velocity)


def contact_time(modulus, velocity):
    """Hertz: 2.87 (m²/(R E*² v))^{1/5}."""
    mass = DENSITY * 4 / 3 * np.pi * RADIUS**3
    effective = modulus / (2 * (1 - POISSON**2))
    return 2.87 * (mass**2 / (RADIUS * effective**2 * velocity)) ** 0.2


def test_a_sine_has_its_stroke():
    amplitude, omega = 1e-4, 2 * np.pi * 130
    rms = RmsMotion(amplitude * omega / np.sqrt(2), amplitude * omega**2 / np.sqrt(2))
    assert rms.stroke == pytest.approx(amplitude)


def layered(layers):
    """Half full, of some layers."""
    return replace(BED, packing=replace(BED.packing, depth=layers * 2 * RADIUS / 0.5))


@pytest.mark.parametrize("velocity", [0.02, 0.1, 0.3])
@pytest.mark.parametrize(("layers", "share"), [(1.6, 0), (3.75, 0), (5, 0.5), (6.25, 1), (11, 1)])
def test_a_deep_bed_that_rides_is_late_by_the_contact_time_of_its_layers(velocity, layers, share):
    for modulus in CHOICES[:2]:
        late = contact_time(modulus, velocity) - contact_time(OWN, velocity)
        whole = PER_LAYER * layers * late * 9.80665 / velocity
        found = softened(OWN, layered(layers), motion(velocity), modulus)
        assert found.gain == pytest.approx(share * whole, rel=0.01, abs=1e-12)
        # half of it may be missing, of a shallow bed too
        assert found.gain_error == pytest.approx(whole / 2, rel=0.01)


def test_a_bed_that_crosses_is_shorter_by_its_overlaps():
    # 2.94 δ/v is the contact time
    fast = motion(2.0, frequency=100.0)
    apart = [
        contact_time(modulus, FASTEST * 2.0) * FASTEST * 2.0 / 2.943 for modulus in (50e6, OWN)
    ]
    found = softened(OWN, BED, fast, 50e6).bias
    assert found == pytest.approx(PER_OVERLAP * (apart[0] - apart[1]) / RADIUS, rel=0.01)
    # as fast, but too high in frequency to cross
    assert softened(OWN, BED, motion(2.0, frequency=2000.0), 50e6).bias == 0.0


@pytest.mark.parametrize(("velocity", "frequency"), [(0.1, 300.0), (2.0, 100.0)])
def test_a_stiffer_contact_is_never_worse_and_the_own_one_changes_nothing(velocity, frequency):
    moved = motion(velocity, frequency)
    changes = [softened(OWN, BED, moved, m)[1:] for m in CHOICES]
    for part in map(list, zip(*changes, strict=True)):
        assert all(softer >= stiffer for softer, stiffer in pairwise(part))
    assert sum(changes[0]) > sum(changes[1]) > 0
    assert softened(OWN, BED, moved, OWN) == (OWN, 0.0, 0.0, 0.0)
    assert changes[-1] == (0.0, 0.0, 0.0)


def test_a_louder_motion_allows_softer_contacts():
    # until beds cross
    speeds = np.geomspace(0.005, 1.0, 30)
    found = [softest(OWN, BED, motion(speed, 1000.0)) for speed in speeds]
    moduli = [contacts.modulus for contacts in found]
    assert all(slow >= fast for slow, fast in pairwise(moduli))
    assert moduli[-1] == CHOICES[0]
    assert len(set(moduli)) >= 4
    assert all(contacts.gain_error <= LARGEST_ERROR for contacts in found)
    assert max(contacts.gain_error for contacts in found) > LARGEST_ERROR / 2
    # one choice softer is too soft
    for speed, contacts in zip(speeds, found, strict=True):
        for softer in CHOICES[: CHOICES.index(contacts.modulus)] if contacts.gain_error else ():
            too_soft = softened(OWN, BED, motion(speed, 1000.0), softer)
            assert too_soft.gain_error > LARGEST_ERROR or too_soft.bias > LARGEST_BIAS


def test_where_none_is_allowed_the_modulus_is_that_of_the_material():
    # and a choice above that of the material is none
    assert softest(3.1e9, BED, motion(1e-4)) == (3.1e9, 0.0, 0.0, 0.0)
    assert softest(60e6, BED, motion(1e-3)).modulus == 60e6


@pytest.mark.parametrize("modulus", CHOICES[:3])
def test_the_change_of_a_bed_that_rides_is_that_of_the_gravity_along_the_motion(modulus):
    """A flight lasts 2v/g: a bed that is pressed harder flies shorter, and an upright one rests."""
    rides, bed = motion(0.02, 3000.0), layered(8)
    gain = softened(OWN, bed, rides, modulus).gain
    heavy = replace(bed, gravity=4 * bed.gravity)
    assert softened(OWN, heavy, rides, modulus).gain == pytest.approx(4 * gain)
    upright = replace(bed, gravity_direction=(1.0, 0.0, 0.0))
    assert softened(OWN, upright, rides, modulus).gain == 0.0
