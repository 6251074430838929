"""How far a reading of the damping is from panel and particles in one time integration.

A reading holds a scenario at a point where its g rms is within `RMS_LIMIT` of the coupled one and
every third octave within `BAND_DEPTH` of the highest is within `BAND_LIMIT`. Where an error of the
coupled run, twice, could decide either way, it is said that this is open.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pidpanel.arrays import Array

RMS_LIMIT = 0.03
"""Of g rms [1]."""

BAND_LIMIT = 0.5
"""Of the rms of a third octave [dB]."""

BAND_DEPTH = 20.0
"""Third octaves further below the highest do not count [dB]."""

Holds = Literal["yes", "no", "open"]


@dataclass(frozen=True)
class Coupled:
    """A point of a coupled run.

    Attributes
    ----------
    rms, rms_error
        g rms and its standard error.
    band_rms, band_error_db
        (n,) of third octaves, g rms and standard error [dB].
    """

    rms: float
    rms_error: float
    band_rms: Array
    band_error_db: Array


@dataclass(frozen=True)
class Distance:
    """How far a reading is from the coupled run at a point.

    Attributes
    ----------
    rms
        g rms over that of the coupled run, less 1 [1].
    rms_error
        Standard error of that, of the coupled run.
    band
        Index of the third octave that is furthest off.
    band_db, band_error_db
        How far it is off, and the standard error of that [dB].
    holds
        Whether both are within their limits.
    """

    rms: float
    rms_error: float
    band: int
    band_db: float
    band_error_db: float
    holds: Holds


def distance(rms: float, band_rms: Array, coupled: Coupled) -> Distance:
    """Return how far a reading is from a coupled run.

    Parameters
    ----------
    rms, band_rms
        g rms of the reading, as a whole and (n,) in third octaves.
    coupled
        The run.

    Examples
    --------
    >>> run = Coupled(10.0, 0.05, np.array([8.0, 6.0, 0.01]), np.array([0.1, 0.1, 0.1]))
    >>> found = distance(10.1, np.array([8.0, 6.2, 0.02]), run)
    >>> found.band, round(found.band_db, 2), found.holds
    (1, 0.28, 'yes')
    """
    counts = coupled.band_rms >= 10 ** (-BAND_DEPTH / 20) * coupled.band_rms.max()
    gap = np.zeros(counts.shape)
    gap[counts] = 20 * np.log10(band_rms[counts] / coupled.band_rms[counts])
    band = int(np.argmax(np.abs(gap)))
    relative, error = rms / coupled.rms - 1, coupled.rms_error / coupled.rms
    outcomes = {
        _holds(relative, error, RMS_LIMIT),
        *(
            _holds(value, error_db, BAND_LIMIT)
            for value, error_db in zip(gap[counts], coupled.band_error_db[counts], strict=True)
        ),
    }
    return Distance(
        float(relative), float(error), band, float(gap[band]), float(coupled.band_error_db[band]),
        "no" if "no" in outcomes else "open" if "open" in outcomes else "yes",
    )  # fmt: skip


def _holds(gap: float, error: float, limit: float) -> Holds:
    if abs(gap) + 2 * error <= limit:
        return "yes"
    return "no" if abs(gap) - 2 * error > limit else "open"
