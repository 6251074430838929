"""C_e of tones, and errors of damping models, where a panel moves at all frequencies at once.

C_e from single tones is evaluated at the sine with the rms acceleration of the patch. Under sound
low frequencies keep a bed loose, so it dissipates less at high ones, and its own force drives the
panel. The errors are those against coupled runs of 22 scenarios of the paper's panel with
acrylic and steel (`benchmarks/single_tones.py`, docs/theory/damping.md).
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

# C_e from single tones times `broadband_share`; what is left of the difference.
CORRECTED_TONES = BroadbandError(0.25, 0.02)

# Constants of `broadband_share`: exponent (acrylic 0.21, steel 0.16), and W/L from which it is 1.
RIDING_EXPONENT, RIDING_STROKE = 0.19, 0.1

PAPER_LAW = BroadbandError(0.0, 0.2)  # the paper's law, which does not depend on the motion


def broadband_share(stroke_per_gap: Array) -> Array:
    """Return C_e under sound over that of the tone with the same rms acceleration and W/L [1].

    (W/0.1L)^0.19 below W/L = 0.1: there a tone moves the bed little, while low frequencies of the
    sound keep it loose. Set on 22 coupled scenarios, counted on six more (docs/theory/damping.md).

    Examples
    --------
    >>> broadband_share(np.array([1e-4, 0.01, 0.1, 1.0])).round(2)
    array([0.27, 0.65, 1.  , 1.  ])
    """
    return np.asarray(np.minimum((stroke_per_gap / RIDING_STROKE) ** RIDING_EXPONENT, 1.0))
