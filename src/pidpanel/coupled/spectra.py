"""Spectra of overlapping segments of a record (Welch 1967)."""

from typing import TypeVar

import numpy as np

from pidpanel.arrays import Array, Complexes

Values = TypeVar("Values", Array, Complexes)


def segment_spectra(
    rows: Array, interval: float, length: int, band: tuple[float, float]
) -> tuple[Array, Complexes]:
    """Return the spectra of the columns of a record in Hann windows that overlap by half.

    The lines (nf,) [Hz], and the Fourier coefficients (segments, nf, columns) [unit/√Hz], e^{iωt},
    scaled so that the mean of |x|² is a PSD.
    """
    window = np.hanning(length + 2)[1:-1]
    scale = np.sqrt(2 * interval / (window @ window))
    frequency = np.fft.rfftfreq(length, interval)
    inside = (frequency >= band[0]) & (frequency < band[1])
    last = len(rows) - length
    count = max(1, 2 * len(rows) // length - 1)  # they overlap by half
    values = []
    for start in np.linspace(0, last, count).round().astype(int):
        part = rows[start : start + length]
        tapered = (part - part.mean(axis=0)) * window[:, None]
        values.append(np.fft.rfft(tapered, axis=0)[inside] * scale)
    return np.asarray(frequency[inside], dtype=np.float64), np.array(values)


def pressure_segments(
    impulse: Array, interval: float, length: int, band: tuple[float, float]
) -> Complexes:
    """Return the spectra of the force per area whose impulse since the start is given.

    The difference of two rows is the mean over the time between them: sinc(fΔ) times a tone half
    an interval later.
    """
    frequency, mean = segment_spectra(np.diff(impulse, axis=0) / interval, interval, length, band)
    delay = frequency * interval
    factor = np.exp(-1j * np.pi * delay) / np.sinc(delay)
    return mean * factor[:, None]


def band_sums(frequency: Array, values: Values, edge: Array, axis: int = 0) -> Values:
    """Return the sums over the lines of each band."""
    moved: Array | Complexes = np.moveaxis(values, axis, 0)
    cumulative = np.concatenate([np.zeros((1, *moved.shape[1:])), np.cumsum(moved, axis=0)])
    index = np.searchsorted(frequency, edge)
    sums = cumulative[index[:, 1]] - cumulative[index[:, 0]]
    return np.moveaxis(sums, 0, axis)
