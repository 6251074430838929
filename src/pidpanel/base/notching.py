"""Notches of a random input: as little less as keeps all limits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index

HALVINGS = 80  # of the range of a cap on a PSD: it is then exact to rounding

ROUNDS = 50  # most rounds over the limits of overall values, each of which depends on the others


@dataclass(frozen=True)
class Limit:
    """A limit of a PSD or of an overall value, in units of one location."""

    location: int  # index of the location among those whose gains are given
    reason: str  # the limit in words, such as "point 326: 0.5 g²/Hz"
    value: float  # largest PSD, or largest rms value
    is_rms: bool = False  # whether it is that of the overall value


@dataclass(frozen=True)
class NotchedInput:
    """A random input and why it is lower than stated."""

    psd: Array  # (nf,) of the input, at most that stated
    reason: Index  # (nf,) index of the limit that holds; −1 where there is no notch


def notched(frequency: Array, psd: Array, gain: Array, limits: Sequence[Limit]) -> NotchedInput:
    """Return the input that keeps all limits.

    A limit of a PSD c allows an input of c/|H|². One of an overall value becomes the highest cap on
    the PSD there under which the overall value is kept, given all other limits: the highest peaks
    are lowered.

    Parameters
    ----------
    frequency, psd
        (nf,) [Hz] and the stated input.
    gain
        (n_locations, nf) |H|² of each location.
    """
    caps = np.array([np.inf if limit.is_rms else limit.value for limit in limits])
    gains = gain[[limit.location for limit in limits]]
    for _ in range(ROUNDS):
        before = caps.copy()
        for index in [index for index, limit in enumerate(limits) if limit.is_rms]:
            caps[index] = np.inf
            lowest = np.minimum(psd, (caps[:, None] / gains).min(axis=0))
            caps[index] = _cap(frequency, gains[index] * lowest, limits[index].value)
        if np.allclose(caps, before, rtol=1e-9, atol=0.0):
            break
    allowed = caps[:, None] / gains
    lowest = np.minimum(psd, allowed.min(axis=0))
    return NotchedInput(lowest, np.where(lowest < psd, allowed.argmin(axis=0), -1))


def _cap(frequency: Array, psd: Array, rms: float) -> float:
    """Return the cap c with ∫ min(S, c) df = rms²; infinite where the rms value is kept."""
    if np.trapezoid(psd, frequency) <= rms**2:
        return np.inf
    low, high = 0.0, float(psd.max())
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if np.trapezoid(np.minimum(psd, middle), frequency) > rms**2:
            high = middle
        else:
            low = middle
    return low
