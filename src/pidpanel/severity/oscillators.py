"""Vibration response spectrum: rms acceleration of damped oscillators on a moving point.

|H|² = (1 + (r/Q)²) / ((1 − r²)² + (r/Q)²), r = f/f_n, of the absolute acceleration of an oscillator
with the natural frequency f_n and the quality Q = 1/2ζ. On a flat PSD that reaches far beyond f_n
its rms value is √(π/2 f_n Q S (1 + 1/Q²)): Miles' equation without the last factor
(J. Aeronaut. Sci. 21 (1954) 753-762).
"""

import numpy as np

from pidpanel.arrays import Array

# Angle up to which lines are added at a resonance, where the half bandwidth times its tangent is 14
# of them away [rad].
WIDEST = 1.5
ADDED = 241
PER_DECADE = 40
# Relative distance of a natural frequency from a step of the PSD, as rounding of 10^(N/40) has it
NEAR = 1e-9


def natural_frequencies(low: float, high: float) -> Array:
    """Return natural frequencies from one to another, 40 to a decade [Hz].

    Examples
    --------
    >>> natural_frequencies(100.0, 120.0).round(1)
    array([100. , 105.9, 112.2, 118.9])
    """
    first = np.ceil(PER_DECADE * np.log10(low) - 1e-9)
    last = np.floor(PER_DECADE * np.log10(high) + 1e-9)
    return 10 ** (np.arange(first, last + 1) / PER_DECADE)


def response_spectrum(frequency: Array, psd: Array, natural: Array, quality: float) -> Array:
    """Return the rms accelerations (m, n) of oscillators on points.

    Parameters
    ----------
    frequency, psd
        (nf,) rising lines [Hz], and PSDs (nf, n), linear between the lines and zero outside.
    natural, quality
        (m,) natural frequencies [Hz], and Q of the oscillators.
    """
    rms = np.empty((natural.size, psd.shape[1]))
    offset = np.tan(np.linspace(-WIDEST, WIDEST, ADDED)) / (2 * quality)
    for row, natural_frequency in enumerate(natural):
        lines = natural_frequency * (1 + offset)
        inside = (lines > frequency[0]) & (lines < frequency[-1])
        lines = np.union1d(frequency, lines[inside])
        values = np.stack([np.interp(lines, frequency, column) for column in psd.T], axis=1)
        weighted = gain(lines / natural_frequency, quality)[:, None] * values
        rms[row] = np.sqrt(np.trapezoid(weighted, lines, axis=0))
    return rms


def gain(ratio: Array, quality: float) -> Array:
    """Return |H|² of the absolute acceleration, at ratios of frequency to natural frequency."""
    damping = (ratio / quality) ** 2
    return (1 + damping) / ((1 - ratio**2) ** 2 + damping)


def miles(frequency: Array, psd: Array, natural: Array, quality: float) -> Array:
    """Return the rms acceleration of oscillators by Miles' equation, √(π/2 f_n Q S(f_n)).

    Parameters and result are the same as in `response_spectrum`. At a step of the PSD, S(f_n) is
    the mean of both sides; a natural frequency within `NEAR` of a step is at it.
    """
    sides = natural * np.array([[1 - NEAR], [1 + NEAR]])
    values = [np.interp(sides, frequency, column).mean(axis=0) for column in psd.T]
    psd_at_natural = np.stack(values, axis=1)
    return np.sqrt(np.pi / 2 * quality * natural[:, None] * psd_at_natural)
