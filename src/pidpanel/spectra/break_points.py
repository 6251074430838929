"""A PSD of break points: straight on logarithmic axes, with a step where a frequency repeats."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class BreakPoints:
    """A one-sided PSD."""

    # (n,) not falling [Hz], at most two alike, the first two and the last two apart
    frequency: Array
    psd: Array  # (n,) positive [unit²/Hz]

    def __call__(self, frequency: Array) -> Array:
        """Return the PSD at frequencies within the break points (nf,) [Hz]; at a step the higher.

        Examples
        --------
        >>> steps = BreakPoints(np.array([20.0, 80.0, 80.0, 90.0]), np.array([1.0, 16.0, 2.0, 2.0]))
        >>> steps(np.array([40.0, 80.0])).round(6).tolist()
        [4.0, 2.0]
        """
        index = np.searchsorted(self.frequency, frequency, side="right") - 1
        index = np.clip(index, 0, len(self.psd) - 2)
        ratio = frequency / self.frequency[index]
        return self.psd[index] * ratio ** self._slope[index]

    @property
    def jumps(self) -> Array:
        """Frequencies of steps [Hz]."""
        return self.frequency[1:][np.diff(self.frequency) == 0]

    @property
    def _slope(self) -> Array:
        """(n − 1,) exponent n of S ∝ fⁿ between break points, 0 at a step."""
        octaves = np.diff(np.log(self.frequency))
        rise = np.diff(np.log(self.psd))
        return np.divide(rise, octaves, out=np.zeros_like(rise), where=octaves > 0)

    @property
    def rms(self) -> float:
        """√∫ S df over all break points [unit]."""
        return math.sqrt(self.mean_square(float(self.frequency[0]), float(self.frequency[-1])))

    def segment(self, low: float, high: float) -> BreakPoints:
        """Return the part within frequencies [Hz].

        Examples
        --------
        >>> BreakPoints(np.array([10.0, 100.0]), np.array([1.0, 0.1])).segment(20.0, 200.0).psd
        array([0.5, 0.1])
        """
        ends = np.array([max(low, self.frequency[0]), min(high, self.frequency[-1])])
        inner = (self.frequency > ends[0]) & (self.frequency < ends[1])
        last = np.searchsorted(self.frequency, ends[1]) - 1  # below a step at the end
        psd = self.psd[last] * (ends[1] / self.frequency[last]) ** self._slope[last]
        return BreakPoints(
            np.concatenate([ends[:1], self.frequency[inner], ends[1:]]),
            np.concatenate([self(ends[:1]), self.psd[inner], [psd]]),
        )

    def mean_square(self, low: float, high: float) -> float:
        """Return ∫ S df between two frequencies within the break points [Hz], in closed form.

        Examples
        --------
        >>> BreakPoints(np.array([10.0, 100.0]), np.array([1.0, 0.1])).mean_square(10.0, 100.0)
        23.02585092994046
        """
        f, slope = self.frequency, self._slope
        begin, end = np.clip(f[:-1], low, high), np.clip(f[1:], low, high)
        octaves = np.log(end / begin)
        power = (slope + 1) * octaves
        # ∫ S df = a S(a) (e^x − 1)/x · ln(b/a) with x = (n + 1) ln(b/a)
        growth = np.where(np.abs(power) < 1e-9, 1.0, np.expm1(power) / np.where(power, power, 1.0))
        psd = self.psd[:-1] * (begin / f[:-1]) ** slope
        return float(np.sum(begin * psd * growth * octaves))
