"""C_e and m_a of a measured damper, compared with simulated cases and the atlas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy.spatial import KDTree

from pidpanel.arrays import Array
from pidpanel.damping.surface_cases import AXES, CASE_COLUMNS, COUNTED, logarithmic
from pidpanel.damping.table_files import (
    DAMPING,
    ERRORS,
    FILL,
    FREQUENCY,
    IMAGINARY,
    MASS,
    PARTICLE_MASS,
    amplitude_of,
    gamma_per_unit,
)
from pidpanel.damping.tables import impedance_of

if TYPE_CHECKING:
    from pidpanel.damping.atlas import AtlasDamping

SAME_POINT = 0.01  # difference of r, ln f and ln Γ up to which a case is at a measured point
SOURCES = ("measured", "simulated", "atlas")


def measured_points(columns: Mapping[str, Array], fill_fraction: float) -> pd.DataFrame:
    """Return r, f, Γ of measured points, and C_e and m_a with standard errors.

    Parameters
    ----------
    columns
        (n,) each, as `table_files.read_columns` returns them, with an amplitude.
    fill_fraction
        Fill fraction of a table without such a column [1].

    Returns
    -------
    DataFrame
        ``fill_fraction``, ``frequency_hz``, ``acceleration_g``, and values and errors as
        ``measured_equivalent_damping_n_s_m3`` and ``…_error``; NaN if the table has none.
    """
    frequency = columns[FREQUENCY]
    points = {
        "fill_fraction": columns.get(FILL, np.full_like(frequency, fill_fraction)),
        "frequency_hz": frequency,
        "acceleration_g": amplitudes_g(columns),
    }
    return pd.DataFrame(points | _named("measured", *measured_values(columns)))


def measured_values(columns: Mapping[str, Array]) -> tuple[Array, Array, Array, Array]:
    """Return C_e, m_a and their standard errors, as `impedance_of`; what there is not is NaN."""
    missing = np.full_like(columns[FREQUENCY], np.nan)
    full = {**dict.fromkeys((*ERRORS.values(), MASS, IMAGINARY), missing), **columns}
    omega = 2 * np.pi * columns[FREQUENCY]
    return impedance_of(full, omega, columns.get(PARTICLE_MASS, missing))


def amplitudes_g(columns: Mapping[str, Array]) -> Array | None:
    """Return Γ (n,) of the rows; None where they have no amplitude.

    Examples
    --------
    >>> rows = {"frequency_hz": np.array([100.0]), "displacement_mm": np.array([0.5])}
    >>> amplitudes_g(rows).round(2)
    array([20.13])
    """
    name, amplitude = amplitude_of(columns)
    if name is None:
        return None
    return np.asarray(amplitude * gamma_per_unit(name, 2 * np.pi * columns[FREQUENCY]))


def compare(points: pd.DataFrame, cases: pd.DataFrame, atlas: AtlasDamping | None) -> pd.DataFrame:
    """Return measured points with the simulated case and the atlas at each.

    Parameters
    ----------
    points
        Points returned by `measured_points`.
    cases
        ``coupon/cases.csv``.
    atlas
        C_e and m_a of the coupon under tones; None outside the atlas.

    Returns
    -------
    DataFrame
        The points with columns ``simulated_…`` and ``atlas_…`` as those of ``measured_…``; NaN
        where no case has the point, or outside the atlas.
    """
    good = cases.loc[cases["status"].isin(COUNTED), CASE_COLUMNS].to_numpy(float)
    axes = points[list(AXES)].to_numpy(float)
    tree = KDTree(logarithmic(good[:, :3]))
    _, nearest = tree.query(logarithmic(axes), p=np.inf, distance_upper_bound=SAME_POINT)
    simulated = np.vstack([good[:, 3:], np.full(4, np.nan)])[nearest]  # the last for no case
    read = np.array([np.full(4, np.nan) if atlas is None else atlas_point(atlas, *point)
                     for point in axes])  # fmt: skip
    return points.assign(**_named("simulated", *simulated.T), **_named("atlas", *read.T))


def atlas_point(atlas: AtlasDamping, fill: float, frequency: float, gamma: float) -> Array:
    """Return C_e, m_a and their standard errors (4,) at a point; NaN outside the atlas."""
    f = np.array([frequency])
    values = atlas(f, fill, gamma)
    if not values.inside[0]:
        return np.full(4, np.nan)
    mass_error = np.sqrt(atlas.covariance(f, fill, gamma)[1, 1:])
    damping = values.equivalent_damping, values.equivalent_damping_error
    return np.concatenate([*damping, values.apparent_mass, mass_error])


def _named(source: str, *values: Array) -> dict[str, Array]:
    """Return C_e, its error, m_a and its error as columns of a source."""
    names = (DAMPING, f"{DAMPING}_error", MASS, f"{MASS}_error")
    return {f"{source}_{name}": value for name, value in zip(names, values, strict=True)}
