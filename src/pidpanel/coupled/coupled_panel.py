"""A panel under its excitation with filled patches, some of whose cells are simulated."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled.own_force import OwnForce
from pidpanel.solve import layouts
from pidpanel.solve.excitation import Excitation
from pidpanel.solve.layout import DamperLayout
from pidpanel.solve.modal import dense_stiffness
from pidpanel.solve.model import ModalBasis, Patches, UnstableDamping
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.source import PatchParts, own_force_load

# Z of a patch over frequency: (nf,) [Hz] to (nf,) [N s/m³].
Impedance = Callable[[Array], Complexes]


@dataclass(frozen=True)
class CoupledPatch:
    """A filled patch: its simulated cells, and the whole of it."""

    # (c, n) the shapes at the simulated cells [1], (c,) the area that each represents [m²] and (c,
    # 2) or on a curved surface (c, 3) their places [m]
    shape: Array
    area: Array
    position: Array
    cell_area: float  # of a cell [m²]
    overlap: Array  # (n, n) D = ∫ φ φᵀ dA of the patch [m²]
    parts: PatchParts  # parts that make up the patch

    @property
    def factor(self) -> Array:
        """(n, r) E with D = E Eᵀ, parts below 1e-8 of the largest left out [m]."""
        value, vector = np.linalg.eigh((self.overlap + self.overlap.T) / 2)
        large = value > 1e-8 * value[-1]
        return vector[:, large] * np.sqrt(value[large])

    @property
    def distance(self) -> Array:
        """(c, c) of the simulated cells from each other [m]."""
        return np.asarray(np.linalg.norm(self.position[:, None] - self.position, axis=2))

    def whole_load(self, force: OwnForce, frequency: Array) -> Array:
        """Return the modal cross-PSD of the own force per PSD of a cell, (nf, n, n) [m⁴]."""
        independent = self.cell_area * self.overlap
        return own_force_load(self.parts, independent, frequency, force.coherence, force.length)

    def shared_area(self, length: float, frequency: Array) -> Array:
        """Return ∬ exp(−d f/λ) dA dA′ over the patch, (nf,) [m⁴], for λ [m Hz]."""
        rigid = replace(self.parts, shape=np.ones((len(self.parts.area), 1)))  # moves as one
        return np.array([rigid.coherent_load(length / f)[0, 0] for f in frequency])


@dataclass(frozen=True)
class CoupledPanel:
    """The panel under its excitation with the patches of a scenario."""

    modal: ModalBasis
    points: Array  # (p, n) the shapes at the points [1]
    patches: Sequence[CoupledPatch]  # filled ones, in the order of the cells of a record
    excitation: Excitation
    # dynamic stiffness (nf, n, n) [N/m] of air and dampers that are not integrated; None for none
    added: Callable[[Array], Complexes] | None = None

    def dynamic_stiffness(self, frequency: Array) -> Complexes:
        """Return Z₀ without the patches [N/m]: (nf, n) where it is diagonal, or (nf, n, n)."""
        if self.added is None:
            return self.modal.dynamic_stiffness(frequency)
        return dense_stiffness(frequency, self.modal, self.added(frequency))

    def load(self, frequency: Array) -> Array | Complexes:
        """Return the cross-PSD of the modal forces (nf, n, n) [N²/Hz]."""
        return self.excitation.spectrum(frequency)[:, None, None] * self.excitation(frequency)

    @property
    def slices(self) -> list[slice]:
        """Cells of each patch."""
        ends = np.cumsum([0] + [len(patch.area) for patch in self.patches]).tolist()
        return [slice(first, last) for first, last in pairwise(ends)]

    @property
    def at_cells(self) -> Array:
        """(c, n) the shapes at all simulated cells."""
        return np.concatenate([patch.shape for patch in self.patches])

    @property
    def area(self) -> Array:
        """(c,) that the simulated cells represent [m²]."""
        return np.concatenate([patch.area for patch in self.patches])


def cell_load(panel: CoupledPanel, frequency: Array, impedances: Sequence[Impedance]) -> Complexes:
    """Return the diagonal (nf, c) of a_c Z_c."""
    pairs = zip(impedances, panel.patches, strict=True)
    return np.concatenate([z(frequency)[:, None] * patch.area for z, patch in pairs], axis=1)


def bare_psd(
    modal: ModalBasis,
    excitation: Excitation,
    shape: Array,
    frequency: Array,
    air: Callable[[Array], Complexes] | None = None,
) -> Array:
    """Return the PSDs (nf, s) [m²/Hz] of motions of the bare panel with the shapes (s, n)."""
    n = shape.shape[1]
    patches = Patches(np.zeros((0, n, n)), np.zeros(0))
    panel = ModalPanel(modal, patches, frequency, shape, frequency, air)
    (bare,) = layouts(panel, excitation, [DamperLayout(())])
    if isinstance(bare, UnstableDamping):
        raise bare
    return bare.response.displacement_psd
