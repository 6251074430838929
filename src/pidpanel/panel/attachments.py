"""Springs and masses on the panel: what is added to K and M of an assembled plate."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Position
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.supports import vertex_spacing

# Gauss points on each piece of a line mass; pieces are a quarter of an element long.
LINE_POINTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Spring:
    """A spring from the panel to the ground, along z."""

    position: Position  # (x, y) [m]
    stiffness: float  # [N/m]


@dataclass(frozen=True)
class PointMass:
    """A mass at a point."""

    position: Position  # (x, y) [m]
    mass: float  # [kg]


@dataclass(frozen=True)
class LineMass:
    """A mass spread evenly along a straight line, such as a harness."""

    # Ends (x, y) [m]
    start: Position
    end: Position
    mass: float  # of the whole line [kg]


def with_attachments(
    plate: AssembledPlate, attachments: Iterable[Spring | PointMass | LineMass], mesh: PanelMesh
) -> AssembledPlate:
    """Add springs and masses: K += k Nᵀ N, M += m Nᵀ N, M += ∫ μ Nᵀ N ds."""
    stiffness, mass, inertia = plate.stiffness, plate.mass, plate.inertia
    element_size = float(np.median(vertex_spacing(mesh)))
    for attached in attachments:
        if isinstance(attached, LineMass):
            position, share = _along(attached, element_size)
            N = plate.interpolate(position)
            mass = mass + N.T @ sp.diags_array(attached.mass * share) @ N
            inertia = inertia + attached.mass * (N.T @ share)
        else:
            N = plate.interpolate(np.array([attached.position]))
            if isinstance(attached, Spring):
                stiffness = stiffness + attached.stiffness * (N.T @ N)
            else:
                mass = mass + attached.mass * (N.T @ N)
                inertia = inertia + attached.mass * (N.T @ np.ones(1))
    return replace(
        plate, stiffness=sp.csr_array(stiffness), mass=sp.csr_array(mass), inertia=inertia
    )


def _along(line: LineMass, element_size: float) -> tuple[Array, Array]:
    """Return Gauss points (n, 2) along a line [m], and weights that sum to 1."""
    start, end = np.array(line.start), np.array(line.end)
    pieces = max(1, int(np.ceil(4 * np.linalg.norm(end - start) / element_size)))
    points, weights = LINE_POINTS
    share = ((np.arange(pieces)[:, None] + (points + 1) / 2) / pieces).ravel()
    return start + share[:, None] * (end - start), np.tile(weights / 2 / pieces, pieces)
