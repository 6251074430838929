"""Third-octave bands: rms of a response in each, and how much of it a damper takes."""

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.spectra.third_octaves import center_frequency, edge_frequency


def third_octaves(low: float, high: float) -> tuple[Array, Array]:
    """Return third octaves with centres 10^(N/10) from ``low`` to ``high`` (IEC 61260-1).

    Returns
    -------
    centre
        (n,) [Hz].
    edge
        (n, 2) [Hz], 10^((N ± 0.5)/10), cut at ``low`` and ``high``.

    Examples
    --------
    >>> centre, edge = third_octaves(100.0, 130.0)
    >>> centre.round(1), edge.round(1)
    (array([100. , 125.9]), array([[100. , 112.2],
           [112.2, 130. ]]))
    """
    first = np.ceil(10 * np.log10(low) - 1e-9)
    last = np.floor(10 * np.log10(high) + 1e-9)
    number = np.arange(first, last + 1)
    return center_frequency(number), np.clip(edge_frequency(number), low, high)


def whole_third_octaves(low: float, high: float) -> tuple[Array, Array]:
    """Return `third_octaves`; the first begins at ``low`` and the last ends at ``high``.

    The bands then hold all of a response: also what lies beyond the outer edges of those bands.

    Examples
    --------
    >>> _, edge = whole_third_octaves(90.0, 140.0)
    >>> edge.round(1)
    array([[ 90. , 112.2],
           [112.2, 140. ]])
    """
    centre, edge = third_octaves(low, high)
    edge[0, 0], edge[-1, 1] = low, high
    return centre, edge


def band_rms(frequency: Array, psd: Array, edge: Array) -> Array:
    """Return the root mean square of a PSD in each band, √∫ S df.

    The PSD is taken as linear between its lines, so bands that adjoin add up to the whole.

    Parameters
    ----------
    frequency
        (nf,) rising [Hz].
    psd
        (nf, …) one-sided [unit²/Hz].
    edge
        (n, 2) [Hz], within ``frequency``.

    Returns
    -------
    (n, …) unit.

    Examples
    --------
    >>> f = np.array([0.0, 1.0, 4.0])
    >>> band_rms(f, np.full(3, 9.0), np.array([[0.0, 1.0], [1.0, 2.0]]))
    array([3., 3.])
    """
    lines = np.union1d(frequency, edge)
    flat = psd.reshape(len(frequency), -1)
    fine = np.stack([np.interp(lines, frequency, column) for column in flat.T], axis=1)
    steps = np.diff(lines)[:, None] * (fine[1:] + fine[:-1]) / 2
    cumulative = np.concatenate([np.zeros((1, flat.shape[1])), np.cumsum(steps, axis=0)])
    place = np.searchsorted(lines, edge)
    mean_square = cumulative[place[:, 1]] - cumulative[place[:, 0]]
    return np.sqrt(mean_square).reshape(len(edge), *psd.shape[1:])


def reduction(bare: ArrayLike, treated: ArrayLike) -> Array:
    """Return 20 lg(bare/treated), dB: positive where the damper lowers the response.

    Parameters
    ----------
    bare, treated
        Rms values of one unit, of shapes that go together.

    Examples
    --------
    >>> float(reduction(10.0, 1.0)), float(reduction(0.0, 0.0))
    (20.0, 0.0)

    Notes
    -----
    0 where neither moves, as at a support: there is nothing to lower.
    """
    bare_rms, treated_rms = np.broadcast_arrays(np.asarray(bare, float), np.asarray(treated, float))
    at_rest = (bare_rms == 0) & (treated_rms == 0)
    ratio: Array = np.where(at_rest, 1.0, bare_rms) / np.where(at_rest, 1.0, treated_rms)
    return 20 * np.log10(ratio)
