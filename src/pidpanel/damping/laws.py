"""The paper's damping law, as printed and corrected.

C_e = (1/2π) a₁ ω^(a₂−1) e^(−a₃ω)                                              (Eq. 5)
a₁ = r (−20 + 36.09 r − 25.2 r²) 10⁻⁴,  a₂ = 4.10 − 0.6 r,  a₃ = r (8.8 − 12.5 r) 10⁻⁴   (Eq. 6)

*As printed* a₁ is negative for every 0 < r ≤ 1, so C_e is negative and feeds the panel.
*Corrected* means two changes, the only ones that give physical damping: |a₁|, and the frequency
in Hz instead of ω (in rad/s the modal damping is far above critical).
Both laws are independent of amplitude and have no apparent mass.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.damping.broadband import PAPER_LAW
from pidpanel.damping.readings import DampingError, DampingReading, DampingValues, Point

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
    f = _checked(frequency, fill_fraction)
    a1, a2, a3 = paper_constants(fill_fraction)
    return equation_5(2 * np.pi * f, a1, a2, a3)


def paper_corrected(frequency: ArrayLike, fill_fraction: float) -> Array:
    r"""Return C_e of Eq. 5 and 6 with |a₁| and f in Hz for ω [N s/m³].

    Parameters and errors as `paper_printed`.

    Examples
    --------
    >>> round(float(paper_corrected(1000.0, 0.5)))
    14526
    """
    f = _checked(frequency, fill_fraction)
    a1, a2, a3 = paper_constants(fill_fraction)
    return equation_5(f, abs(a1), a2, a3)


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


class PaperLaw(DampingReading):
    """A law of the paper, as printed (C_e is negative) or corrected; without mass, whatever Γ."""

    depends_on_acceleration = False
    broadband_error = PAPER_LAW
    nodes = None

    def __init__(self, *, printed: bool) -> None:
        self._law = paper_printed if printed else paper_corrected

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e at ``frequency`` (n,) [Hz]; see `readings.DampingReading`."""
        damping = self._law(frequency, fill_fraction)
        return DampingValues(
            damping, np.zeros_like(damping), np.zeros_like(damping), np.ones(damping.shape, bool)
        )

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return zeros (2n, 2n): the paper states no errors."""
        return np.zeros((2 * len(frequency), 2 * len(frequency)))

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return NaN: the paper states no mass."""
        return np.nan

    def without_mass(self) -> PaperLaw:
        """Return the law itself, which has no mass."""
        return self
