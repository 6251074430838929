"""Effect of the air on the panel: radiation damping and added mass.

The pressure on a baffled plate that moves at the velocity v (Rayleigh's integral) is

    p(x) = (iωρ₀/2π) ∫ v(x′) exp(−ikR)/R dA′,

so that the air on one side adds iωR − ω²M_air to the dynamic stiffness of the shapes, with

    R = ρ₀ω²/(2πc₀) G,    M_air,ij = (ρ₀/2π) ∬ φ_i φ_j cos(kR)/R dA dA′

and G that of the diffuse field (`sound.field`), whatever field drives the panel. The baffle is an
assumption: air flows round the edges of a free-standing panel, so that R of the lowest
modes, and with it their radiation damping, is less than computed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.sound.field import wavenumber
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE
from pidpanel.sound.wavenumber_table import WavenumberTable


@dataclass(frozen=True)
class Air:
    """The air on the wetted sides (1 or 2) of a baffled panel: ρ₀ [kg/m³], c₀ [m/s].

    ``diffuse`` is G of the diffuse field [m⁴] over wavenumber, ``added_volume`` V = M_air/ρ₀ of one
    side [m³] (`sound.added_mass`); without it the air has resistance alone.
    """

    density: float
    speed_of_sound: float
    wetted_sides: int
    diffuse: WavenumberTable
    added_volume: WavenumberTable | None

    def with_tables(self, tables: Mapping[str, WavenumberTable]) -> Air:
        """Return the same air on other shapes, with the tables of `field_files` by their names."""
        diffuse = tables.get(DIFFUSE, tables[MODAL_FORCE])
        return replace(self, diffuse=diffuse, added_volume=tables.get(ADDED_VOLUME))

    def __call__(self, frequency: Array) -> Complexes:
        """Return iωR − ω²M_air at the frequencies (nf,) [Hz], (nf, n, n) [N/m]."""
        k = wavenumber(frequency, self.speed_of_sound)
        omega = 2 * np.pi * frequency[:, None, None]
        resistance = air_resistance(
            frequency, self.diffuse.matrix(k), self.density, self.speed_of_sound, self.wetted_sides
        )
        stiffness = np.zeros(resistance.shape, dtype=np.complex128)
        np.multiply(omega, resistance, out=stiffness.imag)
        if self.added_volume is not None:
            mass = -(omega**2) * self.wetted_sides * self.density
            np.multiply(mass, self.added_volume.matrix(k), out=stiffness.real)
        return stiffness


def air_resistance(
    frequency: ArrayLike,
    diffuse_modal_force: ArrayLike,
    density: float,
    speed_of_sound: float,
    wetted_sides: int = 1,
) -> Array:
    """Return the radiation resistance R (nf, n, n) = sides · ρ₀ω²/(2πc₀) G of a panel [N s/m].

    By reciprocity the resistance is that of the diffuse field's G [m⁴], whatever field drives the
    panel.
    """
    omega = 2 * np.pi * np.asarray(frequency, dtype=np.float64)[:, None, None]
    share = wetted_sides * density * omega**2 / (2 * np.pi * speed_of_sound)
    return share * np.asarray(diffuse_modal_force, dtype=np.float64)
