"""What a bed does under a random motion, told beforehand: the perfectly inelastic body.

The first motion of a random drive rests on it, and how C_e and m_a will change with the motion
once records have told them at one. No result does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.best_linear import LinearApproximation
from pidpanel.damping.random_reading import RandomReading
from pidpanel.inelastic import at_impacts, impact_rate

LEAST_VELOCITY = 1e-6
"""Of a motion [m/s]: slower ones are no motion."""

UNSURE = 0.5
"""Standard deviation of the share of the inelastic body's change with the motion, before it is
seen: C_e of beds that ride falls with the motion as told, of those that begin to cross it rises."""

SHARES = (-2.0, 2.0)
"""Least and largest share."""

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
        self, reading: RandomReading, velocity: float, share: float, other: float
    ) -> RandomReading:
        """Return what was found under one motion as it is expected under another.

        ln C_e and m_a change by a share of what those of the inelastic body do.

        Parameters
        ----------
        reading, velocity
            What was found, and the rms of its motion [m/s].
        share
            See `share_seen`.
        other
            rms of the other motion [m/s].
        """
        bed, bands = replace(self, mass=reading.weight), reading.bands
        was, is_ = (bed.values(bands.frequency, v) for v in (velocity, other))
        factor = (is_[0] / was[0]) ** share
        return replace(
            reading,
            bands=replace(
                bands,
                equivalent_damping=bands.equivalent_damping * factor,
                equivalent_damping_error=bands.equivalent_damping_error * factor,
                apparent_mass=bands.apparent_mass + share * (is_[1] - was[1]),
            ),
        )

    def share_seen(
        self, reading: RandomReading, velocity: float, earlier: RandomReading, before: float
    ) -> float:
        """Return the share of the expected change of ln C_e that was seen between two motions.

        Least squares over the bands, with 1 ± `UNSURE` counted in beforehand: where the motions
        are nearly the same they tell nothing.

        Parameters
        ----------
        reading, velocity
            What was found, and the rms of its motion [m/s].
        earlier, before
            What was found of the same packings under another motion, and its rms [m/s].
        """
        frequency = reading.bands.frequency
        now, then = (self.values(frequency, v)[0] for v in (velocity, before))
        expected = np.log(now / then)
        found, error = _log_damping(reading, frequency)
        was, was_error = _log_damping(earlier, frequency)
        weight = 1 / (error**2 + was_error**2 + NEVER_CLOSER**2)
        told = UNSURE**-2 + float(weight @ (expected * (found - was)))
        share = told / (UNSURE**-2 + float(weight @ expected**2))
        return min(max(share, SHARES[0]), SHARES[1])


def _log_damping(reading: RandomReading, frequency: Array) -> tuple[Array, Array]:
    """ln C_e (n,) and its error, without that of the packings."""
    values = reading.with_packing_error(0.0)(frequency, np.nan, np.nan)
    damping = values.equivalent_damping
    return np.log(damping), values.equivalent_damping_error / damping
