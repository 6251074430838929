"""Excess kurtosis and damage of the accelerations in records, over those of a Gaussian motion.

Beds that ride leave the panel Gaussian. Beds that are thrown now and then do not: their panel moves
with bursts, whose peaks exceed those of a Gaussian motion of the same PSD (`severity.kurtosis`).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupled.segments import SettledRecord

# Second derivative from nine rows, exact to the eighth order: ten rows a period of the highest
# frequency leave 1e-5 of it.
SECOND_DERIVATIVE = (-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72)

ORDER = 6  # of the filter that leaves the frequencies of the response
LEFT_OUT = 0.01  # share of the rows at the end, where the filter has no rows after them

BLOCKS = 10  # of each record, for the jackknife
EXPONENTS = (4, 8, 12)  # of S-N lines at which damage is known
SURROGATES = 20  # records of random phases for each record


class RecordedBursts(NamedTuple):
    """How far the accelerations at the points are from Gaussian ones."""

    kurtosis: Array  # (p,) excess [1]
    kurtosis_error: Array  # standard error
    # (len(EXPONENTS), p) ln of the damage over that of a Gaussian motion with the same spectrum
    damage: Array
    damage_error: Array


def bursts_of(records: Sequence[SettledRecord]) -> RecordedBursts:
    """Return the bursts in records; errors are those of the jackknife (Efron and Stein 1981).

    Damage goes with the moment of the order b of the acceleration. That of the Gaussian motion is
    the mean over records with the same amplitudes and random phases: they have as few cycles.
    """
    rng = np.random.default_rng(0)
    accelerations = [_accelerations(record) for record in records]
    blocks = [b for a in accelerations for b in np.array_split(a, BLOCKS)]
    surrogates = [_random_phases(a, rng) for a in accelerations for _ in range(SURROGATES)]
    kurtosis, kurtosis_error = _moment(blocks, 4.0)
    moments = [_moment(blocks, order) for order in EXPONENTS]
    gaussian = [
        np.mean([_moment([record], order)[0] for record in surrogates], axis=0)
        for order in EXPONENTS
    ]
    values, errors = (np.array(part) for part in zip(*moments, strict=True))
    damage = np.log(values / np.array(gaussian))
    return RecordedBursts(kurtosis - 3, kurtosis_error, damage, errors / values)


def _moment(blocks: Sequence[Array], order: float) -> tuple[Array, Array]:
    """Return the moment of an order over the rms to that power, and its standard error, (p,)."""
    high, square = (np.array([np.mean(np.abs(b) ** n, axis=0) for b in blocks]) for n in (order, 2))
    count = len(blocks)

    def ratio(high: Array, square: Array) -> Array:
        return np.asarray(high / square ** (order / 2))

    reduced = [(m.sum(axis=0) - m) / max(count - 1, 1) for m in (high, square)]
    error = np.sqrt((count - 1) * np.var(ratio(*reduced), axis=0)) if count > 1 else np.zeros(1)
    return ratio(high.mean(axis=0), square.mean(axis=0)), error


def _random_phases(acceleration: Array, rng: np.random.Generator) -> Array:
    """Return a record (m, p) with the same amplitudes and other phases."""
    spectrum = np.fft.rfft(acceleration, axis=0)
    turned = spectrum * np.exp(2j * np.pi * rng.random((len(spectrum), 1)))
    return np.fft.irfft(turned, len(acceleration), axis=0)


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
