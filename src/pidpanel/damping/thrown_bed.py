"""What a bed does under a random motion, told beforehand: the perfectly inelastic body.

The first motion of a random drive rests on it, and how C_e and m_a will change with the motion
once records have told them at one. No result does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.best_linear import LinearApproximation
from pidpanel.damping.random_reading import RandomReading
from pidpanel.inelastic import at_impacts, impact_rate

LEAST_VELOCITY = 1e-6
"""Of a motion [m/s]: slower ones are no motion."""

UNSURE = 0.7
"""Standard deviation of the power of the velocity by which what is found departs from the inelastic
body, before it is seen: C_e of beds that ride falls with the motion nearly as told, of those that
begin to cross it rises sooner or later than told."""

NEAR = 0.5
"""Distance of ln of the velocity up to which motions tell of it."""

FARTHEST = 1.35
"""Ratio of velocities over which what was found is carried."""

EXPONENTS = (-3.0, 4.0)
"""Least and largest power of the velocity by which what is found departs from that body."""

NEVER_CLOSER = 0.05
"""Standard deviation of ln C_e of a band beside its stated error."""


@dataclass(frozen=True)
class ThrownBed:
    """A perfectly inelastic body in a cell.

    Attributes
    ----------
    mass
        Per area [kg/m²].
    gap
        L above it [m].
    gravity
        Along the motion [m/s²].
    """

    mass: float
    gap: float
    gravity: float

    def values(self, frequency: Array, velocity: float) -> tuple[Array, Array]:
        """Return C_e [N s/m³] and m_a [kg/m²] (n,) under a motion of an rms velocity [m/s]."""
        rate = impact_rate(max(velocity, LEAST_VELOCITY), self.gap, self.gravity)
        damping, mass = at_impacts(frequency, rate)
        return self.mass * damping, self.mass * mass

    def reading(self, edges: Array, velocity: float) -> RandomReading:
        """Return it as a reading in bands.

        Parameters
        ----------
        edges
            (m,) of the bands [Hz].
        velocity
            rms of the motion [m/s].
        """
        frequency, none = np.sqrt(edges[1:] * edges[:-1]), np.zeros(len(edges) - 1)
        damping, mass = self.values(frequency, velocity)
        bands = LinearApproximation(
            low=edges[:-1],
            high=edges[1:],
            frequency=frequency,
            equivalent_damping=damping,
            equivalent_damping_error=none,
            apparent_mass=mass,
            apparent_mass_error=none,
            coherence=none + 1,
            common_psd=none,
            own_psd=none,
            packing_error=0.0,
        )
        return RandomReading(bands, weight=self.mass, area=1.0)

    def carried(
        self, reading: RandomReading, velocity: float, exponent: float, other: float
    ) -> RandomReading:
        """Return what was found under one motion as it is expected under another.

        C_e changes as that of the inelastic body and with a power of the velocity besides, m_a by
        as much as that of the body. Motions beyond `FARTHEST` are taken to be there.

        Parameters
        ----------
        reading, velocity
            What was found, and the rms of its motion [m/s].
        exponent
            Of the power; see `exponent_seen`.
        other
            rms of the other motion [m/s].
        """
        bed, bands = replace(self, mass=reading.weight), reading.bands
        other = min(max(other, velocity / FARTHEST), velocity * FARTHEST)
        was, is_ = (bed.values(bands.frequency, v) for v in (velocity, other))
        factor = is_[0] / was[0] * (other / velocity) ** exponent
        return replace(
            reading,
            bands=replace(
                bands,
                equivalent_damping=bands.equivalent_damping * factor,
                equivalent_damping_error=bands.equivalent_damping_error * factor,
                apparent_mass=bands.apparent_mass + is_[1] - was[1],
            ),
        )

    def exponent_seen(self, found: Sequence[tuple[RandomReading, float]]) -> float:
        """Return the power of the velocity with which C_e changes besides that of the body.

        Least squares of ln C_e over that of the body, with a constant for each band, and
        0 ± `UNSURE` counted in beforehand: motions that are nearly the same tell nothing.

        Parameters
        ----------
        found
            Of the same packings under motions, and their rms [m/s]. Those count that are near the
            last.
        """
        last, now = found[-1]
        frequency = last.bands.frequency
        near = [(one, v) for one, v in found if abs(math.log(v / now)) <= NEAR]
        log_velocity = np.log([v for _, v in near])[:, None]
        damping, error = (np.stack(part) for part in zip(
            *(_log_damping(one, frequency) for one, _ in near), strict=True))  # fmt: skip
        body = np.stack([np.log(self.values(frequency, v)[0]) for _, v in near])
        weight = 1 / (error**2 + NEVER_CLOSER**2)
        share = weight / weight.sum(axis=0)
        rise = log_velocity - np.sum(share * log_velocity, axis=0)
        told = float(np.sum(weight * rise * (damping - body)))
        exponent = told / (UNSURE**-2 + float(np.sum(weight * rise**2)))
        return min(max(exponent, EXPONENTS[0]), EXPONENTS[1])


def _log_damping(reading: RandomReading, frequency: Array) -> tuple[Array, Array]:
    """ln C_e (n,) and its error, without that of the packings."""
    values = reading.with_packing_error(0.0)(frequency, np.nan, np.nan)
    damping = values.equivalent_damping
    return np.log(damping), values.equivalent_damping_error / damping
