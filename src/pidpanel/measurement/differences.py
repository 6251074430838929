"""Computed and measured PSDs in third octaves."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.measurement.files import MeasuredPsd
from pidpanel.solve.bands import band_rms, whole_third_octaves

LEAST_SPAN = 10**0.1  # ratio of the ends of a common range that holds a third octave


class BandDifference(NamedTuple):
    """Mean PSDs of a band, and how much higher the computed one is [dB]."""

    center_hz: float
    lower_hz: float
    upper_hz: float
    measured: float
    computed: float
    difference_db: float
    difference_error_db: float


def common_range(measured: MeasuredPsd, low: float, high: float) -> tuple[float, float] | None:
    """Return the frequencies that a measurement and a range share [Hz]; None for no band."""
    low, high = max(low, measured.frequency[0]), min(high, measured.frequency[-1])
    return (low, high) if high >= LEAST_SPAN * low else None


def band_differences(
    measured: MeasuredPsd, frequency: Array, psd: Array, log_error: Array | None = None
) -> Iterator[BandDifference]:
    """Yield the third octaves of the frequencies that both have.

    Parameters
    ----------
    frequency, psd
        (nf,) computed [Hz], in the unit of the measured one.
    log_error
        (nf,) standard error of ln of the PSD, correlated over the lines; None without one.
    """
    both = common_range(measured, float(frequency[0]), float(frequency[-1]))
    if both is None:
        return
    center, edge = whole_third_octaves(*both)
    width = np.diff(edge, axis=1)[:, 0]
    of_test = band_rms(measured.frequency, measured.psd, edge) ** 2 / width
    computed = band_rms(frequency, psd, edge) ** 2 / width
    error = np.full(width.size, np.nan)
    if log_error is not None and np.isfinite(log_error).all():
        with np.errstate(invalid="ignore"):
            error = band_rms(frequency, psd * log_error, edge) ** 2 / width / computed
    with np.errstate(divide="ignore", invalid="ignore"):
        decibels = 10 * np.log10(computed / of_test)
    columns = (center, *edge.T, of_test, computed, decibels, 10 / np.log(10) * error)
    yield from map(BandDifference._make, np.stack(columns, axis=1).tolist())
