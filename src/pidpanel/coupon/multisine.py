"""Random-phase multisines: a random acceleration of a given PSD that repeats after a while.

All lines k/T of a band are driven, each with the amplitude that the PSD gives it and a phase of its
own, even in 0 … 2π: a Gaussian motion in the limit of many lines, to which a nonlinear system has
the same best linear approximation, and without the dips of a drawn spectrum (Pintelon and
Schoukens, *System Identification*, 2nd ed., sections 2.4 and 4.3).

Spectra are normalised like PSDs: the mean of |X|² over lines is the one-sided PSD.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes

SAMPLES_PER_PERIOD = 10
"""Samples in a period of the highest frequency. The momentum is sampled as it is, and what it has
above half the rate folds down: with a PSD that falls like 1/f² or faster, 1/81 of what is at the
highest frequency, in power."""


@dataclass(frozen=True)
class Multisine:
    """An acceleration that repeats.

    Attributes
    ----------
    frequency
        (n,) lines, multiples of 1/T [Hz].
    acceleration
        (n,) spectrum of the acceleration of the cells [m/s²/√Hz].
    period
        T [s].
    samples
        Number of samples in a period.
    """

    frequency: Array
    acceleration: Complexes
    period: float
    samples: int

    @property
    def rate(self) -> float:
        """Samples per second [Hz]."""
        return self.samples / self.period

    def values(self) -> Array:
        """Return the samples (n,) of the acceleration over one period [m/s²].

        Between samples the motion is to run along straight lines, by which a tone loses
        sinc²(f/rate) of its amplitude: the samples have as much more.
        """
        spectrum = np.zeros(self.samples // 2 + 1, dtype=np.complex128)
        spectrum[self._lines] = self.acceleration / np.sinc(self.frequency / self.rate) ** 2
        return np.fft.irfft(spectrum * self._scale, self.samples)

    def spectrum_of(self, values: Array) -> Complexes:
        """Return the spectrum (n,) of samples (samples,) of one period on the lines."""
        spectrum: Complexes = np.fft.rfft(values)[self._lines] / self._scale
        return spectrum

    @property
    def _lines(self) -> np.ndarray:
        return np.rint(self.frequency * self.period).astype(np.int64)

    @property
    def _scale(self) -> float:
        """A spectrum of NumPy over ours: x = √(2/T) |X| cos."""
        return self.samples / np.sqrt(2 * self.period)


def draw_multisine(
    frequency: Array,
    acceleration_psd: Array,
    band: tuple[float, float],
    period: float,
    rng: np.random.Generator,
) -> Multisine:
    """Draw the phases of a multisine.

    Parameters
    ----------
    frequency, acceleration_psd
        (m,) rising [Hz], and the one-sided PSD there [(m/s²)²/Hz]. A line has its mean over 1/T,
        so that a resonance narrower than that keeps its power.
    band
        Lowest and highest line [Hz].
    period
        T [s].
    rng
        Of the phases.

    Raises
    ------
    ValueError
        If there is no line in the band.
    """
    low, high = band
    lines = np.arange(np.ceil(low * period - 1e-9), np.floor(high * period + 1e-9) + 1) / period
    if not lines.size:
        raise ValueError(f"period = {period:g} s: no line between {low:g} and {high:g} Hz")
    power = np.concatenate([[0.0], np.cumsum(np.diff(frequency) * _middle(acceleration_psd))])
    edges = np.clip(lines[:, None] + np.array([-0.5, 0.5]) / period, low, high)
    width = np.diff(edges, axis=1)[:, 0]
    psd = np.diff(_integral(edges, frequency, acceleration_psd, power), axis=1)[:, 0] / width
    phase = rng.uniform(0.0, 2 * np.pi, lines.size)
    samples = int(np.ceil(SAMPLES_PER_PERIOD * high * period))
    return Multisine(lines, np.sqrt(psd) * np.exp(1j * phase), period, samples)


def _middle(values: Array) -> Array:
    return (values[1:] + values[:-1]) / 2


def _integral(at: Array, frequency: Array, psd: Array, power: Array) -> Array:
    """∫ S df up to some frequencies, S linear between the given ones and 0 beyond them."""
    inside = np.clip(at, frequency[0], frequency[-1])
    index = np.clip(np.searchsorted(frequency, inside, side="right") - 1, 0, len(frequency) - 2)
    part = inside - frequency[index]
    slope = (psd[index + 1] - psd[index]) / (frequency[index + 1] - frequency[index])
    return np.asarray(power[index] + psd[index] * part + slope * part**2 / 2)
