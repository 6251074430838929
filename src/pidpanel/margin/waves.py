"""Matrices over wavenumber as sums of a few, quickly carried over to the modes of a panel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from pidpanel.arrays import Array

SAMPLES_PER_RADIAN = 3.0  # of kL: cubic splines between them err by 1e-4 of sin(kL)
ACCURACY = 1e-5  # of a matrix in the norm of its entries, each over the largest of its shapes


@dataclass(frozen=True)
class WaveMatrix:
    """A real symmetric matrix over wavenumber, Σ_j c_j(k) A_j."""

    share: Callable[[Array], Array]  # k (nf,) [rad/m] → c (nf, r)
    matrices: Array  # (r, n, n)

    @classmethod
    def decomposed(
        cls, matrix: Callable[[Array], Array], lowest: float, highest: float, diameter: float
    ) -> WaveMatrix:
        """Return a matrix (nf, n, n) of wavenumbers (nf,) between two [rad/m] as such a sum.

        ``diameter`` [m] is that of the panel, with which the matrix oscillates.
        """
        count = int(SAMPLES_PER_RADIAN * highest * diameter) + 8
        k = np.linspace(lowest, highest, count)
        values = np.concatenate([matrix(k[i : i + 16]) for i in range(0, count, 16)])
        size = np.sqrt(np.abs(np.diagonal(values, axis1=1, axis2=2)).max(axis=0))
        size = np.maximum(size, 1e-6 * size.max())
        flat = (values / size[:, None] / size).reshape(count, -1)
        norm = np.linalg.norm(flat, axis=1, keepdims=True)
        flat /= norm
        square, vector = np.linalg.eigh(flat @ flat.T)
        large = square > ACCURACY**2 * square[-1]
        share = CubicSpline(k, norm * vector[:, large])
        matrices = (vector[:, large].T @ flat).reshape(-1, size.size, size.size)
        return cls(share, matrices * size[:, None] * size)

    def in_modes(self, vectors: Array) -> Callable[[Array], Array]:
        """Return the matrix (nf, m, m) over wavenumber (nf,) in some vectors (n, m)."""
        turned = vectors.T @ self.matrices @ vectors
        m = vectors.shape[1]
        rows, columns = np.triu_indices(m)
        packed, place = turned[:, rows, columns], np.empty((m, m), int)
        place[rows, columns] = place[columns, rows] = np.arange(rows.size)
        return lambda k: (self.share(k) @ packed)[:, place]
