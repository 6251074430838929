"""Base-10 fractional-octave bands by their numbers (IEC 61260-1:2014, 5.2 to 5.5).

Band number N has the exact centre 10^(N/10) Hz: N = 30 is 1 kHz. Octaves have the numbers that
are multiples of 3 and are three third octaves wide.
"""

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array


def center_frequency(number: ArrayLike) -> Array:
    """Return the exact centres 10^(N/10) [Hz].

    Parameters
    ----------
    number
        Band numbers N, of any shape.

    Examples
    --------
    >>> center_frequency([20, 21]).round(1).tolist()
    [100.0, 125.9]
    """
    return 10.0 ** (np.asarray(number) / 10)


def edge_frequency(number: ArrayLike, width: int = 1) -> Array:
    """Return the exact edges 10^((N ± width/2)/10) [Hz] of each band.

    Parameters
    ----------
    number
        (n,) band numbers N.
    width
        Third octaves in a band: 1, or 3 for an octave.

    Returns
    -------
    (n, 2) lower and upper edges. Those of adjoining bands are the same numbers.

    Examples
    --------
    >>> edge_frequency([27, 30], width=3).round(1).tolist()
    [[354.8, 707.9], [707.9, 1412.5]]
    """
    half = width / 2
    return 10.0 ** ((np.asarray(number)[:, None] + np.array([-half, half])) / 10)
