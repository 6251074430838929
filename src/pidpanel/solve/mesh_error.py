"""What the mesh does to a response: resonances that are too high.

Elements that are not small beside a wave are too stiff, so that every resonance is too high by a
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


@dataclass(frozen=True)
class MeshError:
    """Error that the mesh makes in the acceleration of points."""

    line: Array  # (n_points,) largest relative error of a PSD [1]
    rms: Array  # (n_points,) relative error of the rms acceleration [1]


def shift_of_modes(frequency: Array, modes: LoadedModes, bare: Array, patches: Array) -> Array:
    """Return the share (nf,) by which the resonance nearest to each line is too high.

    Never less than below: of modes at nearly the same frequency the worst counts.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    modes
        Of the panel with its dampers.
    bare, patches
        (n,) and (n_patches, n) shift of waves at the frequencies of the modes, on the bare panel
        and on the patches.
    """
    rest = np.maximum(1 - modes.share.sum(axis=0), 0.0)
    shift = np.maximum.accumulate(rest * bare + np.sum(modes.share * patches, axis=0))
    if not shift.size:
        return np.zeros_like(frequency)
    between = np.sqrt(modes.frequency[:-1] * modes.frequency[1:])
    found: Array = shift[np.searchsorted(between, frequency)]
    return found


def mesh_error(
    frequency: Array, psd: Array, input_psd: Array, shift: Array, *, over_largest: bool = False
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
        (nf,) [1].
    over_largest
        Whether the error of a line is over the largest PSD of any point there: under base motion a
        point that is nearly at rest has deep minima, whose shift changes nothing.
    """
    largest = np.max(psd, axis=1)
    moves = np.all(psd > 0, axis=0)
    line, rms = np.zeros((2, psd.shape[1]))
    log_f = np.log(frequency)
    raised = log_f + shift
    # beyond the last line the slope on this side of it stands for that on the other
    raised = np.where(raised > log_f[-1], log_f - shift, raised)
    for point in np.flatnonzero(moves):
        transfer = np.log(psd[:, point] / input_psd)
        ratio = np.exp(np.interp(raised, log_f, transfer) - transfer)
        share = psd[:, point] / largest if over_largest else 1.0
        line[point] = np.max(np.abs(np.log(ratio)) * share)
        squares = root_mean_square(frequency, np.stack([psd[:, point], ratio * psd[:, point]], 1))
        mean_shift = np.trapezoid(shift * psd[:, point], frequency) / squares[0] ** 2
        rms[point] = abs(squares[1] / squares[0] - 1) + AMPLITUDE * mean_shift
    return MeshError(np.expm1(line), rms)


def decibels(relative_error: float) -> float:
    """Return a relative error of a PSD in dB."""
    return float(10 * np.log10(1 + relative_error))
