"""The force of the particles that is not linear in the motion of their patch, as a load.

It acts on the panel in addition to the excitation, independently of it. Two cells at a distance d
have the cross-PSD S c exp(−d f/λ), with S the PSD of a cell and c and λ from coupled runs; the rest
of each cell, 1 − c, is independent. On the modes that is

    S [c ∬ φ φ′ᵀ exp(−d f/λ) dA dA′ + (1 − c) A_cell D],    D = ∫ φ φᵀ dA over the patch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Flags
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.plane_waves import MovedFace
from pidpanel.solve.excitation import ModalForce


@dataclass(frozen=True)
class PatchParts:
    """Parts that make up a patch, about square."""

    # (k, n) the shapes at their middles [1], (k,) [m²] and (k, 2) or on a curved surface (k, 3) [m]
    shape: Array
    area: Array
    position: Array

    def coherent_load(self, length: float) -> Array:
        """Return ∬ φ φ′ᵀ exp(−d/l) dA dA′ over the patch, (n, n) [m⁴], for l [m]."""
        side = np.sqrt(self.area)
        mean_side = np.sqrt((self.area[:, None] + self.area) / 2)
        offset = self.position[:, None] - self.position
        if offset.shape[2] == 3:  # on a curved surface: as far apart in a plane
            offset = np.linalg.norm(offset, axis=2)[..., None] * np.array([1.0, 0.0])
        coherence = _mean_between(offset, mean_side, length)
        np.fill_diagonal(coherence, mean_coherence(side, length))
        weighted = self.shape * self.area[:, None]
        return weighted.T @ coherence @ weighted


def own_force_load(
    parts: PatchParts, independent: Array, frequency: Array, coherence: Array, length: float
) -> Array:
    """Return the modal cross-PSD of the own force per PSD of a cell, (nf, n, n) [m⁴].

    Parameters
    ----------
    independent
        (n, n) A_cell D of the patch [m⁴].
    frequency
        (nf,) [Hz].
    coherence, length
        (nf,) c [1], and λ [m Hz].
    """
    lines = zip(frequency, coherence, strict=True)
    loads = [c * parts.coherent_load(length / f) + (1 - c) * independent for f, c in lines]
    return np.array(loads)


def particle_force(nodes: Array, load: Array) -> ModalForce:
    """Return the own force of particles, with S = 1 and G its cross-PSD [N²/Hz].

    ``load`` (k, n, n) is that at the nodes (k,) [Hz]; see `interpolated_load`.
    """
    return ModalForce(np.ones_like, lambda lines: interpolated_load(lines, nodes, load))


def elements_of_patch(face: MovedFace, inside: Flags) -> PatchParts:
    """Return the elements of a patch as its parts, with the mean of the shapes at their corners.

    With six elements to a wavelength that is within 10 % (h²k²/12), with twelve within 3 %.

    Parameters
    ----------
    inside
        (n_cells,) whether an element is part of the patch.
    """
    corners, position = face.cells[inside], face.vertex_position
    shape, middle = (values[corners].mean(axis=1) for values in (face.shape_at_vertices, position))
    return PatchParts(shape, cell_areas(position, corners), middle)


def mean_coherence(side: Array | float, length: Array | float) -> Array:
    """Return the mean of exp(−d/l) over two points of a square.

    Notes
    -----
    With the density of the distance of two points of a unit square (Ghosh 1951) by Gauss'
    quadrature of the two differences.

    Examples
    --------
    Far smaller than the length; far larger, 2π l² − 16 l³.

    >>> float(mean_coherence(1.0, 1e6).round(3)), float((mean_coherence(1.0, 0.01) * 1e4).round(2))
    (1.0, 6.12)
    """
    ratio = np.asarray(side, dtype=np.float64) / np.asarray(length, dtype=np.float64)
    node, weight = np.polynomial.legendre.leggauss(60)
    # u³ gathers the nodes where the exponential falls
    u = (0.5 + 0.5 * node) ** 3
    w = 0.5 * weight * 3 * (0.5 + 0.5 * node) ** 2
    across = np.hypot(u[:, None], u[None, :])
    kernel = 4 * np.outer(w * (1 - u), w * (1 - u))
    return np.einsum("...ij,ij->...", np.exp(-ratio[..., None, None] * across), kernel)


def _mean_between(offset: Array, side: Array, length: float) -> Array:
    """Return the mean of exp(−d/l) over a point in each of two squares (…, 2) [m] apart."""
    node, weight = np.polynomial.legendre.leggauss(4)
    # the difference of two places in a unit square has the density 1 − |u| in each direction
    half, density = (1 + node) / 2, weight * (1 - node) / 4
    u, w = np.concatenate([-half[::-1], half]), np.concatenate([density[::-1], density])
    place = offset[..., None, :] + side[..., None, None] * u[:, None]
    distance = np.hypot(place[..., :, None, 0], place[..., None, :, 1])
    return np.einsum("...uv,u,v->...", np.exp(-distance / length), w, w)


def interpolated_load(frequency: Array, nodes: Array, load: NDArray[Any]) -> NDArray[Any]:
    """Return values (nf, …) from those at nodes (k, …); linear in ln f, or in ln Γ.

    Parameters
    ----------
    frequency, nodes
        (nf,) and (k,) rising [Hz]; values are constant beyond the nodes.
    load
        (k, …) at the nodes.
    """
    place = np.interp(np.log(frequency), np.log(nodes), np.arange(len(nodes)))
    lower = place.astype(int)
    upper = np.minimum(lower + 1, len(nodes) - 1)
    share = (place - lower).reshape(-1, *[1] * (load.ndim - 1))
    return np.asarray((1 - share) * load[lower] + share * load[upper])
