"""C_e and m_a of one damper from the columns of a table of damping (docs/tables.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.table_files import (
    DAMPING,
    ERRORS,
    FREQUENCY,
    IMAGINARY,
    LOSS_FACTOR,
    MASS,
    PARTICLE_MASS,
    REAL,
    amplitude_of,
)
from pidpanel.identify.posterior import MeasuredDamping
from pidpanel.identify.prediction import Tones


def amplitude_g(columns: Mapping[str, Array]) -> Array | None:
    """Return Γ (n,) of the rows; None where they have no amplitude.

    Examples
    --------
    >>> rows = {"frequency_hz": np.array([100.0]), "displacement_mm": np.array([0.5])}
    >>> amplitude_g(rows).round(2)
    array([20.13])
    """
    name, amplitude = amplitude_of(columns)
    omega = 2 * np.pi * columns[FREQUENCY]
    if name is None:
        return None
    if name == "displacement_mm":
        return np.asarray(omega**2 * amplitude * 1e-3 / STANDARD_GRAVITY)
    return amplitude if name == "acceleration_g" else omega * amplitude / STANDARD_GRAVITY


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
    omega = 2 * np.pi * columns[FREQUENCY]
    value = next(name for name in (DAMPING, LOSS_FACTOR, REAL) if name in columns)
    unit = columns[PARTICLE_MASS] * omega if value == LOSS_FACTOR else 1.0
    damping = columns[value] * unit
    damping = np.where(damping > 0, damping, np.nan)
    error = columns[ERRORS[value]] * unit if ERRORS[value] in columns else relative_error * damping
    name, scale = (IMAGINARY, 1 / omega) if value == REAL else (MASS, np.ones_like(omega))
    mass = columns[name] * scale if name in columns else np.full(len(omega), np.nan)
    mass_error = np.full(len(omega), relative_error * particle_mass)
    if ERRORS[name] in columns:
        mass_error = columns[ERRORS[name]] * scale
    return MeasuredDamping(tones, damping, error, mass, mass_error)
