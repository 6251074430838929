"""Error of a response due to the mesh: resonances that are too high.

Elements that are not much shorter than a wave are too stiff, so every resonance is too high by a
small share ε, more of it where a mode moves a part of the panel that is heavy with dampers: the
mean over the kinetic energy of the mode. To first order the PSD is then that of a panel whose
frequencies are stretched by 1 + ε; the error of a line is the difference that the stretch makes.
Amplitudes err too: a stiffness that is too high by 2ε moves less between resonances, and the shapes
differ by about ε. A peak drowns this, a mean square does not.
"""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array
from pidpanel.solve.lines import root_mean_square
from pidpanel.solve.sharpness import LoadedModes

# Largest stated error of a PSD at any line [dB], and of an rms acceleration [1]. What is stated is
# 1.2 to 3 times the difference from a converged mesh, so that PSDs are within 0.5 dB.
ALLOWED_DB, ALLOWED_RMS = 0.65, 5e-3

# Relative error of an rms acceleration over ε, besides that of shifted resonances. 0.33 % under a
# damper of 2000 N s/m³ on a sandwich of 30 elements, where ε is 0.11 %.
AMPLITUDE = 3.0
# Likewise with single points.
POINT_AMPLITUDE = 2.0


@dataclass(frozen=True)
class MeshShift:
    """Errors of resonances due to the mesh."""

    waves: Array  # (nf,) relative error of the resonance nearest to a line due to waves [1]
    points: Array  # (nf,) its decrease with elements of half the size due to single points [1]
    nearby: Array | float = 0.0  # (n_points,) relative change of the motion near such points [1]


@dataclass(frozen=True)
class MeshError:
    """Error that the mesh makes in the acceleration of points."""

    line: Array  # (n_points,) largest relative error of a PSD [1]
    rms: Array  # (n_points,) relative error of the rms acceleration [1]
    # (n_points,) its change with elements of half the size due to point supports and masses [1]
    point_rms: Array


def point_shifts(reactions: Array, angular_frequency: Array) -> Array:
    """Return by how much elements of half the size lower modes due to single points (n,) [1].

    Parameters
    ----------
    reactions
        (2, n_held, n) reactions of modes with a modal mass of 1 kg; see `PanelBasis`.
    angular_frequency
        (n,) [rad/s].
    """
    square = angular_frequency**2
    energy = np.sum((reactions[0] + square * reactions[1]) ** 2, axis=0)
    return np.divide(energy, square, out=np.zeros_like(square), where=square > 0)


def shift_of_modes(
    frequency: Array, modes: LoadedModes, bare: Array, patches: Array, points: Array
) -> tuple[Array, Array]:
    """Return the relative errors (nf,) of the resonance nearest to each line.

    The first is due to waves and does not fall with frequency, so modes at nearly the same
    frequency have the worst of their errors. The second is due to single points.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    modes
        Modes of the panel with its dampers.
    bare, patches
        (n,) and (n_patches, n) shift of waves at the frequencies of the modes, on the bare panel
        and on the patches.
    points
        (n,) shifts due to single points; see `point_shifts`.
    """
    remainder = np.maximum(1 - modes.share.sum(axis=0), 0.0)
    waves = np.maximum.accumulate(remainder * bare + np.sum(modes.share * patches, axis=0))
    if not waves.size:
        return np.zeros_like(frequency), np.zeros_like(frequency)
    midpoints = np.sqrt(modes.frequency[:-1] * modes.frequency[1:])
    nearest = np.searchsorted(midpoints, frequency)
    return waves[nearest], points[nearest]


def mesh_error(
    frequency: Array, psd: Array, input_psd: Array, shift: MeshShift, *, over_largest: bool = False
) -> MeshError:
    """Return the error of a response whose resonances are too high.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    psd
        (nf, n_points) of the acceleration.
    input_psd
        (nf,) of the pressure, whose steps stay where they are.
    shift
        Shift of the resonances of the panel with its dampers.
    over_largest
        Whether the error of a line is over the largest PSD of any point there. Under base motion a
        point that is nearly at rest has deep minima, whose shift does not matter.
    """
    largest = np.max(psd, axis=1)
    moves = np.all(psd > 0, axis=0)
    line, rms, point_rms = np.zeros((3, psd.shape[1]))
    for point in np.flatnonzero(moves):
        transfer = np.log(psd[:, point] / input_psd)
        share = psd[:, point] / largest if over_largest else 1.0
        ratio, change = _shifted(frequency, transfer, psd[:, point], shift.waves)
        line[point] = np.max(np.abs(np.log(ratio)) * share)
        rms[point] = change + AMPLITUDE * _mean(frequency, psd[:, point], shift.waves)
        if shift.points.any():
            _, change = _shifted(frequency, transfer, psd[:, point], shift.points)
            mean = _mean(frequency, psd[:, point], shift.points)
            point_rms[point] = change + POINT_AMPLITUDE * mean
    return MeshError(np.expm1(line), rms, np.where(moves, point_rms + shift.nearby, 0.0))


def _shifted(frequency: Array, transfer: Array, psd: Array, shift: Array) -> tuple[Array, float]:
    """Return the ratio (nf,) of a PSD whose resonances are lower, and the change of its rms."""
    log_f = np.log(frequency)
    raised = log_f + shift
    # beyond the last line the slope is that before it
    raised = np.where(raised > log_f[-1], log_f - shift, raised)
    ratio = np.exp(np.interp(raised, log_f, transfer) - transfer)
    squares = root_mean_square(frequency, np.stack([psd, ratio * psd], 1))
    return ratio, abs(float(squares[1] / squares[0]) - 1)


def _mean(frequency: Array, psd: Array, shift: Array) -> float:
    return float(np.trapezoid(shift * psd, frequency) / np.trapezoid(psd, frequency))


def decibels(relative_error: float) -> float:
    """Return a relative error of a PSD in dB."""
    return float(10 * np.log10(1 + relative_error))
