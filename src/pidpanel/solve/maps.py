"""Rms of motion, strain and stress all over the panel.

Results at hundreds of places are cheapest through the modal coordinates: with

    Σ_a = ∫ ω⁴ Re S_q df,    Σ_w = ∫ Re S_q df,

the mean square of any motion c q is c Σ cᵀ, so the lines are run through once for all places.
"""

from collections.abc import Sequence

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


def modal_covariances(
    frequency: Array,
    weights: Array,
    basis: ModalBasis,
    patches: Patches,
    spectrum: Array,
    modal_force: MatrixInput,
    dampers: Sequence[tuple[Array, Array, float]],
    air_stiffness: MatrixInput | None = None,
) -> list[Array]:
    """Return Σ = ∫ weight Re S_q df of several dampers on the same patches, (n_weights, n, n) each.

    Parameters
    ----------
    frequency, basis, patches, spectrum, modal_force, air_stiffness
        Same as in `bare_panels`, the last two as functions of frequency or one matrix. Three lines
        per half-power bandwidth give rms values within 1e-3 (`lines.frequency_grid`).
    weights
        (n_weights, nf) weights of the lines in the integrals, such as `motion_weights`.
    dampers
        C_e and m_a (n_patches, nf) of each scenario, and the factor on ``spectrum``.
    """
    n = basis.natural_frequency.size
    bare_sum = np.zeros((len(weights), n, n))
    damper_sums = np.zeros((len(dampers), *bare_sum.shape))
    chunks = list(chunks_of_lines(frequency.size, n))
    for lines in with_progress(chunks, "parts of the frequency range"):
        f, level = frequency[lines], spectrum[lines]
        (bare,) = bare_panels(
            f, basis, [patches], None, level, modal_force, air_stiffness, MAP_CUTOFF
        )
        bare_sum += np.tensordot(weights[:, lines], bare.point_psd[:, 0].real, axes=1)
        for drop, (damping, mass, _) in zip(damper_sums, dampers, strict=True):
            if not (damping.any() or mass.any()):
                continue
            drop += covariance_taken(bare, damping[:, lines], mass[:, lines], weights[:, lines])
    return [
        factor * (bare_sum - drop)
        for drop, (_, _, factor) in zip(damper_sums, dampers, strict=True)
    ]


def motion_weights(frequency: Array) -> Array:
    """Return weights (2, nf) of lines [Hz] in Σ_a and Σ_w."""
    weight = trapezoid_weights(frequency)
    return np.stack([weight * (2 * np.pi * frequency) ** 4, weight])


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
