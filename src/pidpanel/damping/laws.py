"""The paper's damping law, as printed and corrected; constants.

C_e = (1/2π) a₁ ω^(a₂−1) e^(−a₃ω)                                              (Eq. 5)
a₁ = r (−20 + 36.09 r − 25.2 r²) 10⁻⁴,  a₂ = 4.10 − 0.6 r,  a₃ = r (8.8 − 12.5 r) 10⁻⁴   (Eq. 6)

*As printed* a₁ is negative for every 0 < r ≤ 1, so C_e is negative and feeds the panel.
*Corrected* means two changes, the only ones that give physical damping: |a₁|, and the frequency
in Hz instead of ω (in rad/s the modal damping is far above critical).
Both laws are independent of amplitude and have no apparent mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.damping.broadband import PAPER_LAW
from pidpanel.damping.models import (
    Damper,
    DampingError,
    DampingValues,
    Point,
    correlated_covariance,
)

FREQUENCY_RANGE = (5.0, 2000.0)  # the range in which the paper shook its coupon [Hz]


def paper_constants(fill_fraction: float) -> tuple[float, float, float]:
    """Return a₁, a₂, a₃ of Eq. 6 as printed."""
    r = fill_fraction
    a1 = r * (-20 + 36.09 * r - 25.2 * r**2) * 1e-4
    a2 = 4.10 - 0.6 * r
    a3 = r * (8.8 - 12.5 * r) * 1e-4
    return a1, a2, a3


def equation_5(omega: ArrayLike, a1: ArrayLike, a2: ArrayLike, a3: ArrayLike) -> Array:
    """Return C_e = (1/2π) a₁ ω^(a₂−1) e^(−a₃ω) (Eq. 5); ω in the unit of the constants."""
    w = np.asarray(omega, float)
    return a1 / (2 * np.pi) * w ** (np.asarray(a2) - 1) * np.exp(-a3 * w)  # type: ignore[operator]


def paper_printed(frequency: ArrayLike, fill_fraction: float) -> Array:
    """Return C_e of Eq. 5 and 6 as printed [N s/m³]; negative for every fill.

    Raises
    ------
    DampingError
        If a value is outside `FREQUENCY_RANGE` [Hz] or 0 < r ≤ 1.

    Examples
    --------
    >>> bool(paper_printed(100.0, 0.5) < 0)
    True
    """
    omega = 2 * np.pi * _checked(frequency, fill_fraction)
    return equation_5(omega, *paper_constants(fill_fraction))


def paper_corrected(frequency: ArrayLike, fill_fraction: float) -> Array:
    r"""Return C_e of Eq. 5 and 6 with |a₁| and f in Hz for ω [N s/m³].

    Parameters and errors as `paper_printed`.

    Examples
    --------
    >>> round(float(paper_corrected(1000.0, 0.5)))
    14526
    """
    a1, a2, a3 = paper_constants(fill_fraction)
    return equation_5(_checked(frequency, fill_fraction), abs(a1), a2, a3)


def _checked(frequency: ArrayLike, fill_fraction: float) -> Array:
    f = np.asarray(frequency, float)
    low, high = FREQUENCY_RANGE
    if f.size and (f.min() < low or f.max() > high):
        raise DampingError(
            f"frequency = {f.min():g} to {f.max():g} Hz: "
            f"the paper's law holds from {low:g} to {high:g} Hz"
        )
    if not 0 < fill_fraction <= 1:
        raise DampingError(f"fill_fraction = {fill_fraction:g}: above 0, at most 1")
    return f


class PaperLaw(Damper):
    """A law of the paper, as printed (C_e is negative) or corrected; without mass, whatever Γ."""

    broadband_error = PAPER_LAW

    def __init__(self, *, printed: bool) -> None:
        self._law = paper_printed if printed else paper_corrected

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e at ``frequency`` (n,) [Hz]; see `models.Damper`."""
        damping = self._law(frequency, fill_fraction)
        return DampingValues(
            damping, np.zeros_like(damping), np.zeros_like(damping), np.ones(damping.shape, bool)
        )


@dataclass(frozen=True)
class ConstantDamper(Damper):
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

    @property
    def nodes(self) -> Array | None:
        """One frequency, since errors are the same at all; None without errors."""
        return np.ones(1) if self.relative_error or self.apparent_mass_error else None

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz]; see `models.Damper`."""
        frequency = np.asarray(frequency, float)
        damping = self.equivalent_damping + self.loss_mass * 2 * np.pi * frequency
        mass, inside = np.full(frequency.shape, self.apparent_mass), np.ones(frequency.shape, bool)
        return DampingValues(damping, self.relative_error * damping, mass, inside)

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, m_a; see `models.correlated_covariance`."""
        errors = np.repeat([self.relative_error, self.apparent_mass_error], len(frequency))
        return correlated_covariance(errors, errors)

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return what the damper weighs [kg/m²]."""
        return self.apparent_mass if self.weight is None else self.weight
