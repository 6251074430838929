"""Springs and masses on the panel: what is added to K and M of an assembled plate."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Position
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.point_supports import added_compliance, angle_fraction
from pidpanel.panel.supports import vertex_spacing

# Gauss points on each piece of a line mass; pieces are a quarter of an element long.
LINE_POINTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Attachment:
    """A mass, or a spring along z to the ground, at a point or uniform along a line."""

    ends: tuple[Position, ...]  # (x, y) [m] of the point, or of both ends of a straight line
    mass: float = 0.0  # of the whole line [kg]
    stiffness: float = 0.0  # of a spring [N/m]


def with_attachments(
    plate: AssembledPlate, attachments: Iterable[Attachment], mesh: PanelMesh
) -> AssembledPlate:
    """Add springs and masses: K += k Nᵀ N, M += m Nᵀ N, M += ∫ μ Nᵀ N ds."""
    stiffness, mass, inertia = plate.stiffness, plate.mass, plate.inertia
    reactions = plate.reactions
    element_size = float(np.median(vertex_spacing(mesh)))
    for attached in attachments:
        position, share = _spread(np.array(attached.ends), element_size)
        N = plate.interpolate(position)
        value = attached.stiffness or attached.mass
        if len(attached.ends) == 1:
            squares = value * (N.T @ N)
            compliance, _ = added_compliance(plate.section, angle_fraction(mesh, position[0]))
            row = np.sqrt(compliance / 2) * value * N
            further = (row, 0 * row) if attached.stiffness else (0 * row, row)
            reactions = tuple(map(_stacked, reactions, further))
        else:
            squares = N.T @ sp.diags_array(value * share) @ N
        if attached.stiffness:
            stiffness = stiffness + squares
        else:
            mass = mass + squares
            inertia = inertia + attached.mass * (N.T @ share)
    return replace(
        plate,
        stiffness=sp.csr_array(stiffness),
        mass=sp.csr_array(mass),
        inertia=inertia,
        reactions=reactions,
    )


def _stacked(upper: sp.csr_array, lower: sp.csr_array) -> sp.csr_array:
    return sp.csr_array(sp.vstack([upper, lower]))


def _spread(ends: Array, element_size: float) -> tuple[Array, Array]:
    """Return a point, or Gauss points (n, 2) along a line [m], and weights that sum to 1."""
    if len(ends) == 1:
        return ends, np.ones(1)
    start, end = ends
    pieces = max(1, int(np.ceil(4 * np.linalg.norm(end - start) / element_size)))
    points, weights = LINE_POINTS
    share = ((np.arange(pieces)[:, None] + (points + 1) / 2) / pieces).ravel()
    return start + share[:, None] * (end - start), np.tile(weights / 2 / pieces, pieces)
