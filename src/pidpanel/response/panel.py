"""The panel of a study under its excitation, ready for the solver."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index
from pidpanel.damping.coupled import CoupledDamping
from pidpanel.damping_ratio import DampingRatio
from pidpanel.panel.basis import PanelBasis, patch_areas
from pidpanel.panel.matrices import StoredPlate
from pidpanel.solve.basis_error import basis_shapes, modal_basis, refined
from pidpanel.solve.excitation import Excitation, Matrices, ModalForce
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.lines import check_lines, frequency_grid
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel, PatchElements, deflection_at_points
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.source import elements_of_patch, own_force_load, particle_force
from pidpanel.sound.radiation import Air

COARSE_LINES_PER_BANDWIDTH = 3.0  # of the search for Γ: rms of the patch within 1e-3

# Frequencies at which the modal load of the particles' own force is computed; linear in ln f
# between them.
OWN_FORCE_NODES = 25


@dataclass(frozen=True)
class Settings:
    """Values of a study that the response depends on."""

    frequency_range: tuple[float, float]  # lowest and highest frequency [Hz]
    damping_ratio: DampingRatio  # ζ of the bare panel [1]
    is_diagonal: bool = False  # whether the dampers leave the modes uncoupled, as in the paper
    by_element: bool = False  # whether each element of a patch is a damper of its own
    # Γ at which all damping is read; None for that of the motion
    stated_acceleration_g: float | None = None
    jumps: ArrayLike = ()  # frequencies at which the excitation jumps [Hz]
    lines: Array | None = None  # (nf,) of the result [Hz]; None for those of the panel


class ExcitationSource(Protocol):
    """The sound of a study on any shapes of its panel."""

    def on_basis(self, basis: PanelBasis, air: Air | None) -> tuple[Excitation, Air | None]:
        """Return the excitation of a basis, and the air on it where there is some."""
        ...

    def force_at(self, frequency: float, basis: PanelBasis) -> Matrices:
        """Return G (n, n) [m⁴] of a basis at a frequency [Hz]."""
        ...


def patch_elements(basis: PanelBasis, plate: StoredPlate, vectors: Array) -> PatchElements:
    """Return the elements of the patches in a basis of the shapes ``vectors`` (n_free, n)."""
    per_element = len(plate.quadrature_weight) // len(basis.cells)  # element by element
    patch, cell = np.nonzero(basis.cell_in_patch)
    index = (cell[:, None] * per_element + np.arange(per_element)).ravel()
    weight = plate.quadrature_weight[index]
    at_points = plate.at_quadrature[index]
    used = np.unique(at_points.indices)  # a patch is a small part of the panel
    motion = at_points[:, used] @ vectors[used].astype(np.float64)
    rows = (np.sqrt(weight)[:, None] * motion).reshape(len(cell), per_element, vectors.shape[1])
    area = weight.reshape(-1, per_element).sum(axis=1)
    return PatchElements(Patches.of_rows(rows, area), patch)


# (longest edge [m], frequency [Hz], added mass [kg/m²]) → relative frequency error due to the mesh
# [1].
WaveShift = Callable[..., float]


@dataclass(frozen=True)
class ResponsePanel:
    """A panel under its excitation."""

    settings: Settings
    basis: PanelBasis  # modes and residual vectors of the panel
    excitation: Excitation  # at the level of the study
    mass_per_area: float  # of the panel, without dampers [kg/m²]
    wave_shift: WaveShift  # relative frequency error of a wave due to the mesh
    point_refinement_error: Array | float  # (n_points,) see `StudiedPanel`
    air: Air | None = None  # the air that the panel moves; None where it is left out
    # Elements of the patches; None if they are not used
    elements: PatchElements | None = None
    # Least damping ratio of the resonances that the lines must resolve; None for the bare panel's
    least_damping_ratio: float | None = None
    # (n_modes,) relative error of the load of each mode at its resonance, by the mesh of the air or
    # by averages of cross-spectra, which are independent of those of other modes
    load_error: Array | None = None
    has_independent_loads: bool = False

    @cached_property
    def modal(self) -> ModalBasis:
        """The shapes with the damping ratio of the bare panel."""
        settings = self.settings
        return modal_basis(self.basis, settings.damping_ratio, settings.frequency_range[1])

    @property
    def resolved_ratio(self) -> float:
        """ζ that the lines resolve."""
        bare = self.settings.damping_ratio.smallest(*self.settings.frequency_range)
        return self.least_damping_ratio or bare

    @cached_property
    def frequency(self) -> Array:
        """(nf,) lines of the result [Hz]."""
        modes = self.basis.natural_frequency[~self.basis.is_residual]
        settings = self.settings
        if settings.lines is not None:
            check_lines(settings.lines, *settings.frequency_range, self.resolved_ratio)
            return settings.lines
        return frequency_grid(*settings.frequency_range, self.resolved_ratio, modes, settings.jumps)

    @cached_property
    def coarse_frequency(self) -> Array:
        """(nf,) fewer lines, for rms values within 1e-3 [Hz]."""
        return frequency_grid(
            *self.settings.frequency_range,
            self.resolved_ratio,
            jumps=self.settings.jumps,
            lines_per_bandwidth=COARSE_LINES_PER_BANDWIDTH,
        )

    @cached_property
    def patch_area(self) -> Array:
        """(n_patches,) [m²]."""
        return patch_areas(self.basis)

    @cached_property
    def patches(self) -> Patches:
        """All patches of the panel."""
        return Patches(self.basis.patch_overlap, self.patch_area)

    @cached_property
    def deflection_at_points(self) -> Array:
        """(n_points, 1, n): w alone."""
        return deflection_at_points(self.basis)[:, None]

    @cached_property
    def motion_at_points(self) -> Array:
        """(n_points, 6, n): w, curvatures, shear angles."""
        basis = self.basis
        return np.concatenate(
            [self.deflection_at_points, basis.curvature_at_points, basis.shear_at_points], axis=1
        )

    @property
    def by_element(self) -> bool:
        """Whether each element of a patch is a damper of its own."""
        return self.settings.by_element and self.elements is not None

    @cached_property
    def carriers(self) -> Index:
        """(n_carriers,) index of the patch of each carrier in the solver: patches, or elements."""
        if self.by_element and self.elements is not None:
            return self.elements.patch
        return np.arange(len(self.patch_area))

    @cached_property
    def carrier_patches(self) -> Patches:
        """The patches of the solver, or their elements."""
        if self.by_element and self.elements is not None and len(self.elements.patch):
            return self.elements.parts
        return self.patches

    def solver(self, *, rms_only: bool = False, full: bool = False) -> PanelSolver:
        """Return a solver.

        Parameters
        ----------
        rms_only
            Few lines and no strains, enough for rms accelerations within 1e-3.
        full
            The full modal damping matrix, also if the study requests the diagonal one.
        """
        cells = None if self.by_element else self.elements
        if cells is not None and not len(cells.patch):
            cells = None
        panel = ModalPanel(
            self.modal,
            self.carrier_patches,
            self.coarse_frequency if rms_only else self.frequency,
            self.deflection_at_points if rms_only else self.motion_at_points,
            self.coarse_frequency,
            self.air,
            cells,
            self.settings.is_diagonal and not full,
        )
        return PanelSolver(panel, self.excitation)

    def load_area(self, response: LayoutResponse) -> Array:
        """Return the areas (n_loads,) of the dampers of a response [m²]."""
        return self.carrier_patches.area[response.patches]

    def bare_motion_g(self, bare: LayoutResponse, patch: int) -> float:
        """Return Γ of a patch of the bare panel."""
        carriers = self.carriers == patch
        area = self.carrier_patches.area[carriers]
        share = area / area.sum()
        return float(np.sqrt(share @ bare.bare_patch_acceleration_g[carriers] ** 2))

    def particle_force(self, beds: Mapping[int, CoupledDamping]) -> ModalForce:
        """Return the own force of the particles on the modes, from coupled runs by patch."""
        basis = self.basis
        nodes = np.geomspace(*self.settings.frequency_range, OWN_FORCE_NODES)
        total = np.zeros((len(nodes), *basis.patch_overlap.shape[1:]))
        for patch, bed in beds.items():
            parts = elements_of_patch(basis, basis.cell_in_patch[patch])
            psd, coherence = bed.own_force(nodes)
            independent = bed.cell_area * basis.patch_overlap[patch]
            load = own_force_load(parts, independent, nodes, coherence, bed.own_length)
            total += psd[:, None, None] * load
        return particle_force(nodes, total)


def widen(
    panel: ResponsePanel, plate: StoredPlate, further_shapes: Array, source: ExcitationSource
) -> ResponsePanel:
    """Return the panel with a basis extended by the shapes that it lacks.

    The excitation of the new shapes is computed here, since their choice depends on the response.
    """
    if not further_shapes.shape[1]:
        return replace(panel, elements=patch_elements(panel.basis, plate, plate.shapes))
    shapes = basis_shapes(panel.basis, plate, further_shapes)
    basis = refined(panel.basis, plate, shapes)
    elements = patch_elements(basis, plate, shapes.vectors)
    excitation, air = source.on_basis(basis, panel.air)
    return replace(panel, basis=basis, excitation=excitation, air=air, elements=elements)
