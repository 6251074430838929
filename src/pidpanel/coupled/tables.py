"""Rows of the tables of the coupled runs; units as in the names of the columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
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


def impedances(
    scenario: str, patches: Sequence[str], cells_of_station: int, result: CoupledResult
) -> pd.DataFrame:
    """Return a row a patch and third octave: C_e, m_a, own force.

    Parameters
    ----------
    scenario, patches
        Their names.
    cells_of_station
        Cells whose mean the own force is of.
    result
        Of the scenario.
    """
    return pd.concat(
        pd.DataFrame(
            {
                "scenario": scenario,
                "patch": name,
                "frequency_hz": result.centre,
                "equivalent_damping_n_s_m3": result.equivalent_damping[p],
                "equivalent_damping_error_n_s_m3": result.equivalent_damping_error[p],
                "apparent_mass_kg_m2": result.apparent_mass[p],
                "apparent_mass_error_kg_m2": result.apparent_mass_error[p],
                "own_psd_of_a_cell_pa2_hz": result.independent[p] * cells_of_station,
                "own_psd_in_common_pa2_hz": result.common[p],
            }
        )
        for p, name in enumerate(patches)
    )


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
