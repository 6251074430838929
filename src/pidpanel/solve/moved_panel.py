"""The bare panel on some lines under unit forces, in vacuum or in air."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.excitation import (
    AirOfShapes,
    Matrices,
    MatrixInput,
    matrices_at,
    mixed_product,
)
from pidpanel.solve.model import ModalBasis

# Highest natural frequency of the shapes that the air couples with each other, over that of lines
# solved together, and their least number. Those above, which it barely moves, are coupled with them
# but not with each other. On the panel of `pidpanel new`, bare and with dampers, g rms is within
# 2e-5 and rms curvature and shear within 1e-4, on that of `wing.yaml` within 7e-5 and 3e-4.
SHAPES_IN_AIR, LEAST_IN_AIR = 4.0, 40


class CoupledShapes(NamedTuple):
    """The shapes that the air couples on some lines, and their columns of −ω²M_air + iωR."""

    shapes: Index  # (k,)
    columns: Matrices  # (nf, n, k), or (1, n, k) where all are equal [N/m]


def coupled_shapes(
    air: MatrixInput | AirOfShapes | None, frequency: Array, basis: ModalBasis
) -> CoupledShapes | None:
    """Return the shapes that the air couples on lines solved together; None in vacuum."""
    if air is None:
        return None
    natural = basis.natural_frequency
    least = np.sort(natural)[min(LEAST_IN_AIR, natural.size) - 1]
    shapes = np.flatnonzero(natural <= max(SHAPES_IN_AIR * frequency[-1], least))
    if isinstance(air, AirOfShapes):
        return CoupledShapes(shapes, air.columns(frequency, shapes))
    matrices = matrices_at(air, frequency, slice(None), natural.size)
    return CoupledShapes(shapes, matrices[:, :, shapes])


class MovedPanel:
    """The bare panel on some lines, seen in motions Xᵀq of several sets of columns X.

    Parameters
    ----------
    air
        The shapes that the air couples; None in vacuum.
    sets
        (n, k) columns each; None for the shapes themselves.
    """

    def __init__(
        self,
        frequency: Array,
        basis: ModalBasis,
        air: CoupledShapes | None,
        sets: Sequence[Array | None],
    ) -> None:
        self._sets, self._is_wet = sets, air is not None
        self._motions: dict[int, Complexes] = {}
        # (nf, n, 1) of the panel in vacuum
        self.transfer = 1 / basis.dynamic_stiffness(frequency)[:, :, None]
        if air is None:
            return
        self._soft, count = air.shapes, air.shapes.size
        self._stiff = np.setdiff1d(np.arange(basis.natural_frequency.size), air.shapes)
        self._across = np.asarray(air.columns[:, self._stiff])
        among = np.zeros((len(frequency), count, count), complex)
        among[:, range(count), range(count)] = 1 / self.transfer[:, self._soft, 0]
        among += self._pushed(air.columns)
        unit = np.broadcast_to(np.eye(count), among.shape)
        right = [unit if part is None else self._pushed(part[None]) for part in sets]
        solved = np.linalg.solve(among, np.concatenate(right, axis=2))
        # Z₀⁻¹ X among the soft shapes, of the shapes themselves the inverse
        ends = np.cumsum([part.shape[2] for part in right])[:-1]
        self._solved = np.split(solved, ends, axis=2)

    def motion(self, part: int) -> Complexes:
        """Return Z₀⁻¹ X (nf, n, k) of a set."""
        if part not in self._motions:
            columns = self._sets[part]
            if columns is None:
                self._motions[part] = self._moved(part, np.eye(self.transfer.shape[1])[None])
            elif self._is_wet:
                self._motions[part] = self._followed(columns[None], self._solved[part])
            else:
                self._motions[part] = self.transfer * columns
        return self._motions[part]

    def receptances(self, pulled: int, observed: Sequence[int]) -> list[Complexes]:
        """Return Xᵀ Z₀⁻¹ Y (nf, n_observed, n_pulled) of sets X."""
        motion = self.motion(pulled)
        columns = (self._sets[part] for part in observed)
        return [motion if part is None else mixed_product(part.T, motion) for part in columns]

    def psds(
        self, pulled: int, observed: Sequence[int], force: Matrices, *, is_factor: bool = False
    ) -> list[Complexes]:
        """Return Xᵀ Z₀⁻¹ G Z₀⁻ᴴ Y (nf, n_observed, n_pulled) of sets X; G or its factor L."""
        if is_factor:
            right = self.under(pulled, force).conj().swapaxes(1, 2)
            return [self.under(part, force) @ right for part in observed]
        if self._sets[pulled] is None:
            pushed = self._moved(pulled, force).conj().swapaxes(1, 2)
        else:
            pushed = mixed_product(force, self.motion(pulled).conj())
        return [self.under(part, pushed) for part in observed]

    def under(self, part: int, force: Matrices) -> Complexes:
        """Return the motions Xᵀ Z₀⁻¹ F (nf, k, r) of a set under forces F (nf, n, r)."""
        columns = self._sets[part]
        if columns is None:
            return self._moved(part, force)
        if self._is_wet:
            return mixed_product(self.motion(part).swapaxes(1, 2), force)
        return mixed_product(columns.T, self.transfer * force)

    def _moved(self, shapes: int, force: Matrices) -> Complexes:
        """Return Z₀⁻¹ F (nf, n, r); ``shapes`` is the number of their set."""
        if not self._is_wet:
            return np.asarray(self.transfer * force)
        return self._followed(force, self._solved[shapes] @ self._pushed(force))

    def _pushed(self, force: Matrices) -> Complexes:
        """Return forces on the soft shapes, with those of the air that stiff ones push."""
        moved = self.transfer[:, self._stiff] * force[:, self._stiff]
        return np.asarray(force[:, self._soft] - self._across.swapaxes(1, 2) @ moved)

    def _followed(self, force: Matrices, soft: Complexes) -> Complexes:
        """Return motions with those of stiff shapes that the soft ones push through the air."""
        moved = np.empty((len(soft), self.transfer.shape[1], soft.shape[2]), complex)
        moved[:, self._soft] = soft
        pushed = force[:, self._stiff] - self._across @ soft
        moved[:, self._stiff] = self.transfer[:, self._stiff] * pushed
        return moved
