"""C_e and m_a as numbers: a dashpot with mass, dead weight, a loss factor."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.broadband import EXACT
from pidpanel.damping.readings import DampingReading, DampingValues, Point, correlated_covariance


@dataclass(frozen=True)
class ConstantDamper(DampingReading):
    """The same C_e, or the same loss factor η, and the same m_a at every f, r and Γ.

    C_e = c + η m″ ω, where one of the two is not zero. η m″ ω is the energy per cycle and area
    written both ways: E_d = π C_e ω W² = η π m″ (ωW)². m″ is the mass per area that η refers to:
    that of the particles, or that of panel and treatment together. A whole panel of mass m″ then
    gains the damping ratio η/2 at each of its resonances.

    Examples
    --------
    >>> of_patch = ConstantDamper(loss_mass=0.1 * 5.0, apparent_mass=1.0)
    >>> values = of_patch(np.array([100.0]), 0.5, 1.0)
    >>> values.equivalent_damping.round(2), values.apparent_mass
    (array([314.16]), array([1.]))
    """

    equivalent_damping: float = 0.0  # c [N s/m³]
    loss_mass: float = 0.0  # η m″ [kg/m²]
    relative_error: float = 0.0
    # m_a and its standard error [kg/m²]
    apparent_mass: float = 0.0
    apparent_mass_error: float = 0.0
    weight: float | None = None  # of the damper [kg/m²]; None for its apparent mass
    depends_on_acceleration = False
    broadband_error = EXACT

    @property
    def nodes(self) -> Array | None:
        """One frequency, since errors are the same at all; None without errors."""
        return np.ones(1) if self.relative_error or self.apparent_mass_error else None

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz]; see `readings.DampingReading`."""
        frequency = np.asarray(frequency, float)
        damping = self.equivalent_damping + self.loss_mass * 2 * np.pi * frequency
        mass, inside = np.full(frequency.shape, self.apparent_mass), np.ones(frequency.shape, bool)
        return DampingValues(damping, self.relative_error * damping, mass, inside)

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, m_a; see `readings.correlated_covariance`."""
        errors = np.repeat([self.relative_error, self.apparent_mass_error], len(frequency))
        return correlated_covariance(errors, errors)

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return what the damper weighs [kg/m²]."""
        return self.apparent_mass if self.weight is None else self.weight

    def without_mass(self) -> ConstantDamper:
        """Return the same damping with m_a = 0."""
        weight = self.mass_per_area(np.nan)
        return replace(self, apparent_mass=0.0, apparent_mass_error=0.0, weight=weight)
