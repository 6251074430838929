"""Excess kurtosis of the accelerations in records: 0 of a Gaussian motion.

Beds that ride leave the panel Gaussian. Beds that are thrown now and then do not: their panel moves
with bursts, whose peaks exceed those of a Gaussian motion of the same PSD (`severity.kurtosis`).
"""

from collections.abc import Sequence

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupled.segments import SettledRecord

# Second derivative from nine rows, exact to the eighth order: ten rows a period of the highest
# frequency leave 1e-5 of it.
SECOND_DERIVATIVE = (-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72)

ORDER = 6  # of the filter that leaves the frequencies of the response
LEFT_OUT = 0.01  # share of the rows at the end, where the filter has no rows after them

BLOCKS = 10  # of each record, for the jackknife


def excess_kurtosis(records: Sequence[SettledRecord]) -> tuple[Array, Array]:
    """Return the excess kurtosis of the acceleration at the points and its standard error, (p,).

    The error is that of the jackknife over blocks of the records (Efron and Stein 1981).
    """
    blocks = [b for r in records for b in np.array_split(_accelerations(r), BLOCKS)]
    fourth, square = (np.array([np.mean(b**n, axis=0) for b in blocks]) for n in (4, 2))
    count = len(blocks)
    without = [
        (fourth.sum(axis=0) - f) * (count - 1) / (square.sum(axis=0) - s) ** 2
        for f, s in zip(fourth, square, strict=True)
    ]
    kurtosis = fourth.mean(axis=0) / square.mean(axis=0) ** 2
    return kurtosis - 3, np.sqrt((count - 1) * np.var(without, axis=0))


def _accelerations(record: SettledRecord) -> Array:
    """Return the accelerations (m, p) [m/s²] in the frequencies of the tones, once settled."""
    from scipy.signal import butter, sosfiltfilt  # slow to import

    weights = np.array([*SECOND_DERIVATIVE, *SECOND_DERIVATIVE[-2::-1]]) / record.interval**2
    windows = np.lib.stride_tricks.sliding_window_view(record.at_points, weights.size, axis=0)
    band = record.frequency[[0, -1]]
    filter_ = butter(ORDER, band, "bandpass", fs=1 / record.interval, output="sos")
    filtered = sosfiltfilt(filter_, windows @ weights, axis=0)
    end = round((1 - LEFT_OUT) * len(filtered))
    return np.asarray(filtered[record.settled : end])
