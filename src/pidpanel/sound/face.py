"""The face of a panel under plane waves: shapes at quadrature points, and folded by parity."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_waves import MovedFace, condensed
from pidpanel.sound.wavenumber_table import FieldError, spare_nodes


@dataclass(frozen=True)
class PanelQuadrature:
    """Shapes of a panel at the points of a quadrature over its face."""

    position: Array  # (nq, 2) points in the plane of the panel [m]
    weight: Array  # (nq,) weights [m²]; they sum to the area
    shape: Array  # (nq, n) values of the n shapes φ [1] at the points
    # Largest κ [rad/m] for which Σ w φ exp(iκ·x) represents the integral: that of a condensed face
    # (`pidpanel.geometry.plane_waves`); ∞ for values of the shapes at points of the mesh
    wavenumber: float = np.inf
    # (n, n) ∫ φ_i φ_j dA [m²]; from the points where it is not given. A condensed face needs it.
    overlap: Array | None = None

    @classmethod
    def from_face(cls, face: MovedFace, overlap: Array | None = None) -> "PanelQuadrature":
        """Return the quadrature of a face, with ∫ φ_i φ_j dA [m²] where it is known."""
        points, values = face.quadrature_position, face.shape_at_quadrature
        return cls(points, face.quadrature_weight, values, face.quadrature_wavenumber, overlap)

    @property
    def center(self) -> Array:
        """(2,) middle of the box round the panel [m]."""
        return (self.position.min(axis=0) + self.position.max(axis=0)) / 2

    @property
    def diameter(self) -> float:
        """L [m], diameter of a circle round the box's middle that holds all points."""
        return float(2 * np.max(np.linalg.norm(self.position - self.center, axis=1)))

    @cached_property
    def product_integral(self) -> Array:
        """(n, n) ∫ φ_i φ_j dA [m²]."""
        if self.overlap is not None:
            return self.overlap
        root = np.sqrt(self.weight)[:, None] * self.shape
        return root.T @ root

    def of_shapes(self, chosen: Index) -> "PanelQuadrature":
        """Return the panel with these shapes alone."""
        return replace(self, shape=self.shape[:, chosen], overlap=None)


@dataclass(frozen=True)
class FoldedFace:
    """A face on Gauss points of its box, its load split by parity about the middle of the box.

    Under exp(iκ·x) the four parts answer to products of cosines and sines on a quarter of the box.
    """

    # (n_x,), (n_y,) distances from the middle [m], the halves that are not negative
    x: Array
    y: Array
    # Four (n_x, n_y, n) w φ [m²]: even or odd along x, along y: (ee, eo, oe, oo)
    load: tuple[Array, Array, Array, Array]

    @classmethod
    def from_panel(cls, panel: PanelQuadrature, wavenumber_max: float) -> "FoldedFace":
        """Condense the face of a panel for wavenumbers up to κ_max [rad/m] and fold it."""
        if wavenumber_max > panel.wavenumber * (1 + 1e-9):
            raise FieldError(
                f"shapes are known to {panel.wavenumber:g} rad/m, {wavenumber_max:g} are needed"
            )
        face = condensed(panel.position, panel.weight, panel.shape, wavenumber_max)
        return cls.from_grid(face.position, face.weight[:, None] * face.values)

    @classmethod
    def from_grid(cls, position: Array, load: Array) -> "FoldedFace":
        """Fold a load (nq, n) on points that are a grid already, as those of a condensed face."""
        x, y = (np.unique(axis) for axis in position.T)
        load = load.reshape(x.size, y.size, -1)
        even, odd = _folded(load)
        parts = [
            part.swapaxes(0, 1) for half in (even, odd) for part in _folded(half.swapaxes(0, 1))
        ]
        ee, eo, oe, oo = (np.ascontiguousarray(part) for part in parts)
        return cls(_half_axis(x), _half_axis(y), (ee, eo, oe, oo))

    def azimuthal_mean(self, wavenumber: float, diameter: float) -> Array:
        """Return Ā(κ) = (1/2π) ∮ Re Φ Φᴴ dα, Φ = ∫ φ exp(iκ n_α·x) dA, (n, n) [m⁴].

        Waves along (α) and (π − α) differ in the sign of their parts odd along x, so that cross
        terms of parities cancel and a quarter of the circle is enough.
        """
        reach = wavenumber * diameter
        count = int(np.ceil((reach / 2 + spare_nodes(reach)) / 2))
        azimuth = np.pi / 2 * (np.arange(count) + 0.5) / count
        along_x = wavenumber * np.cos(azimuth)[:, None] * self.x
        along_y = wavenumber * np.sin(azimuth)[:, None] * self.y
        waves_x = (np.cos(along_x), np.sin(along_x))
        waves_y = (np.cos(along_y), np.sin(along_y))
        pairs = [(wave_x, wave_y) for wave_x in waves_x for wave_y in waves_y]
        parts = np.concatenate(
            [
                (wave_x[:, :, None] * wave_y[:, None, :]).reshape(count, -1)
                @ part.reshape(-1, part.shape[2])
                for (wave_x, wave_y), part in zip(pairs, self.load, strict=True)
            ]
        )
        return parts.T @ parts / count


def _folded(load: Array) -> tuple[Array, Array]:
    """Return the even and the odd part of a load along its first axis, on the upper half of it."""
    half = (len(load) + 1) // 2
    even, odd = load + load[::-1], load - load[::-1]
    if len(load) % 2:
        even[half - 1] /= 2  # the middle is counted once
    return even[-half:], odd[-half:]


def _half_axis(points: Array) -> Array:
    """Return the distances from the middle of symmetric points, the half that is not negative."""
    return (points - points[::-1])[-((len(points) + 1) // 2) :] / 2
