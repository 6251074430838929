"""Masses of the dampers of a study, as far as they are known before the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pidpanel.study.dampers import mass_in_table

if TYPE_CHECKING:
    from pidpanel.study import Study


def damper_masses(study: Study) -> dict[str, float]:
    """Return about the heaviest damper of each patch that a scenario fills [kg/m²].

    The basis follows the panel with these masses, whatever the fills of its scenarios. 0 where the
    mass is not known before the run, as of a table.
    """
    highest = study.response.frequency_hz[1]
    masses: dict[str, float] = {}
    for filling in study.fillings:
        damper, mass = study.damper_of(filling), 0.0
        if damper is not None and study.response.damper_mass:
            mass = damper.largest_mass_per_area(highest)
        masses[filling.patch] = max(masses.get(filling.patch, 0.0), mass)
    return masses


def resolved_masses(study: Study) -> dict[str, float]:
    """Return about the heaviest damper of each patch that the mesh resolves [kg/m²].

    Those of `damper_masses`, and m_a in the rows of tables.
    """
    masses = damper_masses(study)
    if not study.response.damper_mass:
        return masses
    common = study.damping.table if "table" in study.readings else None
    for filling in study.fillings:
        damper = study.damper_of(filling)
        mass = 0.0 if damper is None else damper.mass_of_rows(filling.fill_fraction)
        if common is not None:
            weighs_as = study.damping.apparent_mass
            mass = max(mass, mass_in_table(common, filling.fill_fraction, weighs_as))
        masses[filling.patch] = max(masses[filling.patch], mass)
    return masses
