"""The face of a panel under plane waves, folded by parity."""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array
from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound.wavenumber_table import FieldError, spare_nodes


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
        return cls.from_grid(condensed(panel, wavenumber_max))

    @classmethod
    def from_grid(cls, panel: PanelQuadrature) -> "FoldedFace":
        """Fold a face whose points are a grid already, as those of a condensed one."""
        x, y = (np.unique(axis) for axis in panel.position.T)
        load = (panel.weight[:, None] * panel.shape).reshape(x.size, y.size, -1)
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
        azimuth = quarter_circle(wavenumber * diameter)
        count = azimuth.size
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


def quarter_circle(reach: float) -> Array:
    """Return azimuths on (0, π/2) [rad] that do for the mean over a circle, of a κL."""
    count = int(np.ceil((reach / 2 + spare_nodes(reach)) / 2))
    azimuth: Array = np.pi / 2 * (np.arange(count) + 0.5) / count
    return azimuth


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
