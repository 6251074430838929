"""Comparison of damping models with panel and particles in one time integration.

A model holds for a scenario at a point if its g rms is within `RMS_LIMIT` of the coupled run and
every third octave within `BAND_DEPTH` of the highest is within `BAND_LIMIT`. The outcome is open if
the interval of two standard errors of the coupled run includes a limit.
"""

from collections.abc import Collection
from typing import Literal, NamedTuple

import numpy as np

from pidpanel.arrays import Array

RMS_LIMIT = 0.03  # largest relative difference of g rms [1]

BAND_LIMIT = 0.5  # largest difference of the rms of a third octave [dB]

BAND_DEPTH = 20.0  # third octaves further below the highest are ignored [dB]

Holds = Literal["yes", "no", "open"]


class CoupledRun(NamedTuple):
    """A point of a coupled run."""

    rms: float  # [g]
    rms_error: float  # [g]
    band_rms: Array  # (n,) of third octaves [g]
    band_error_db: Array  # (n,) [dB]


class Distance(NamedTuple):
    """Difference between a damping model and the coupled run at a point, named as in the table."""

    difference: float  # g rms over that of the coupled run, less 1
    coupled_g_rms_relative_error: float  # standard error of the coupled run
    band: int  # index of the third octave with the largest difference
    band_difference_db: float  # its difference [dB]
    band_error_db: float  # [dB]
    holds: Holds  # whether both are within their limits


def distance(rms: float, band_rms: Array, coupled: CoupledRun) -> Distance:
    """Return the difference between a damping model and a coupled run.

    Examples
    --------
    >>> run = CoupledRun(10.0, 0.05, np.array([8.0, 6.0, 0.01]), np.array([0.1, 0.1, 0.1]))
    >>> offset = distance(10.1, np.array([8.0, 6.2, 0.02]), run)
    >>> offset.band, round(offset.band_difference_db, 2), offset.holds
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
        combined(outcomes),
    )  # fmt: skip


def combined(outcomes: Collection[Holds]) -> Holds:
    """Return the combined outcome: no outweighs open, and open outweighs yes."""
    return "no" if "no" in outcomes else "open" if "open" in outcomes else "yes"


def _holds(gap: float, error: float, limit: float) -> Holds:
    if abs(gap) + 2 * error <= limit:
        return "yes"
    return "no" if abs(gap) - 2 * error > limit else "open"
