"""The force of the particles that is not linear in the motion, and its coherence over the patch.

n = σ − Z v of two cells a distance d apart has the coherence

    γ(d) = c exp(−d/l),    l = λ/f.

c is that of two cells with one motion: 1 for beds that ride at low frequency, where they all
repeat one motion, and 0 for impacts that have nothing to do with each other. The rest, 1 − c, is
independent from cell to cell and hardly moves a patch of a thousand cells.
"""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes

LENGTHS = np.geomspace(3.0, 300.0, 61)  # values of λ that are tried [m Hz]

# λ [m Hz] before it is seen, and the standard deviation of its logarithm [1]: 18 to 50 of acrylic
# at r = 0.5 and 0.9 from 119 to 142 dB.
USUAL_LENGTH, LENGTH_SPREAD = 30.0, 0.7


@dataclass(frozen=True)
class OwnForce:
    """PSD and coherence of the own force of a patch in bands."""

    psd: Array  # (bands,) of a single cell, over its area [Pa²/Hz]
    coherence: Array  # (bands,) c of two cells at one place [1]
    length: float  # λ [m Hz]: the coherence length is λ/f


def own_force_sums(frequency: Array, force: Complexes, edge: Array) -> Array:
    """Return Re Σ n_j n_k* over the lines of each band, (segments, bands, cells, cells)."""
    index = np.searchsorted(frequency, edge)
    result = np.empty((len(force), len(edge), force.shape[2], force.shape[2]))
    for band, (first, last) in enumerate(index):
        part = force[:, first:last]
        result[:, band] = np.einsum("sfj,sfk->sjk", part, part.conj()).real
    return result


def fitted_own_force(sums: Array, lines: Array, centre: Array, distance: Array) -> OwnForce:
    """Return the own force whose coherence is nearest to that of all pairs of cells.

    c of each band, from 0 to 1, and one λ by least squares, with `USUAL_LENGTH` as prior.
    """
    power = np.einsum("bjj->bj", sums)
    cells = sums.shape[1]
    upper = np.triu_indices(cells, 1)
    psd = power.mean(axis=1) / lines
    if cells == 1:
        return OwnForce(psd, np.zeros(len(psd)), USUAL_LENGTH)
    size = np.sqrt(np.maximum(power[:, upper[0]] * power[:, upper[1]], 1e-300))
    correlation = sums[:, upper[0], upper[1]] / size  # (bands, pairs)
    decay = np.exp(-distance[upper] * centre[None, :, None] / LENGTHS[:, None, None])
    norm = np.maximum((decay**2).sum(axis=2), 1e-12)
    product = np.einsum("lbp,bp->lb", decay, correlation)
    coherence = np.clip(product / norm, 0.0, 1.0)
    # Σ (correlation − c decay)² but for what no c and no λ changes
    error = coherence**2 * norm - 2 * coherence * product
    # correlations of few lines scatter by 1/√(2 lines); pairs that share a cell are not independent
    misfit = (error * 2 * lines).sum(axis=1) / cells
    misfit += (np.log(LENGTHS / USUAL_LENGTH) / LENGTH_SPREAD) ** 2
    best = int(np.argmin(misfit))
    return OwnForce(psd, coherence[best], float(LENGTHS[best]))
