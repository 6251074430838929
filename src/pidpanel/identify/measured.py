"""C_e and m_a of one damper from the columns of a table of damping (docs/tables.md)."""

from collections.abc import Mapping

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.measured import measured_values
from pidpanel.identify.posterior import MeasuredDamping
from pidpanel.identify.prediction import Tones


def measured_table(
    columns: Mapping[str, Array], tones: Tones, relative_error: float, particle_mass: float
) -> MeasuredDamping:
    """Return what a table says of C_e and m_a.

    Parameters
    ----------
    relative_error
        Standard error of C_e over itself, and of m_a over ``particle_mass``, where the table has
        no errors.
    particle_mass
        m″ of the particles [kg/m²].
    """
    damping, error, mass, mass_error = measured_values(columns)
    damping = np.where(damping > 0, damping, np.nan)
    error = np.where(np.isnan(error), relative_error * damping, error)
    mass_error = np.where(np.isnan(mass_error), relative_error * particle_mass, mass_error)
    return MeasuredDamping(tones, damping, error, mass, mass_error)
