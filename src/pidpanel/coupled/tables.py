"""Rows of the tables of the coupled runs; units as in the names of the columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.carried import FoundBed, between, beyond
from pidpanel.coupled.results import CoupledResult


def decibels(ln_mean_square: Array) -> Array:
    """Return dB of ln of a mean square.

    Examples
    --------
    >>> float(decibels(np.log(100.0)))
    20.0
    """
    found: Array = 10 / np.log(10) * ln_mean_square
    return found


def summary(
    scenario: str, points: Sequence[str], bare: Array, result: CoupledResult
) -> pd.DataFrame:
    """Return a row a point: rms values, with and without the beds' own force.

    Parameters
    ----------
    scenario, points
        Their names.
    bare
        (p,) rms acceleration of the bare panel [m/s²].
    result
        Of the scenario.
    """
    g_rms = np.sqrt(result.mean_square) / STANDARD_GRAVITY
    return pd.DataFrame(
        {
            "scenario": scenario,
            "point": list(points),
            "bare_g_rms": bare / STANDARD_GRAVITY,
            "g_rms": g_rms,
            "g_rms_error": g_rms * result.mean_square_error / 2,
            "linear_g_rms": np.sqrt(result.linear_mean_square) / STANDARD_GRAVITY,
            "residual_db": decibels(result.mean_square_residual),
            "simulated_own_share": result.simulated_own,
        }
    )


def third_octaves(scenario: str, points: Sequence[str], result: CoupledResult) -> pd.DataFrame:
    """Return a row a point and third octave; parameters are those of `summary`."""
    return pd.concat(
        pd.DataFrame(
            {
                "scenario": scenario,
                "point": name,
                "frequency_hz": result.centre,
                "g_rms": np.sqrt(result.band_squares[:, p]) / STANDARD_GRAVITY,
                "error_db": decibels(result.band_error[:, p]),
                "residual_db": decibels(result.band_residual[:, p]),
            }
        )
        for p, name in enumerate(points)
    )


class SimulatedBed(NamedTuple):
    """What was simulated of the bed of a patch.

    Attributes
    ----------
    patch
        Its name.
    cell_area
        Of a cell [m²].
    cells_of_station
        Cells whose mean the own force is of.
    mass_per_area
        Of the particles [kg/m²].
    """

    patch: str
    cell_area: float
    cells_of_station: int
    mass_per_area: float


def impedances(scenario: str, beds: Sequence[SimulatedBed], result: CoupledResult) -> pd.DataFrame:
    """Return a row a patch and third octave: C_e, m_a, own force.

    Parameters
    ----------
    scenario, beds
        Its name, and the bed of each patch.
    result
        Of the scenario.
    """
    return pd.concat(
        pd.DataFrame(
            {
                "scenario": scenario,
                "patch": bed.patch,
                "frequency_hz": result.centre,
                "equivalent_damping_n_s_m3": result.equivalent_damping[p],
                "equivalent_damping_error_n_s_m3": result.equivalent_damping_error[p],
                "apparent_mass_kg_m2": result.apparent_mass[p],
                "apparent_mass_error_kg_m2": result.apparent_mass_error[p],
                "own_psd_of_a_cell_pa2_hz": result.independent[p] * bed.cells_of_station,
                "own_psd_in_common_pa2_hz": result.common[p],
                "cell_area_m2": bed.cell_area,
                "particle_mass_per_area_kg_m2": bed.mass_per_area,
                "common_error": 0.0,
                "carried_from": "",
            }
        )
        for p, bed in enumerate(beds)
    )


OF_A_BED = {
    "equivalent_damping": "equivalent_damping_n_s_m3",
    "equivalent_damping_error": "equivalent_damping_error_n_s_m3",
    "apparent_mass": "apparent_mass_kg_m2",
    "apparent_mass_error": "apparent_mass_error_kg_m2",
    "of_a_cell": "own_psd_of_a_cell_pa2_hz",
    "in_common": "own_psd_in_common_pa2_hz",
}
"""Columns by the names of `carried.FoundBed`."""


def carried_impedances(
    scenario: str, source: str, level: float, near: Sequence[tuple[float, pd.DataFrame]]
) -> pd.DataFrame:
    """Return the rows of `impedances` of a scenario that was not run, from one or two levels.

    Parameters
    ----------
    scenario, source
        Its name, and those of the runs.
    level
        Of it [dB].
    near
        Levels that were run, rising, and their rows.
    """

    def bed(rows: pd.DataFrame) -> FoundBed:
        return FoundBed.of({name: rows[column].to_numpy() for name, column in OF_A_BED.items()})

    parts = []
    for patch, like in near[0][1].groupby("patch", sort=False):
        beds = [bed(table[table["patch"] == patch]) for _, table in near]
        if len(near) == 1:
            found = beyond(level - near[0][0], *beds)
        else:
            low, high = near[0][0], near[1][0]
            found = between((level - low) / (high - low), *beds)
        values = {column: getattr(found, name) for name, column in OF_A_BED.items()}
        parts.append(
            like.assign(
                scenario=scenario, **values, common_error=found.common_error, carried_from=source
            )
        )
    return pd.concat(parts)


def psds(
    scenario: str, points: Sequence[str], frequency: Array, result: CoupledResult
) -> pd.DataFrame:
    """Return a row a point and line; parameters are those of `summary`, and (nf,) lines [Hz]."""
    scale = (2 * np.pi * frequency) ** 4 / STANDARD_GRAVITY**2
    return pd.concat(
        pd.DataFrame(
            {
                "scenario": scenario,
                "point": name,
                "frequency_hz": frequency,
                "acceleration_psd_g2_hz": scale * result.displacement_psd[:, p],
                "error_db": decibels(result.ln_error[:, p]),
                "linear_acceleration_psd_g2_hz": scale * result.linear_psd[:, p],
            }
        )
        for p, name in enumerate(points)
    )
