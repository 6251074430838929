"""The shapes of a panel in air and with dampers that are not integrated, for the time integration.

The panel moves in shapes of its own, each a single oscillator. The air adds the diagonal of its
mass and resistance; dampers add m_a D to the mass, with which new shapes follow, and the diagonal
of C_e D to their damping. What is left out changes the motion in which the particles are seen a
little, and C_e and m_a hardly; the response is computed with all of it (`pidpanel.response`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.model import ModalBasis

AIR_NODES = 25  # frequencies at which the air is evaluated


class LinearDamper(NamedTuple):
    """A damper with given C_e and m_a on a patch."""

    overlap: Array  # (n, n) D of its patch [m²]
    # C_e [N s/m³] and m_a [kg/m²] at frequencies (k,) [Hz]
    values: Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class LoadedShapes:
    """Oscillators, and their shapes in those of the bare panel."""

    modal: ModalBasis
    # (n, n) new shapes as columns; None where they are those of the bare panel
    vectors: Array | None

    def shape(self, values: Array) -> Array:
        """Return shapes (k, n) of the bare panel as those of here."""
        return values if self.vectors is None else np.asarray(values @ self.vectors)

    def columns(self, values: Array) -> Array:
        """Return forces (…, n, r) on the shapes of the bare panel as those on these."""
        return values if self.vectors is None else np.asarray(self.vectors.T @ values)

    def square(self, matrix: Array | Complexes) -> Array | Complexes:
        """Return matrices (…, n, n) on the shapes of the bare panel as those on these."""
        if self.vectors is None:
            return matrix
        return self.vectors.T @ matrix @ self.vectors


def loaded_shapes(
    modal: ModalBasis,
    extent: tuple[float, float],
    air: Callable[[Array], Complexes] | None,
    dampers: Sequence[LinearDamper],
) -> LoadedShapes:
    """Return the oscillators of a panel in air with dampers."""
    if air is not None:
        modal = _in_air(modal, extent, air)
    if not dampers:
        return LoadedShapes(modal, None)
    nodes = np.geomspace(*extent, AIR_NODES)
    # one mass for all frequencies: its mean over their logarithm
    heavy = np.diag(modal.modal_mass) + sum(
        damper.values(nodes)[1].mean() * damper.overlap for damper in dampers
    )
    square, vectors = eigh(np.diag(modal.modal_mass * modal.angular_frequency**2), heavy)
    natural = np.sqrt(np.maximum(square, 0)) / (2 * np.pi)
    clipped = np.clip(natural, *extent)
    damping = np.einsum("in,i,in->n", vectors, modal.damping, vectors)
    for damper in dampers:
        diagonal = np.einsum("in,ij,jn->n", vectors, damper.overlap, vectors)
        damping = damping + damper.values(clipped)[0] * diagonal
    return LoadedShapes(_oscillators(natural, np.ones(len(natural)), damping), vectors)


def _in_air(
    modal: ModalBasis, extent: tuple[float, float], air: Callable[[Array], Complexes]
) -> ModalBasis:
    nodes = np.geomspace(*extent, AIR_NODES)
    stiffness = np.stack([np.diagonal(air(nodes[k : k + 1])[0]) for k in range(len(nodes))])
    omega = 2 * np.pi * nodes[:, None]
    log_natural = np.log(np.clip(modal.natural_frequency, *extent))

    def at_modes(values: Array) -> Array:
        return np.array(
            [np.interp(f, np.log(nodes), row) for f, row in zip(log_natural, values.T, strict=True)]
        )

    mass = modal.modal_mass + at_modes(-stiffness.real / omega**2)
    damping = modal.damping + at_modes(stiffness.imag / omega)
    natural = modal.natural_frequency * np.sqrt(modal.modal_mass / mass)
    return _oscillators(natural, mass, damping)


def _oscillators(natural: Array, mass: Array, damping: Array) -> ModalBasis:
    """Return oscillators; one at rest has no damping of its own."""
    omega = 2 * np.pi * natural
    ratio = np.divide(damping, 2 * mass * omega, out=np.full_like(omega, 1e-6), where=omega > 0)
    return ModalBasis(natural, mass, ratio)
