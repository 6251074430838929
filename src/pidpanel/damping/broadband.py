"""C_e of tones, and errors of damping models, where a panel moves at all frequencies at once.

C_e from single tones is evaluated at the sine with the rms acceleration of the patch. Under sound
low frequencies keep a bed loose, so it dissipates less at high ones, and its own force drives the
panel. The errors are those against coupled runs of the paper's panel with acrylic and steel
(`benchmarks/single_tones.py`, `benchmarks/atlas_panels.py`, docs/theory/damping.md).
"""

from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array


class BroadbandError(NamedTuple):
    """Standard error of ln g rms that a damping model has under broadband motion."""

    of_effect: float  # share of the effect of the damping on ln g rms [1]
    of_rms: float  # part that does not depend on the effect [1]


# Coupled runs, whose errors contain it, and dampers that are linear.
EXACT = BroadbandError(0.0, 0.0)

# C_e from single tones: the effect is 30 % too large on average; far from the patch the force of
# the particles adds motion.
SINGLE_TONES = BroadbandError(0.4, 0.02)

# C_e from single tones with `broadband_stroke` and `broadband_share`; what is left of the
# difference. `LOG_DAMPING_ERROR` is that of ln C_e itself, common to all frequencies.
CORRECTED_TONES, LOG_DAMPING_ERROR = BroadbandError(0.12, 0.01), 0.25

# Constants of `broadband_stroke`: W/L from which the strokes of random motion are shorter than that
# of the tone, and up to which.
SHORTER_STROKE, LONGEST_STROKE = 0.6, 0.85

# Constants of `broadband_share`: ln of that of a full cell between riding and crossing, exponent of
# W/L of beds that ride, and W/L up to which they do; ln of that of beds that cross.
FULL, RIDING_EXPONENT, RIDING_STROKE, CROSSING = 0.25, 0.22, 0.1, 0.7

# Exponent of the steady acceleration in `floor_load`.
HEAVIER = 0.4

# Constants of `broadband_share_error`: of beds that cross, from about which W/L, which two levels
# of one scenario set; of beds whose floor load is not 1, that of all scenarios that set the share.
CROSSING_ERROR, CROSSING_STROKE, LOAD_ERROR = 0.25, 0.3, 0.3

PAPER_LAW = BroadbandError(0.0, 0.2)  # the paper's law, which does not depend on the motion


def broadband_stroke(stroke_per_gap: Array) -> Array:
    """Return W/L of the tone, with the same rms acceleration, whose C_e a bed has under sound [1].

    x/(1 + (x/0.6)/(1 + (x/0.85)²)) with x = W/L of the tone at the frequency itself. That tone has
    all of the acceleration at one frequency. Under sound the patch moves less than this at low
    frequencies, and its bed crosses the gap only in the largest of its random strokes.

    Examples
    --------
    >>> broadband_stroke(np.array([0.01, 0.1, 0.5, 1.0, 10.0])).round(3)
    array([0.01 , 0.086, 0.309, 0.589, 8.932])
    """
    shorter = stroke_per_gap / SHORTER_STROKE / (1 + (stroke_per_gap / LONGEST_STROKE) ** 2)
    return np.asarray(stroke_per_gap / (1 + shorter))


def floor_load(along: float, gravity: float) -> float:
    """Return how much the floor of its cell bears a bed [1]: 1 under 1 g along the motion.

    Parameters
    ----------
    along, gravity
        Steady acceleration of the bed along its motion, and in all [g].

    Examples
    --------
    >>> floor_load(1.0, 1.0), floor_load(0.0, 1.0), round(floor_load(4.0, 4.0), 2)
    (1.0, 0.0, 1.74)
    """
    return float(along / gravity * gravity**HEAVIER)


def broadband_share(
    stroke_per_gap: Array, fill_fraction: Array | float, load: float = 1.0
) -> Array:
    """Return C_e under sound over that of the tone with `broadband_stroke` W/L [1].

    It is s^(q√r) exp(−0.7 x²/(1 + x²)) with x = W/L, s = 0.78 (x/0.1)^0.22 below x = 0.1, and 0.78
    above; q is `floor_load`. A tone moves a riding bed little, while low frequencies of the sound
    keep it loose. The own force of the particles drives the panel, of full cells more than of
    nearly empty ones. Beds that slide on the walls of an upright cell do neither. Beds do not cross
    in phase with any frequency. Set on the coupled scenarios of benchmarks/coupled.md, counted on
    others (docs/theory/damping.md).

    Examples
    --------
    >>> broadband_share(np.array([1e-4, 0.01, 0.1, 1.0]), 0.5).round(2)
    array([0.29, 0.59, 0.83, 0.59])
    """
    riding = RIDING_EXPONENT * np.minimum(np.log(stroke_per_gap / RIDING_STROKE), 0.0) - FULL
    crossing = CROSSING * _crossing_part(stroke_per_gap)
    return np.asarray(np.exp(load * np.sqrt(fill_fraction) * riding - crossing))


def broadband_share_error(stroke_per_gap: Array, load: float) -> Array:
    """Return the standard error of ln of `broadband_share` [1], common to all frequencies.

    That of beds that cross, and of beds whose `floor_load` is not 1. The rest is in
    `CORRECTED_TONES`.

    Examples
    --------
    >>> broadband_share_error(np.array([0.01, 1.0, 10.0]), 1.0).round(2)
    array([0.  , 0.23, 0.25])
    """
    crossing = CROSSING_ERROR * _crossing_part(stroke_per_gap / CROSSING_STROKE)
    return np.hypot(crossing, LOAD_ERROR * (load - 1))


def _crossing_part(stroke_per_gap: Array) -> Array:
    """Return x²/(1 + x²) [1]."""
    return np.asarray(stroke_per_gap**2 / (1 + stroke_per_gap**2))
