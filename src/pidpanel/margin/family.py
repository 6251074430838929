"""Panels that differ in stiffness, mass and edges, in one basis of shapes.

K and M of any of them are sums of a few, K = Σ c_j K_j: the section enters by its bending and shear
stiffness, springs by their stiffness, masses by theirs. Shapes V of a few of the panels, compressed
in the norm of elastic energy, carry all (Rayleigh-Ritz): a panel is an eigenproblem of Vᵀ K V.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from pidpanel.arrays import Array, Index

# Share of the elastic energy of a direction of the shapes below which it is left out.
ENERGY = 1e-5
# Static response of modes left out, over the largest, below which it is left out too.
STATIC = 0.05
INDEPENDENT = 1e-9  # of parameters of panels, over the largest


@dataclass(frozen=True)
class Parts:
    """Sums of a few: the rows of parameters that span all, and their shares in each."""

    chosen: Index  # (k,) rows
    share: Array  # (n_rows, k)

    @classmethod
    def spanning(cls, parameters: Array) -> Parts:
        """Return the parts of rows (n_rows, n_parameters), which enter linearly.

        Examples
        --------
        >>> Parts.spanning(np.array([[1.0, 0.0], [2.0, 0.0], [1.0, 5.0]])).share.round(12).tolist()
        [[0.5, 0.0], [1.0, 0.0], [0.0, 1.0]]
        """
        size = np.abs(parameters).max(axis=0)
        scaled = parameters[:, size > 0] / size[size > 0]
        _, triangle, order = la.qr(scaled.T, mode="economic", pivoting=True)
        diagonal = np.abs(np.diagonal(triangle))
        chosen = np.sort(order[: int(np.sum(diagonal > INDEPENDENT * diagonal[0]))])
        share = np.linalg.lstsq(scaled[chosen].T, scaled.T, rcond=None)[0].T
        return cls(chosen, np.where(np.abs(share) < 1e-12, 0.0, share))

    def distinct(self, rows: Index) -> Index:
        """Return those of some rows that are not proportional to the first of them, and it."""
        unit = self.share[rows] / np.linalg.norm(self.share[rows], axis=1, keepdims=True)
        return rows[np.append([True], np.abs(unit[1:] @ unit[0]) < 1 - 1e-6)]


@dataclass(frozen=True)
class PanelFamily:
    """Matrices of the parts in the shapes of the family."""

    stiffness: Array  # (k, n, n) [N/m]
    mass: Array  # (l, n, n) [kg]

    def modes(self, stiffness: Array, mass: Array) -> tuple[Array, Array]:
        """Return frequencies (n,) [Hz] and vectors (n, n) of 1 kg from the shares of the parts."""
        K, M = (
            np.tensordot(share, parts, axes=1)
            for share, parts in ((stiffness, self.stiffness), (mass, self.mass))
        )
        value, vector = la.eigh(K, M)
        return np.sqrt(np.maximum(value, 0.0)) / (2 * np.pi), vector


def with_static_rest(
    natural: Array, vectors: Array, loads: Sequence[Array], limit: float
) -> tuple[Array, Array]:
    """Return the modes of 1 kg up to a limit [Hz], and few shapes for those above.

    What of loads (k, n) each, such as the rows of patches, moves them statically is reduced to the
    directions with most of the elastic energy and diagonalised in mass and stiffness.
    """
    dynamic = natural <= limit
    static_modes, omega = vectors[:, ~dynamic], 2 * np.pi * natural[~dynamic]
    static = [static_modes.T @ load.T / omega[:, None] for load in loads]
    size = [np.linalg.norm(part) for part in static]
    static = [part / norm for part, norm in zip(static, size, strict=True) if norm > 0]
    if not static:
        return natural[dynamic], vectors[:, dynamic]
    direction, value, _ = la.svd(np.hstack(static), full_matrices=False)
    direction = direction[:, value > STATIC * value[0]]
    square, turn = la.eigh(direction.T @ (direction / omega[:, None] ** 2))
    shapes = (static_modes / omega) @ direction @ turn / np.sqrt(square)
    frequency = 1 / (2 * np.pi * np.sqrt(square))
    return np.append(natural[dynamic], frequency), np.hstack([vectors[:, dynamic], shapes])


def compressed(
    shapes: Sequence[Array], stiffness: sp.csr_array, mass: sp.csr_array, frequency: float
) -> Array:
    """Return shapes (n_free, n) that span others, for responses about a frequency [Hz].

    Directions with less than `ENERGY` of the energy ½ vᵀ(K + ω² M)v of those that are given, each
    of the same energy, are left out.
    """
    stacked = np.hstack(shapes)
    norm = stiffness + (2 * np.pi * frequency) ** 2 * mass
    stacked = stacked / np.sqrt(np.einsum("ki,ki->i", stacked, norm @ stacked))
    energy, vector = la.eigh(stacked.T @ (norm @ stacked))
    large = energy > ENERGY
    return np.asarray(stacked @ (vector[:, large] / np.sqrt(energy[large])))
