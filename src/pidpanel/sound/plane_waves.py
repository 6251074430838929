"""Plane waves of sources far away: a lone wave, independent sources, or sources with one drive."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from pidpanel.arrays import Array, Complexes


@dataclass(frozen=True)
class PlaneWaves:
    """Plane waves with shares of the pressure's mean square."""

    incidence: Array  # (nw,) θ, angles from the normal [rad]
    azimuth: Array  # (nw,) α, angles of the directions in which they run, from x [rad]
    share: Array  # (nw,) of the PSD [1]; they sum to 1
    has_one_drive: bool = False  # all in phase at the middle of the panel; independent otherwise

    @classmethod
    def lone(cls, incidence: float, azimuth: float) -> Self:
        """Return one wave."""
        return cls(np.array([incidence]), np.array([azimuth]), np.ones(1))

    @property
    def count(self) -> int:
        """Number of waves."""
        return self.share.size

    def modal_force(self, forces: Complexes) -> Complexes:
        """Return G (..., n, n) [m⁴] of the forces (..., nw, n) [m²] of waves of unit pressure."""
        columns = np.sqrt(self.share)[:, None] * forces
        if self.has_one_drive:
            columns = columns.sum(axis=-2, keepdims=True)
        return np.asarray(columns.swapaxes(-1, -2) @ columns.conj())
