"""Responses as tables: one row per scenario and point, and a dataset of the PSDs."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.lines import root_mean_square
from pidpanel.response.model import Response
from pidpanel.response.scenarios import ScenarioResponse


def summary_rows(
    found: ScenarioResponse,
    bare: ScenarioResponse,
    points: Sequence[str],
    *,
    thickness: float,
    power_balance_error: float,
    full: Response,
) -> list[dict[str, Any]]:
    """Rms values of a scenario, a row per point.

    Parameters
    ----------
    found, bare
        The scenario and the panel without damper at the same sound level.
    points
        Names of the response points.
    thickness
        Of the panel [m]: linear plate theory is left when w_rms exceeds a tenth of it.
    power_balance_error
        Largest |put in − lost| / put in over the lines looked at.
    full
        The response with the full modal damping matrix: that of the scenario, unless the paper's
        diagonal form was asked for.
    """
    rows = []
    accelerations, velocities = found.response.acceleration_rms, found.response.velocity_rms
    displacements = found.response.displacement_rms
    of_bare, of_full = bare.response.acceleration_rms, full.acceleration_rms
    for index, point in enumerate(points):
        acceleration, displacement = accelerations[index], displacements[index]
        rows.append(
            {
                "point": point,
                "acceleration_rms_g": acceleration / STANDARD_GRAVITY,
                "velocity_rms_m_s": velocities[index],
                "displacement_rms_mm": displacement * 1e3,
                "reduction_db": 20 * np.log10(of_bare[index] / acceleration),
                "diagonal_form_error_db": 20 * np.log10(acceleration / of_full[index]),
                "damping_read_at_g": _of_one_load(found.acceleration_g),
                "patch_motion_g": _of_one_load(
                    found.patch_acceleration_g
                    if found.loads.size
                    else found.bare_patch_acceleration_g[:1]
                ),
                "outside_run_points_share": 1 - float(np.mean(found.inside.all(axis=0))),
                "levels": found.fixed_points,
                "beyond_linear_plate": bool(displacement > thickness / 10),
                "power_balance_error": power_balance_error,
            }
        )
    return rows


def _of_one_load(values: Array) -> float:
    """Return the value of the one load; NaN for the bare panel."""
    return float(values[0]) if values.size else np.nan


def beside_rows(
    found: ScenarioResponse, bare: ScenarioResponse, points: Sequence[str]
) -> list[dict[str, Any]]:
    """Rms acceleration of a scenario under another assumption, a row per point.

    Parameters are those of `summary_rows`.
    """
    acceleration, of_bare = found.response.acceleration_rms, bare.response.acceleration_rms
    return [
        {
            "point": point,
            "acceleration_rms_g": acceleration[index] / STANDARD_GRAVITY,
            "reduction_db": 20 * np.log10(of_bare[index] / acceleration[index]),
            "damping_read_at_g": _of_one_load(found.acceleration_g),
        }
        for index, point in enumerate(points)
    ]


def psd_dataset(
    found: Mapping[tuple[str, str], ScenarioResponse],
    frequency: Array,
    readings: Sequence[str],
    labels: Sequence[str],
    points: Sequence[str],
) -> xr.Dataset:
    """PSDs, C_e and m_a of all scenarios; NaN where a scenario has no response.

    Parameters
    ----------
    found
        By (reading, scenario label).
    frequency
        (nf,) [Hz].
    readings, labels, points
        The coordinates.
    """
    shape = (len(readings), len(labels), len(frequency))
    acceleration, velocity, displacement = np.full((3, *shape, len(points)), np.nan)
    damping, mass, inside = np.full((3, *shape), np.nan)
    for (reading, label), one in found.items():
        at = (readings.index(reading), labels.index(label))
        acceleration[at] = one.response.acceleration_psd
        velocity[at] = one.response.velocity_psd
        displacement[at] = one.response.displacement_psd
        damping[at] = one.equivalent_damping.sum(axis=0)
        mass[at] = one.apparent_mass.sum(axis=0)
        inside[at] = one.inside.all(axis=0)
    dims = ("reading", "scenario", "frequency")
    variables: list[tuple[str, tuple[str, ...], Array, str, str]] = [
        ("acceleration_psd", (*dims, "point"), acceleration, "m2 s-4 Hz-1",
         "one-sided acceleration PSD"),
        ("velocity_psd", (*dims, "point"), velocity, "m2 s-2 Hz-1", "one-sided velocity PSD"),
        ("displacement_psd", (*dims, "point"), displacement, "m2 Hz-1",
         "one-sided displacement PSD"),
        ("equivalent_damping", dims, damping, "N s m-3", "C_e of the patch"),
        ("apparent_mass", dims, mass, "kg m-2", "m_a of the patch"),
        ("inside", dims, inside, "1", "1 where the damping is within the simulated range"),
    ]  # fmt: skip
    return xr.Dataset(
        {
            name: (of, values, {"units": units, "long_name": long_name})
            for name, of, values, units, long_name in variables
        },
        coords={
            "frequency": ("frequency", frequency, {"units": "Hz", "long_name": "frequency"}),
            "reading": list(readings),
            "scenario": list(labels),
            "point": list(points),
        },
    )


SHOWN = {"1": ("microstrain", 1e6), "Pa": ("MPa", 1e-6)}
"""Unit of a quantity: the unit a person reads, and its factor."""


def stress_rows(
    frequency: Array, psd: Array, quantities: Mapping[str, str], points: Sequence[str]
) -> list[dict[str, Any]]:
    """Rms and three sigma, a row per point and quantity.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    psd
        (nf, n_points, n_quantities) [unit²/Hz].
    quantities
        Names and SI units, see `stress.QUANTITIES`.
    points
        Names of the response points.
    """
    rms = root_mean_square(frequency, psd)
    rows = []
    for index, point in enumerate(points):
        for (quantity, unit), value in zip(quantities.items(), rms[index], strict=True):
            shown, factor = SHOWN[unit]
            row = {"point": point, "quantity": quantity, "unit": shown}
            rows.append({**row, "rms": value * factor, "three_sigma": 3 * value * factor})
    return rows


def stress_dataset(
    found: Mapping[tuple[str, str], Array],
    frequency: Array,
    readings: Sequence[str],
    labels: Sequence[str],
    points: Sequence[str],
    layers: Sequence[str],
    quantities: Mapping[str, str],
) -> xr.Dataset:
    """PSDs of strain and stress in single precision; NaN where a scenario has no response.

    Parameters
    ----------
    found
        By (reading, scenario label): (nf, n_points, n_layers, n_quantities) [unit²/Hz].
    frequency
        (nf,) [Hz].
    readings, labels, points, layers
        The coordinates.
    quantities
        Names and SI units.
    """
    shape = (len(readings), len(labels), len(frequency), len(points), len(layers))
    values = np.full((*shape, len(quantities)), np.nan, dtype=np.float32)
    for (reading, label), psd in found.items():
        values[readings.index(reading), labels.index(label)] = psd
    dims = ("reading", "scenario", "frequency", "point", "layer")
    return xr.Dataset(
        {
            f"{name}_psd": (
                dims,
                values[..., index],
                {
                    "units": "Hz-1" if unit == "1" else f"{unit}2 Hz-1",
                    "long_name": f"one-sided PSD of {name}",
                },
            )
            for index, (name, unit) in enumerate(quantities.items())
        },
        coords={
            "frequency": ("frequency", frequency, {"units": "Hz", "long_name": "frequency"}),
            "reading": list(readings),
            "scenario": list(labels),
            "point": list(points),
            "layer": list(layers),
        },
    )
