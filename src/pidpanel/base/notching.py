"""Notching of a random input: the smallest reduction that meets all limits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index

HALVINGS = 80  # bisections for a cap on a PSD: it is then exact to rounding

ROUNDS = 50  # most rounds over the limits of overall values, which depend on each other


@dataclass(frozen=True)
class Limit:
    """A limit of a PSD or of an overall value, in units of one location."""

    location: int  # index of the location among the given gains
    reason: str  # the limit in words, such as "point 326: 0.5 g²/Hz"
    value: float  # largest PSD, or largest rms value
    is_rms: bool = False  # whether the limit is on the overall value


@dataclass(frozen=True)
class NotchedInput:
    """A notched random input and the reasons for its notches."""

    psd: Array  # (nf,) PSD of the input, at most that stated
    reason: Index  # (nf,) index of the limit that applies; −1 where there is no notch


def notched(frequency: Array, psd: Array, gain: Array, limits: Sequence[Limit]) -> NotchedInput:
    """Return the input reduced until all limits are met.

    A limit c of a PSD allows an input of c/|H|². A limit of an overall value becomes the highest
    cap on the PSD at that location with which it is met, given all other limits: the highest peaks
    are lowered.

    Parameters
    ----------
    frequency, psd
        (nf,) frequencies [Hz] and stated input.
    gain
        (n_locations, nf) |H|² of each location.
    limits
        Limits in the unit of each location.
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
    """Return the cap c with ∫ min(S, c) df = rms²; infinite if the rms value is met without."""
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
