"""Errors of damping models where a panel moves at all frequencies at once.

C_e from single tones is read at the sine with the rms acceleration of the patch. Under sound low
frequencies keep a bed loose, so it dissipates less at high ones, and its own force drives the
panel. The errors are counted against coupled runs of 22 scenarios of the paper's panel with
acrylic and steel (`benchmarks/single_tones.py`, docs/damping_models.md).
"""

from typing import NamedTuple


class BroadbandError(NamedTuple):
    """Standard error of ln g rms that a damping model has under broadband motion."""

    of_effect: float  # share of the effect of the damping on ln g rms [1]
    of_rms: float  # part that does not depend on the effect [1]


# Coupled runs, whose errors contain it, and dampers that are linear.
EXACT = BroadbandError(0.0, 0.0)

# C_e from single tones: the effect is 30 % too large on average; far from the patch the force of
# the particles adds motion.
SINGLE_TONES = BroadbandError(0.4, 0.02)

PAPER_LAW = BroadbandError(0.0, 0.2)  # the paper's law, which does not depend on the motion
