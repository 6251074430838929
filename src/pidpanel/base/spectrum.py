"""Acceleration PSD of the supports: straight lines between break points on logarithmic axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class BaseSpectrum:
    """An acceleration PSD of break points.

    Parameters
    ----------
    frequency
        (n,) rising [Hz].
    psd
        (n,) positive; the result has its unit, here g²/Hz.
    """

    frequency: Array
    psd: Array

    def __call__(self, frequency: Array) -> Array:
        """Return the PSD at frequencies (nf,) [Hz]; none outside the break points.

        Examples
        --------
        >>> BaseSpectrum(np.array([20.0, 80.0]), np.array([0.01, 0.16]))(np.array([10.0, 40.0]))
        array([0.  , 0.04])
        """
        inside = (frequency >= self.frequency[0]) & (frequency <= self.frequency[-1])
        at_lines = np.interp(np.log(frequency), np.log(self.frequency), np.log(self.psd))
        return np.where(inside, np.exp(at_lines), 0.0)

    @property
    def slope(self) -> Array:
        """(n − 1,) exponent n of S ∝ fⁿ between break points; 6.02 dB/octave is 2."""
        return np.diff(np.log(self.psd)) / np.diff(np.log(self.frequency))

    @property
    def rms(self) -> float:
        """√∫ S df over all break points, in closed form [g]."""
        f, power = self.frequency, self.slope + 1
        octaves = np.diff(np.log(f))
        # f₁ S₁ ((f₂/f₁)ᵖ − 1)/p, which is f₁ S₁ ln(f₂/f₁) for p = 0
        x = power * octaves
        flat = np.abs(x) < 1e-9
        growth = np.where(flat, octaves, np.expm1(x) / np.where(flat, 1.0, power))
        return float(np.sqrt(np.sum(f[:-1] * self.psd[:-1] * growth)))

    def between(self, low: float, high: float) -> BaseSpectrum:
        """Return the part within frequencies [Hz]."""
        ends = np.array([max(low, self.frequency[0]), min(high, self.frequency[-1])])
        inner = (self.frequency > ends[0]) & (self.frequency < ends[1])
        f = np.concatenate([ends[:1], self.frequency[inner], ends[1:]])
        return BaseSpectrum(f, self(f))
