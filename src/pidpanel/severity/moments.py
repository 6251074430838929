"""Spectral moments of a PSD, and what a Gaussian process with it does in a duration.

m_n = ∫ fⁿ S(f) df. A Gaussian process crosses zero upwards ν₀ = √(m₂/m₀) times a second and has
ν_p = √(m₄/m₂) peaks a second (Rice, Bell System Tech. J. 24 (1945) 46-156).
"""

import numpy as np
from numpy.polynomial.legendre import leggauss

from pidpanel.arrays import Array

EULER = 0.5772156649015329


def spectral_moment(frequency: Array, psd: Array, order: int) -> Array:
    """Return a moment [unit² Hzⁿ] of PSDs straight between their lines; exact up to order 4.

    PSDs (nf, …) are one-sided [unit²/Hz], at rising frequencies (nf,) [Hz].

    Examples
    --------
    >>> f = np.array([0.0, 1.0, 3.0])
    >>> round(float(spectral_moment(f, np.ones(3), 2)), 9)  # 3³/3
    9.0
    """
    node, weight = leggauss(3)
    upper = (1 + node) / 2
    half = np.diff(frequency)[:, None] / 2
    f = frequency[:-1, None] + 2 * half * upper
    values = np.multiply.outer(1 - upper, psd[:-1]) + np.multiply.outer(upper, psd[1:])
    return np.einsum("sg,gs...->...", half * weight * f**order, values)


def zero_crossing_rate(frequency: Array, psd: Array) -> Array:
    """Return the upward zero crossings a second of Gaussian processes [Hz]; NaN without motion.

    Parameters are those of `spectral_moment`.
    """
    with np.errstate(invalid="ignore"):
        rate: Array = np.sqrt(
            spectral_moment(frequency, psd, 2) / spectral_moment(frequency, psd, 0)
        )
    return rate


def peak_factor(rate: Array, duration: float) -> Array:
    """Return the mean of the largest peak in a duration [s] over the rms of a Gaussian process.

    √(2 ln ν₀T) + γ/√(2 ln ν₀T) with Euler's γ and a rate ν₀ [Hz] (Davenport, Proc. Inst. Civ. Eng.
    28 (1964) 187-196), for a narrow or wide band; it needs many crossings.

    Examples
    --------
    >>> peak_factor(np.array(100.0), 60.0).round(3)
    np.float64(4.31)
    """
    root = np.sqrt(2 * np.log(np.asarray(rate) * duration))
    return root + EULER / root
