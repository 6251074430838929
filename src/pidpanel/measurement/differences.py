"""Computed and measured PSDs in third octaves."""

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.measurement.files import PSD_COLUMN, MeasuredPsd
from pidpanel.solve.bands import band_rms, whole_third_octaves

LEAST_SPAN = 10**0.1  # ratio of the ends of a common range that holds a third octave


def common_range(measured: MeasuredPsd, low: float, high: float) -> tuple[float, float] | None:
    """Return the frequencies that a measurement and a range share [Hz]; None for no band."""
    low, high = max(low, measured.frequency[0]), min(high, measured.frequency[-1])
    return (low, high) if high >= LEAST_SPAN * low else None


def band_differences(
    measured: MeasuredPsd, frequency: Array, psd: Array, log_error: Array | None = None
) -> pd.DataFrame:
    """Return a row for each third octave of the frequencies that both have.

    Of a PSD the means of both, of a transmissibility the rms, and how much higher the computed one
    is [dB].

    Parameters
    ----------
    frequency, psd
        (nf,) computed [Hz], in the unit of the measured one.
    log_error
        (nf,) standard error of ln of the PSD, correlated over the lines; None without one.
    """
    shared = common_range(measured, float(frequency[0]), float(frequency[-1]))
    if shared is None:
        return pd.DataFrame()
    center, edge = whole_third_octaves(*shared)
    lower, upper = edge.T
    test_psd = band_rms(measured.frequency, measured.psd, edge) ** 2 / (upper - lower)
    computed = band_rms(frequency, psd, edge) ** 2 / (upper - lower)
    error = np.full(lower.size, np.nan)
    if log_error is not None and np.isfinite(log_error).all():
        with np.errstate(invalid="ignore"):
            error = band_rms(frequency, psd * log_error, edge) ** 2 / (upper - lower) / computed
    with np.errstate(divide="ignore", invalid="ignore"):
        decibels = 10 * np.log10(computed / test_psd)
    power, end = (1.0, "psd_g2_hz") if measured.column == PSD_COLUMN else (0.5, measured.column)
    return pd.DataFrame(
        {
            "center_hz": center,
            "lower_hz": lower,
            "upper_hz": upper,
            f"measured_{end}": test_psd**power,
            f"computed_{end}": computed**power,
            "difference_db": decibels,
            "difference_error_db": 10 / np.log(10) * error,
        }
    )
