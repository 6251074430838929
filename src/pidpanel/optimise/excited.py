"""The panel of a study under each excitation that a search counts, with dampers on places.

Each plate has the places as its patches. Layouts are confirmed in a basis that is checked with
them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.base.panel import Shaker
from pidpanel.damping.readings import DampingReading
from pidpanel.optimise.finalists import Finalist, confirm, confirm_on_shaker
from pidpanel.optimise.placed import PlacedPanel, place_basis, place_panel
from pidpanel.optimise.places import Places
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.dampers import DampingModels, PatchFilling
from pidpanel.response.panel import ExcitationSource, ResponsePanel
from pidpanel.solve.supports import SupportedPanel, supported_panel


@dataclass(frozen=True)
class UnderSound:
    """A panel in its sound field."""

    start: ResponsePanel
    source: ExcitationSource
    with_strains: bool

    def panel(self, plate: StoredPlate, places: Places) -> PlacedPanel:
        """Return the panel with places."""
        panel = replace(self.start, basis=place_basis(self.start.basis, plate, places))
        return place_panel(panel, places.area, with_strains=self.with_strains)

    def confirm(
        self,
        plate: StoredPlate,
        places: Places,
        layouts: Sequence[Sequence[PatchFilling]],
        models: Mapping[str, DampingReading],
    ) -> list[Finalist]:
        """Return layouts at their consistent motion."""
        return confirm(self.panel(plate, places), plate, layouts, models, self.source)


@dataclass(frozen=True)
class OnShaker:
    """A panel whose supports move at random."""

    start: PanelBasis
    shaker: Shaker
    mass: float  # of the panel with attached masses [kg]
    with_strains: bool

    def panel(self, plate: StoredPlate, places: Places) -> PlacedPanel:
        """Return the panel with places, and with the static response to its supports."""
        basis, none = place_basis(self.start, plate, places), np.zeros((len(plate.shapes), 0))
        highest = self.shaker.settings.frequency_range[1]
        supported = supported_panel(basis, plate, none, highest, self.mass)
        return self._placed(self.shaker.panel(supported), places)

    def confirm(
        self,
        plate: StoredPlate,
        places: Places,
        layouts: Sequence[Sequence[PatchFilling]],
        models: Mapping[str, DampingReading],
    ) -> list[Finalist]:
        """Return layouts at their consistent motion."""

        def moved(
            supported: SupportedPanel, scenarios: Sequence[ResponseScenario], stated: DampingModels
        ) -> PlacedPanel:
            return self._placed(self.shaker.panel_with(supported, scenarios, stated), places)

        basis = place_basis(self.start, plate, places)
        highest = self.shaker.settings.frequency_range[1]
        return confirm_on_shaker(basis, plate, layouts, models, moved, highest, self.mass)

    def _placed(self, panel: ResponsePanel, places: Places) -> PlacedPanel:
        return place_panel(panel, places.area, with_strains=self.with_strains)


Excited = UnderSound | OnShaker
