"""Rms of motion, strain and stress all over the panel.

Results at hundreds of places are cheapest through the modal coordinates: with

    Σ_a = ∫ ω⁴ Re S_q df,    Σ_w = ∫ Re S_q df,

the mean square of any motion c q is c Σ cᵀ, so the lines are run through once for all places.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array
from pidpanel.progress import with_progress
from pidpanel.solve.dampers import covariance_taken
from pidpanel.solve.excitation import MatrixInput
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.modal import bare_panels, chunks_of_lines
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.stress import VON_MISES, Layers

MAP_CUTOFF = 1e-4  # eigenvalues of D dropped, see `bare_panels`: 5e-4 in a PSD, which no map shows


@dataclass(frozen=True)
class ModalCovariance:
    """Mean squares of the modal coordinates of one scenario."""

    # (n, n) Σ_a [m²/s⁴] and Σ_w [m²]
    acceleration: Array
    displacement: Array


def modal_covariances(
    frequency: Array,
    basis: ModalBasis,
    patches: Patches,
    spectrum: Array,
    modal_force: MatrixInput,
    dampers: Sequence[tuple[Array, Array, float]],
    air_stiffness: MatrixInput | None = None,
) -> list[ModalCovariance]:
    """Return Σ_a and Σ_w of several dampers on the same patches.

    Parameters
    ----------
    frequency, basis, patches, spectrum, modal_force, air_stiffness
        Same as in `bare_panels`, the last two as functions of frequency or one matrix. Three lines
        per half-power bandwidth give rms values within 1e-3 (`lines.frequency_grid`).
    dampers
        C_e and m_a (n_patches, nf) of each scenario, and the factor on ``spectrum``.
    """
    n = basis.natural_frequency.size
    weight = trapezoid_weights(frequency)
    weights = np.stack([weight * (2 * np.pi * frequency) ** 4, weight])
    bare_sum, damper_sums = np.zeros((2, n, n)), np.zeros((len(dampers), 2, n, n))
    chunks = list(chunks_of_lines(frequency.size, n))
    for lines in with_progress(chunks, "parts of the frequency range"):
        f, level = frequency[lines], spectrum[lines]
        (bare,) = bare_panels(
            f, basis, [patches], None, level, modal_force, air_stiffness, MAP_CUTOFF
        )
        bare_sum += np.tensordot(weights[:, lines], bare.point_psd[:, 0].real, axes=1)
        for drop, (damping, mass, _) in zip(damper_sums, dampers, strict=True):
            drop += covariance_taken(bare, damping[:, lines], mass[:, lines], weights[:, lines])
    return [
        ModalCovariance(*(factor * (bare_sum - drop)))
        for drop, (_, _, factor) in zip(damper_sums, dampers, strict=True)
    ]


def rms_map(covariance: Array, motion: Array) -> Array:
    """Return the rms of a motion at every place.

    Parameters
    ----------
    covariance
        (n, n) Σ.
    motion
        (n_places, n) the motion as rows over the shapes.
    """
    mean_square: Array = np.einsum("vi,ij,vj->v", motion, covariance, motion, optimize=True)
    return np.sqrt(np.maximum(mean_square, 0.0))


def layer_maps(displacement: Array, curvature: Array, layers: Layers) -> dict[str, Array]:
    """Return the rms of strain, stress and von Mises stress at every place.

    Parameters
    ----------
    displacement
        (n, n) Σ_w [m²].
    curvature
        (n_places, 3, n) of the shapes [1/m].

    Returns
    -------
    (n_layers, n_places) each, by the names of `stress.QUANTITIES`.
    """
    mean = np.einsum("vai,ij,vbj->vab", curvature, displacement, curvature, optimize=True)
    maps = {}
    for kind, matrices in (("strain", layers.strain), ("stress", layers.stress)):
        square = matrices[:, None] @ mean @ matrices[:, None].swapaxes(2, 3)
        for index, name in enumerate(("xx", "yy", "xy")):
            maps[f"{kind}_{name}"] = np.sqrt(np.maximum(square[..., index, index], 0.0))
    maps["von_mises"] = np.sqrt(np.maximum(np.einsum("ij,lvji->lv", VON_MISES, square), 0.0))
    return maps
