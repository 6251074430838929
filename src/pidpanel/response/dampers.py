"""Dampers on the patches of a scenario, each with the damping model that is used for it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.constants import BY_DAMPER
from pidpanel.damping.coupled import COUPLED, CoupledDamping
from pidpanel.damping.models import DampingModel
from pidpanel.paths import SECTION
from pidpanel.solve.layout import AttachedDamper

# Γ at which the mass of a damper is taken before its motion is known.
MOTIONS_G = (1.0, 10.0, 100.0, 1000.0)


@dataclass(frozen=True)
class PatchFilling:
    """A patch of a scenario with its damper."""

    # Names; the damper is None where one law or table holds for all patches
    patch: str
    damper: str | None
    fill_fraction: float | None  # r; None where the damper has none


@dataclass(frozen=True)
class PatchDamper:
    """A damper on a patch, or on an element of it."""

    patch: int
    carrier: int
    # Name of its damper, or of the law or table for all patches: dampers of the same source share
    # their damping, and its errors
    source: str
    model: DampingModel
    fill_fraction: float
    # Coupled runs with a force of the particles; None for none
    own_force: CoupledDamping | None = None

    @property
    def mass_per_area(self) -> float:
        """Mass of the particles [kg/m²]; NaN where it is not known."""
        return self.model.mass_per_area(self.fill_fraction)

    def largest_mass(self, frequency: Array) -> float:
        """Return the largest of its mass and its apparent mass over frequency [kg/m²]."""
        motions = MOTIONS_G if self.model.depends_on_acceleration else MOTIONS_G[:1]
        apparent = [
            self.model(frequency, self.fill_fraction, gamma).apparent_mass.max()
            for gamma in motions
        ]
        return float(np.nanmax([self.mass_per_area, *apparent]))

    @property
    def attached(self) -> AttachedDamper:
        """The damper as the solver takes it."""

        def damping(frequency: Array, gamma: float) -> tuple[Array, Array, Flags]:
            values = self.model(frequency, self.fill_fraction, gamma)
            return values.equivalent_damping, values.apparent_mass, values.inside

        return AttachedDamper(self.carrier, damping, self.model.depends_on_acceleration)


@dataclass(frozen=True)
class DampingModels:
    """The damping models of a study.

    Parameters
    ----------
    names
        Names of all models of the study in order.
    common
        Models that hold for every patch, by name.
    by_damper
        Models of single dampers, by the names of the model and of the damper. A damper without the
        model has that of ``stated``.
    coupled
        Results of coupled runs by scenario and patch, for ``coupled``; other patches have the model
        ``stated``.
    """

    names: Sequence[str]
    common: Mapping[str, DampingModel]
    by_damper: Mapping[str, Mapping[str, DampingModel]]
    coupled: Mapping[tuple[str, str], CoupledDamping] = field(default_factory=dict)

    def damper(
        self, name: str, scenario: str, filling: PatchFilling, patch: int, carrier: int
    ) -> PatchDamper:
        """Return the damper on a patch of a scenario, or on an element of it."""
        # constants do not depend on the fill, so a full cell is assumed
        fill = 1.0 if filling.fill_fraction is None else filling.fill_fraction
        bed = self.coupled.get((scenario, filling.patch))
        if name == COUPLED and bed is not None:
            # each patch has its own motion, and its own errors
            source = f"{filling.damper} on {filling.patch}"
            return PatchDamper(patch, carrier, source, bed, fill, bed)
        if name in BY_DAMPER:
            damper = str(filling.damper)
            models = {**self.by_damper["stated"], **self.by_damper.get(name, {})}
            model = models[damper]
            return PatchDamper(patch, carrier, damper, model, fill)
        source = SECTION if name == "dem" else name
        return PatchDamper(patch, carrier, source, self.common[name], fill)
