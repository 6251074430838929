"""Measured or foreign damping as CSV, with units in the names of the columns; and ours as CSV.

A row is a point: ``fill_fraction``, ``frequency_hz``, one amplitude (``acceleration_g``,
``displacement_mm`` or ``velocity_m_s``, of a sine) and one value (``equivalent_damping_n_s_m3``,
or ``loss_factor`` with ``particle_mass_per_area_kg_m2``), each value with its standard error under
the same name and ``_error`` (``equivalent_damping_error_n_s_m3``, ``loss_factor_error``).
``#`` starts a comment.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.readings import DampingError
from pidpanel.damping.surface import AXES, ERROR, MASS, PARTICLE_MASS, VALUE, DampingSurface


def read_table(path: Path) -> pd.DataFrame:
    """Read the rows of a CSV file as `DampingSurface.from_frame` takes them.

    Raises
    ------
    DampingError
        If the file is no table of numbers or a column is missing.
    """
    try:
        frame = pd.read_csv(path, comment="#")
    except (OSError, ValueError, pd.errors.ParserError) as error:
        raise DampingError(f"not a CSV file ({error})") from None
    return in_our_terms(frame)


def read_surface(path: Path) -> DampingSurface:
    """Read the surface of a CSV file as `read_table` reads it; gravity is 1 g.

    Raises
    ------
    DampingError
        With the name of the file.
    """
    try:
        return DampingSurface.from_frame(read_table(path))
    except DampingError as error:
        raise DampingError(f"{path}: {error}") from None


def in_our_terms(frame: pd.DataFrame) -> pd.DataFrame:
    """Return amplitude as Γ and value as C_e, whatever they were given as.

    With ω = 2πf: Γ = ω² W/g = ω v/g and C_e = η m″ ω (the energy per cycle written both ways).

    Raises
    ------
    DampingError
        If a column is missing or holds what is no number above zero.
    """
    for axis in AXES[:2]:
        _numbers(frame, axis, "")
    omega = 2 * np.pi * frame["frequency_hz"].astype(float)
    given: dict[str, pd.Series] = {}
    if AXES[2] not in frame:
        if "displacement_mm" in frame:
            _numbers(frame, "displacement_mm", "")
            given[AXES[2]] = omega**2 * frame["displacement_mm"] * 1e-3 / STANDARD_GRAVITY
        else:
            _numbers(frame, "velocity_m_s", " (or displacement_mm or acceleration_g)")
            given[AXES[2]] = omega * frame["velocity_m_s"] / STANDARD_GRAVITY
    if VALUE not in frame:
        _numbers(frame, "loss_factor", f" (or {VALUE})")
        _numbers(frame, PARTICLE_MASS, " beside loss_factor")
        unit = frame[PARTICLE_MASS] * omega
        given[VALUE] = frame["loss_factor"] * unit
        if "loss_factor_error" in frame:
            given[ERROR] = frame["loss_factor_error"] * unit
    frame = frame.assign(**given)
    for column in AXES:
        _numbers(frame, column, "")
    return frame


def _numbers(frame: pd.DataFrame, column: str, alternative: str) -> None:
    """Refuse a column that is missing, or not of numbers above zero (but for the value)."""
    if column not in frame:
        raise DampingError(
            f"column {column}{alternative} is missing; there are {', '.join(frame.columns)}"
        )
    if not pd.api.types.is_numeric_dtype(frame[column]):
        raise DampingError(f"column {column} holds {frame[column].iloc[0]!r}: numbers are needed")
    if column != "loss_factor" and not (frame[column] > 0).all():
        worst = frame.loc[~(frame[column] > 0), column].iloc[0]
        raise DampingError(f"{column} = {worst:g}: above 0")


def to_frame(
    surface: DampingSurface, fills: int = 5, frequencies: int = 9, accelerations: int = 7
) -> pd.DataFrame:
    """Return the surface on even r, ln f and ln Γ within its domain, as `read_table` reads it.

    Few enough that the table can be made a surface again.
    """
    axes = (
        np.unique(np.linspace(surface.low[0], surface.high[0], fills)),
        np.unique(np.geomspace(surface.low[1], surface.high[1], frequencies)),
        np.unique(np.geomspace(surface.low[2], surface.high[2], accelerations)),
    )
    points = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)
    points = points[surface.inside(points)]
    values = surface.at(*points.T)
    frame = pd.DataFrame(points, columns=list(AXES))
    frame[VALUE], frame[ERROR] = values.equivalent_damping, values.equivalent_damping_error
    frame[MASS] = values.apparent_mass
    if np.isfinite(surface.mass_per_fill):
        frame[PARTICLE_MASS] = surface.mass_per_fill * frame["fill_fraction"]
    return frame
