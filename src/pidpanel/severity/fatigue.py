"""Fatigue damage under a Gaussian stress, by Miner's rule and an S-N line N = N₁ (A/A₁)^−b.

`dirlik_damage_rate` counts rainflow cycles by Dirlik's fit (Application of computers in fatigue
analysis, PhD thesis, University of Warwick, 1985), `narrow_band_damage_rate` takes every upward
zero crossing for a cycle with a Rayleigh amplitude, which is safe. Amplitudes A are half the range;
the mean stress is zero. The von Mises stress is used like a stress of its PSD, a custom of design
(Preumont and Piéfort, J. Vib. Acoust. 116 (1994) 245-248).
"""

from typing import NamedTuple

import numpy as np
from scipy.special import gamma

from pidpanel.arrays import Array
from pidpanel.severity.moments import spectral_moment


class FatigueLine(NamedTuple):
    """Cycles to failure N = cycles (A/stress)^−exponent for the amplitude A."""

    stress: float  # amplitude [Pa]
    cycles: float  # at that amplitude
    exponent: float  # b [1]


def dirlik_damage_rate(frequency: Array, psd: Array, line: FatigueLine) -> Array:
    """Return Miner's damage a second [1/s] under Gaussian stresses; 0 without stress.

    PSDs (nf, …) are one-sided [Pa²/Hz], at rising frequencies (nf,) [Hz].
    """
    m0, m1, m2, m4 = (spectral_moment(frequency, psd, order) for order in (0, 1, 2, 4))
    b = line.exponent
    with np.errstate(invalid="ignore", divide="ignore"):
        irregularity = m2 / np.sqrt(m0 * m4)
        mean = m1 / m0 * np.sqrt(m2 / m4)
        d1 = 2 * (mean - irregularity**2) / (1 + irregularity**2)
        r = (irregularity - mean - d1**2) / (1 - irregularity - d1 + d1**2)
        d2 = (1 - irregularity - d1 + d1**2) / (1 - r)
        d3 = 1 - d1 - d2
        q = 1.25 * (irregularity - d3 - d2 * r) / d1
        mean_power = d1 * q**b * gamma(1 + b) + np.sqrt(2) ** b * gamma(1 + b / 2) * (
            d2 * np.abs(r) ** b + d3
        )
        rate = np.sqrt(m4 / m2) * (np.sqrt(m0) / line.stress) ** b * mean_power / line.cycles
    return np.where(m0 > 0, rate, 0.0)


def narrow_band_damage_rate(frequency: Array, psd: Array, line: FatigueLine) -> Array:
    """Return Miner's damage a second if each zero crossing were a cycle with a Rayleigh amplitude.

    Parameters and result are those of `dirlik_damage_rate`.
    """
    m0, m2 = (spectral_moment(frequency, psd, order) for order in (0, 2))
    b = line.exponent
    with np.errstate(invalid="ignore", divide="ignore"):
        rate = np.sqrt(m2 / m0) * (np.sqrt(2 * m0) / line.stress) ** b
    return np.where(m0 > 0, rate * gamma(1 + b / 2) / line.cycles, 0.0)
