"""States of motion in which the cells of a case end, and the share of each.

Where the stroke is a tenth to half of the clear gap, a bed can stay in one of several motions under
the same drive: it rides, or it crosses the gap in step with the drive, once in one, two or three
cycles. Which one a cell ends in depends on its packing and on where it comes from. Acrylic at
r = 0.5, 100 Hz, 80 g, one cell, six packings: from rest η ends at 0.05, 0.10 (three times) and
between 0.15 and 0.25 (twice), from a bed that was shaken hard at 0.05 (five times) and 0.15; each
was there after 150 cycles at the latest. A mean with the scatter of two runs hides that.
"""

import numpy as np

from pidpanel.arrays import Array, Flags, Index

# Share of their mean by which two values differ that are in different states of motion [1];
# packings of few spheres alone differ by a tenth (11 of about 85 cases of the paper's study by four
# standard errors or more; ten of them by 2 to 12 % of their mean, one by 44 %).
MARGIN = 0.25

ERRORS = 4.0  # standard errors of their difference by which they differ [1]


def are_separated(low: Array, low_error: Array, high: Array, high_error: Array) -> Flags:
    """Return whether values (n,) belong to other states than lower ones (n,)."""
    difference = high - low
    far = difference > MARGIN * np.abs(high + low) / 2
    return far & (difference > ERRORS * np.hypot(low_error, high_error))


def states_of(means: Array, errors: Array) -> list[Index]:
    """Return the indices of the values of each state, from the lowest state to the highest.

    Neighbours in order of size that are not apart are of one state.

    Examples
    --------
    >>> [state.tolist() for state in states_of(np.array([1.0, 3.0, 1.1]), np.full(3, 0.1))]
    [[0, 2], [1]]
    """
    order = np.argsort(means, kind="stable")
    means, errors = means[order], errors[order]
    cuts = are_separated(means[:-1], errors[:-1], means[1:], errors[1:])
    return np.split(order, 1 + np.flatnonzero(cuts))


def farthest(means: Array, states: list[Index]) -> float:
    """Return the largest distance of the mean of a state from that of all; 0 for a single state.

    Parameters
    ----------
    means
        (n,) mean of each cell.
    states
        Cells of each state, from `states_of`.
    """
    if len(states) == 1:
        return 0.0
    return max(abs(float(means[state].mean() - means.mean())) for state in states)
