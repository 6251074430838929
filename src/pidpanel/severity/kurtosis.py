"""Peaks of a motion whose kurtosis exceeds that of a Gaussian one.

The motion is taken as a cubic function of a Gaussian one of unit rms (Winterstein, J. Eng. Mech.
114 (1988) 1772-1790), here of equal tails on both sides:

    X = h (U + c (U³ − 3U)),    c = (√(1 + 3k/2) − 1)/18,    h = (1 + 6c²)^(−1/2),

with k the excess kurtosis. Peaks grow with X(U).
"""

import numpy as np

from pidpanel.arrays import Array


def transformed(gaussian: Array, excess: Array) -> Array:
    """Return X of U and the excess kurtosis, which counts from 0 up; both are over the rms [1].

    Examples
    --------
    >>> transformed(np.array([4.0]), np.array([0.0, 1.4])).round(2).tolist()
    [4.0, 6.16]
    """
    cubic = (np.sqrt(1 + 1.5 * np.maximum(excess, 0.0)) - 1) / 18
    scale = 1 / np.sqrt(1 + 6 * cubic**2)
    return np.asarray(scale * (gaussian + cubic * (gaussian**3 - 3 * gaussian)))
