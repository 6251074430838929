"""Softest contacts of a coupled run, and what they change.

A softer sphere allows a longer time step. Two things go wrong with it:

- A bed that is thrown up and caught rebounds in series, layer by layer, which raises C_e. The
  change depends on the contact time over the flight time, s = t_c g/v with v the rms velocity of
  the patch and g the steady acceleration along the motion. It is known and taken out.
- A bed that crosses its gap is shorter by the overlaps of its spheres: δ/R (`contact`). What that
  does to g rms has either sign. It is an error.

Runs in benchmarks/coupled.md; ``benchmarks/convergence.py`` makes them.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pidpanel.coupon.bed import Bed
from pidpanel.damping.surface_cases import clear_gap

# Moduli to choose from below that of the material [Pa].
CHOICES = (50e6, 200e6, 800e6, 3200e6, 12800e6, 51200e6)

LARGEST_BIAS = 0.02  # largest error of g rms by overlaps that a softer modulus may cause [1]

LARGEST_GAIN_ERROR = 0.035  # largest error of ln C_e; 1 % of g rms of the paper's panel [1]

# Change of ln C_e over s for each layer of the bed [1]. g rms of the paper's panel was lower by
# 0.8 s for each (r = 0.5 and 0.9, 50 to 800 MPa, 119 to 125 dB), and falls by 0.29 of the change of
# ln C_e there.
PER_LAYER = 2.8

PER_LAYER_ERROR = 0.5  # standard error of `PER_LAYER`, over it [1]

# Layers up to which nothing changed (r = 0.1 and 0.3), and from which on all of it was found.
REBOUNDING = (3.75, 6.25)

PER_OVERLAP = 1.0  # error of g rms over δ/R where the bed crosses [1]

FASTEST = 3.0  # velocity of the deepest impacts over the rms velocity of the patch [1]

CROSSES = 0.2  # stroke of the bare patch over the clear gap from which its bed may cross [1]

USUAL = 400e6  # geometric mean of the moduli of acrylic from 122 to 142 dB [Pa]


class RmsMotion(NamedTuple):
    """Rms motion of the bare patch."""

    # [m/s], [m/s²]
    velocity: float
    acceleration: float

    @property
    def stroke(self) -> float:
        """Amplitude of the sine with both [m]."""
        return float(np.sqrt(2) * self.velocity**2 / self.acceleration)


class Softened(NamedTuple):
    """Modulus of the contacts [Pa], and what differs from that of the material."""

    modulus: float
    # Change of ln C_e by layers that rebound in series, and its standard error [1]
    gain: float = 0.0
    gain_error: float = 0.0
    bias: float = 0.0  # error of g rms by overlaps of a bed that crosses [1]


def softened(material_modulus: float, bed: Bed, motion: RmsMotion, modulus: float) -> Softened:
    """Return what a modulus changes against that of the material."""
    packing = bed.packing
    radius = packing.sizes.largest / 2
    layers = bed.fill_fraction * packing.depth / packing.diameter

    velocity = motion.velocity
    pair = [replace(packing.smallest(m), radius=radius) for m in (modulus, material_modulus)]
    gravity = bed.gravity * abs(bed.gravity_direction[2])
    soft, stiff = (s.wall_contact_time(velocity) * gravity / velocity for s in pair)
    change = PER_LAYER * layers * max(soft - stiff, 0.0)
    gain = change * float(np.interp(layers, REBOUNDING, (0, 1))), change * PER_LAYER_ERROR
    gap = packing.depth * float(clear_gap(np.array(bed.fill_fraction)))
    if motion.stroke < CROSSES * gap:
        return Softened(modulus, *gain)
    deep, shallow = (s.wall_overlap(FASTEST * velocity) / radius for s in pair)
    return Softened(modulus, *gain, PER_OVERLAP * max(deep - shallow, 0.0))


def softest(material_modulus: float, bed: Bed, motion: RmsMotion) -> Softened:
    """Return the softest contacts that are accurate enough, or those of the material."""
    for modulus in CHOICES:
        if modulus >= material_modulus:
            break
        found = softened(material_modulus, bed, motion, modulus)
        if found.gain_error <= LARGEST_GAIN_ERROR and found.bias <= LARGEST_BIAS:
            return found
    return Softened(material_modulus)


def usual_modulus(material_modulus: float, density: float) -> float:
    """Return about the modulus of a run before the motion of the panel is known [Pa]."""
    return min(material_modulus, USUAL * density / 1190.0)
