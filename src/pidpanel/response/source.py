"""The force of the particles that is not linear in the motion of their patch, as a load.

It acts on the panel beside the sound and independently of it, with the PSD over the area that the
random drive of a coupon found (`damping.best_linear`):

- what all cells share acts on the patch like a pressure of its own, S_c b bᵀ with b = ∫_p φ dA,
  as if every cell felt the mean motion of its patch;
- what is each cell's own is independent from cell to cell: a coupon of area A_c with the PSD S_o of
  its mean has the density S_o A_c over area, so that the modal forces have S_o A_c D_p. On a patch
  of area A the mean pressure has S_o A_c/A: it falls with the number of cells.
"""

from __future__ import annotations

import numpy as np

from pidpanel.arrays import Array, Flags, Index


def patch_integrals(
    shape_at_vertices: Array, cells: Index, cell_area: Array, cell_in_patch: Flags
) -> Array:
    """Return b = ∫_p φ dA of each patch (n_patches, n) [m²], from the means of its cells' corners.

    With six cells to a wavelength that is within 10 % (h²k²/12), with twelve within 3 %.

    Parameters
    ----------
    shape_at_vertices
        (n_vertices, n) [1].
    cells
        (n_cells, k) vertices of each cell.
    cell_area
        (n_cells,) [m²].
    cell_in_patch
        (n_patches, n_cells).
    """
    by_cell = cell_area[:, None] * shape_at_vertices[cells].mean(axis=1)
    integrals: Array = cell_in_patch.astype(np.float64) @ by_cell
    return integrals


def force_psd(common: Array, own: Array, integrals: Array, overlap: Array) -> Array:
    """Return the PSD of the modal forces (nf, n, n) [N²/Hz].

    Parameters
    ----------
    common
        (n_patches, nf) S_c [Pa²/Hz].
    own
        (n_patches, nf) S_o A_c [Pa² m²/Hz].
    integrals
        (n_patches, n) b [m²].
    overlap
        (n_patches, n, n) D [m²].
    """
    together = integrals[:, :, None] * integrals[:, None, :]
    psd: Array = np.tensordot(common.T, together, axes=1) + np.tensordot(own.T, overlap, axes=1)
    return psd
