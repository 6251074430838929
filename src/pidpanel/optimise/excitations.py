"""The panel of a study under each excitation of a search, with dampers on places.

Each plate has the places as its patches. The best layouts are confirmed at their consistent motion,
in a basis that is checked with them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.base.basis_check import checked_panel
from pidpanel.base.from_study import Shaker
from pidpanel.optimise.places import PlacedPanel, Places, place_basis, place_panel
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import residual_vectors
from pidpanel.response.cases import ResponseScenario, SolvedCase, plan_cases, steady
from pidpanel.response.model_error import model_error_of, with_model_error
from pidpanel.response.panel import ExcitationSource, ResponsePanel
from pidpanel.response.refinement import checked_responses
from pidpanel.response.results import error_parts
from pidpanel.solve.base_motion import UNIT, SupportedPanel, Translation, supported_panel
from pidpanel.solve.basis_error import basis_shapes, refined
from pidpanel.solve.model import PanelResponse

# Share of the largest static response to a patch below which a direction is left out
STATIC_TOLERANCE = 1e-2

# Static responses that join the modes of a search with many places, or as many as these
SHAPES_ADDED = 150

FORCES_BYTES = 2e8  # of the forces of all places on all elements


@dataclass(frozen=True)
class Finalist:
    """A layout at its consistent motion."""

    # With the dampers, without them, and with their mass alone
    response: PanelResponse
    bare: PanelResponse
    dead_weight: PanelResponse
    # (n_points,) standard error of ln of the rms acceleration; 0 where none is known
    log_rms_error: Array
    acceleration_g: Array  # (n_loads,) Γ of each patch; NaN for a damper that does not depend on it
    basis_error: float  # largest relative error of a PSD [1]


def static_shapes(basis: PanelBasis, plate: StoredPlate, tolerance: float) -> Array:
    """Return the static response (n_free, k) to the patches, see `residual_vectors`.

    For a search among many places its softest shapes, at most `SHAPES_ADDED`.
    """
    n_free, count = plate.shapes.shape
    if tolerance >= 1:
        return np.zeros((n_free, 0))
    modes = plate.shapes[:, ~basis.is_residual].astype(np.float64)
    forces = int(FORCES_BYTES / (8 * n_free * len(plate.patch_overlap)))
    vectors = residual_vectors(plate, modes, tolerance, max(1, forces))[1]
    limit = None if tolerance <= STATIC_TOLERANCE else int(max(SHAPES_ADDED, count))
    return vectors[:, :limit]


def finalist(case: SolvedCase, basis_error: float) -> Finalist:
    """Return a layout from its case."""
    response = steady(case.response)
    errors = with_model_error(*error_parts(case, response))
    errors = with_model_error(errors, model_error_of(case, response))
    damped, bare = response.response, case.bare.response
    dead = bare if case.dead_weight is None else case.dead_weight.response
    log_rms = np.zeros(damped.acceleration_rms.shape) if errors is None else errors.log_rms
    return Finalist(damped, bare, dead, log_rms, response.acceleration_g, basis_error)


@dataclass(frozen=True)
class SoundExcitedPanel:
    """A panel in its sound field."""

    start: ResponsePanel
    source: ExcitationSource
    with_strains: bool

    @property
    def basis(self) -> PanelBasis:
        """The basis of the panel stage."""
        return self.start.basis

    def panel(
        self, plate: StoredPlate, places: Places, static_tolerance: float = 1.0
    ) -> PlacedPanel:
        """Return the panel with places, and with the static response to them."""
        basis = place_basis(self.basis, plate, places)
        panel = replace(self.start, basis=basis)
        static = static_shapes(basis, plate, static_tolerance)
        if static.shape[1]:
            basis = refined(basis, plate, basis_shapes(basis, plate, static))
            excitation, air = self.source.on_basis(basis, panel.air)
            panel = replace(panel, basis=basis, excitation=excitation, air=air)
        return place_panel(panel, plate, with_strains=self.with_strains)

    def confirm(
        self,
        panel: PlacedPanel,
        plate: StoredPlate,
        places: Places,
        scenarios: Sequence[ResponseScenario],
    ) -> list[Finalist]:
        """Return layouts at their consistent motion, in a basis checked with them.

        ``panel`` is that of `panel` with `STATIC_TOLERANCE`. Raises `ResponseError` if a damper
        feeds energy to the panel.
        """
        start = place_basis(self.basis, plate, places)
        static = static_shapes(start, plate, STATIC_TOLERANCE)
        plate = replace(plate, shapes=basis_shapes(start, plate, static).vectors)
        checked = checked_responses(panel, plate, scenarios, self.source)
        errors = checked.basis_error.tolist()
        return [finalist(case, error) for case, error in zip(checked.cases, errors, strict=True)]


@dataclass(frozen=True)
class ShakerExcitedPanel:
    """A panel whose supports move at random."""

    basis: PanelBasis  # of the panel stage
    shaker: Shaker
    mass: float  # of the panel with attached masses [kg]
    with_strains: bool
    translation: Translation = UNIT

    def panel(
        self, plate: StoredPlate, places: Places, static_tolerance: float = 1.0
    ) -> PlacedPanel:
        """Return the panel with places, and with the static response to supports and places."""
        basis = place_basis(self.basis, plate, places)
        static = static_shapes(basis, plate, static_tolerance)
        moved = self.mass, self.translation
        supported = supported_panel(basis, plate, static, self._highest, *moved)
        return self._placed(self.shaker.panel(supported), plate)

    def confirm(
        self,
        _: PlacedPanel,
        plate: StoredPlate,
        places: Places,
        scenarios: Sequence[ResponseScenario],
    ) -> list[Finalist]:
        """Return layouts at their consistent motion; see `SoundExcitedPanel.confirm`."""

        def moved(supported: SupportedPanel) -> PlacedPanel:
            return self._placed(self.shaker.panel_with(supported, scenarios), plate)

        basis = place_basis(self.basis, plate, places)
        supported, error = checked_panel(
            basis, plate, static_shapes(basis, plate, STATIC_TOLERANCE), self._highest, self.mass,
            lambda supported: [moved(supported)], scenarios, self.translation,
        )  # fmt: skip
        panel = moved(supported)
        cases = plan_cases(panel, scenarios).solve(panel.solver())
        return [finalist(case, error) for case in cases]

    @property
    def _highest(self) -> float:
        return self.shaker.settings.frequency_range[1]

    def _placed(self, panel: ResponsePanel, plate: StoredPlate) -> PlacedPanel:
        return place_panel(panel, plate, with_strains=self.with_strains)


ExcitedPanel = SoundExcitedPanel | ShakerExcitedPanel
