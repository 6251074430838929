"""Sharpness of the resonances of a loaded panel, and the lines on their flanks.

A mass that does not damp lowers the damping ratio of what it loads: with m″ + m_a in place of m″
all over the panel that of a mode is ζ/√(1 + m_a/m″).
"""

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from pidpanel.arrays import Array, Index
from pidpanel.solve.model import ModalBasis


class LoadedModes(NamedTuple):
    """Modes of a panel with masses on its patches."""

    frequency: Array  # (n,) [Hz], ascending
    damping_ratio: Array  # (n,) [1]; infinite of a rigid body's mode
    share: Array  # (n_patches, n) of the kinetic energy, panel and mass [1]
    shape: Array  # (n_shapes, n) in the shapes of the bare panel, of a modal mass of 1 kg


def loaded_modes(
    modal: ModalBasis, overlap: Array, mass: Array, mass_per_area: float
) -> LoadedModes:
    """Return the modes of a panel with masses on its patches, in the shapes of the bare panel.

    Parameters
    ----------
    modal, overlap, mass
        Same as in `least_damping_ratio`.
    mass_per_area
        Mass of the panel per area [kg/m²].
    """
    loaded = np.diag(modal.modal_mass) + np.tensordot(mass, overlap, 1)
    square, shape = la.eigh(np.diag(modal.modal_mass * modal.angular_frequency**2), loaded)
    omega = np.sqrt(np.maximum(square, 0.0))
    damping = np.sum(modal.damping[:, None] * shape**2, axis=0)
    ratio = np.divide(damping, 2 * omega, out=np.full(omega.shape, np.inf), where=omega > 0)
    moved = np.array([np.sum(shape * (D @ shape), axis=0) for D in overlap])
    share = (mass_per_area + mass)[:, None] * moved.reshape(len(mass), len(omega))
    return LoadedModes(omega / (2 * np.pi), ratio, share, shape)


def least_damping_ratio(
    modal: ModalBasis, overlap: Array, mass: Array, frequency_range: tuple[float, float]
) -> float:
    """Return the smallest ζ of a mode with masses on the patches, at most that of the bare panel.

    Parameters
    ----------
    overlap
        (n_patches, n, n) D_p [m²].
    mass
        (n_patches,) [kg/m²].
    frequency_range
        Frequency range of the modes [Hz].

    Examples
    --------
    >>> modal = ModalBasis([20.0, 50.0], [1.0, 1.0], 0.01)
    >>> whole = np.eye(2)[None] / 4.0  # of a panel of 4 kg/m²
    >>> round(least_damping_ratio(modal, whole, np.array([12.0]), (10.0, 100.0)), 6)
    0.005
    """
    modes = loaded_modes(modal, overlap, mass, 0.0)
    low, high = frequency_range
    inside = (modes.frequency >= low) & (modes.frequency <= high)
    bare = float(modal.damping_ratio.max(initial=0.0))
    return float(np.min(modes.damping_ratio[inside], initial=bare))


def flanks(frequency: Array, psd: Sequence[Array], damping_ratio: float, count: int) -> Array:
    """Return lines half a bandwidth off peaks, where a shifted resonance shows most.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    psd
        (nf, n_points) of each scenario.
    count
        Most lines; the peaks of highest frequency come first, in turns from every scenario.
    """
    lines: list[float] = []
    peaks = [frequency[_peaks(values)][::-1].tolist() for values in psd]
    for peak in itertools.chain(*itertools.zip_longest(*peaks)):
        if peak is not None:
            side = 1 if peak * (1 + damping_ratio) < frequency[-1] else -1
            line = peak * (1 + side * damping_ratio)
            if all(abs(line / earlier - 1) > damping_ratio for earlier in lines):
                lines.append(line)
    return np.array(lines[:count])


def _peaks(psd: Array) -> Index:
    """Return the lines (n,) at which the mean over the points has a peak, including the ends."""
    mean = np.pad(np.sum(psd / np.maximum(psd.max(axis=0), 1e-300), axis=1), 1)
    return np.flatnonzero((mean[1:-1] > mean[:-2]) & (mean[1:-1] >= mean[2:]))
