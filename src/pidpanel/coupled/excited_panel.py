"""The panel of a study under its excitation, with the patches of a scenario."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch, bare_psd
from pidpanel.coupled.loaded_shapes import LinearDamper, LoadedShapes, loaded_shapes
from pidpanel.coupled.scenario import CoupledScenario, GivenDamper, RunSettings
from pidpanel.coupled.softening import RmsMotion, Softened, softened_modulus, softening_bias
from pidpanel.coupled.stations import stations_of
from pidpanel.panel.basis import PanelBasis, patch_areas
from pidpanel.panel.matrices import StoredPlate
from pidpanel.solve.basis_error import modal_basis
from pidpanel.solve.excitation import Excitation, ModalForce
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.panel import deflection_at_points
from pidpanel.solve.source import PatchParts
from pidpanel.solve.supports import BaseExcitation
from pidpanel.sound.radiation import Air

LINES_PER_BANDWIDTH = 3.0  # of rms values within 1e-3

PARTS = 64  # parts of a patch over which the own force is summed


@dataclass(frozen=True)
class ExcitedPanel:
    """The panel of a study under its excitation."""

    settings: RunSettings
    basis: PanelBasis
    plate: StoredPlate
    vectors: Array  # (n_free, n) its shapes but for a translation, which is then the last
    excitation: Excitation  # at the level of the study
    air: Air | None  # the air that the panel moves; None where it is left out

    @cached_property
    def modal(self) -> ModalBasis:
        """The shapes with the damping ratio of the bare panel."""
        return modal_basis(
            self.basis, self.settings.damping_ratio, self.settings.frequency_range[1]
        )

    @cached_property
    def coarse_frequency(self) -> Array:
        """(nf,) lines that give rms values within 1e-3 [Hz]."""
        span = self.settings.frequency_range
        ratio = self.settings.damping_ratio.least(*span)
        return frequency_grid(*span, ratio, lines_per_bandwidth=LINES_PER_BANDWIDTH)

    @property
    def diameter(self) -> float:
        """Diameter of the panel [m]."""
        return float(np.hypot(*np.ptp(self.basis.vertex_position, axis=0)))

    def patch(self, name: str, cell_area: float, shapes: LoadedShapes) -> CoupledPatch:
        """Return a patch with its simulated cells of an area [m²]."""
        basis, settings = self.basis, self.settings
        index = basis.patch_names.index(name)
        per_cell = len(self.plate.quadrature_weight) // len(basis.cells)
        elements = np.flatnonzero(basis.cell_in_patch[index])
        rows = (elements[:, None] * per_cell + np.arange(per_cell)).ravel()
        position, weight = self.plate.quadrature_position[rows], self.plate.quadrature_weight[rows]

        def shape(points: Index) -> Array:
            values = np.asarray(self.plate.at_quadrature[rows[points]] @ self.vectors)
            translation = np.ones((len(values), len(self.modal.modal_mass) - values.shape[1]))
            return shapes.shape(np.hstack([values, translation]))

        stations = stations_of(position, weight, settings.stations)
        parts = stations_of(position, weight, min(PARTS, len(weight)))
        cells = settings.cells // settings.stations
        return CoupledPatch(
            shape=np.repeat(shape(stations.point), cells, axis=0),
            area=np.repeat(stations.area / cells, cells),
            position=np.repeat(position[stations.point], cells, axis=0),
            cell_area=cell_area,
            overlap=np.asarray(shapes.square(basis.patch_overlap[index])),
            parts=PatchParts(shape(parts.point), parts.area, position[parts.point]),
        )

    def shapes(self, scenario: CoupledScenario) -> LoadedShapes:
        """Return the shapes of the panel with what of a scenario is not integrated."""
        dampers = [self._linear(damper, scenario.factor) for damper in scenario.dampers]
        return loaded_shapes(self.modal, self.settings.frequency_range, self.air, dampers)

    def _linear(self, damper: GivenDamper, factor: float) -> LinearDamper:
        """Return C_e and m_a of a damper at the motion of the bare patch."""
        index = self.basis.patch_names.index(damper.patch)
        overlap, area = self.basis.patch_overlap[index], patch_areas(self.basis)[index]
        square, vector = np.linalg.eigh(overlap)  # D = E Eᵀ
        frequency, columns = self.coarse_frequency, vector * np.sqrt(np.maximum(square, 0.0))
        psd = bare_psd(self.modal, self.excitation, columns.T, frequency).sum(axis=1) / area
        mean_square = np.trapezoid((2 * np.pi * frequency) ** 4 * psd, frequency)
        gamma = float(np.sqrt(2 * factor * mean_square)) / STANDARD_GRAVITY

        def values(frequency: Array) -> tuple[Array, Array]:
            damping = damper.model(frequency, damper.fill_fraction, gamma)
            return damping.equivalent_damping, damping.apparent_mass

        return LinearDamper(overlap, values)

    def with_patches(self, scenario: CoupledScenario) -> CoupledPanel:
        """Return the panel with the patches of a scenario, at its level."""
        shapes, excitation = self.shapes(scenario), self.excitation
        return CoupledPanel(
            modal=shapes.modal,
            points=shapes.shape(deflection_at_points(self.basis)),
            patches=[
                self.patch(patch.name, patch.beds[0].packing.cell_area, shapes)
                for patch in scenario.patches
            ],
            excitation=ModalForce(
                lambda frequency: scenario.factor * excitation.spectrum(frequency),
                lambda frequency: shapes.square(excitation(frequency)),
                # of base motion G is not resolved: the force on the table is 1e8 times the others
                (lambda frequency: shapes.columns(excitation.factors(frequency)))
                if isinstance(excitation, BaseExcitation)
                else None,
            ),
        )

    def moduli(self, scenario: CoupledScenario, panel: CoupledPanel) -> list[Softened]:
        """Return Young's modulus of the contacts of each patch [Pa], and its bias of g rms [1]."""
        frequency, omega = self.coarse_frequency, 2 * np.pi * self.coarse_frequency
        moduli = []
        for simulated, patch in zip(scenario.patches, panel.patches, strict=True):
            psds = bare_psd(panel.modal, panel.excitation, patch.shape, frequency)
            psd = psds @ patch.area / patch.area.sum()
            squares = [float(np.trapezoid(omega**k * psd, frequency)) for k in (2, 4)]
            particle = simulated.youngs_modulus, simulated.beds[0], RmsMotion(*np.sqrt(squares))
            modulus = self.settings.youngs_modulus or softened_modulus(*particle)
            moduli.append(Softened(modulus, softening_bias(*particle, modulus)))
        return moduli
