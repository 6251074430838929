"""Responses as tables: one row per scenario and point, and a dataset of the PSDs."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.model import Floats
from pidpanel.response.scenarios import ScenarioResponse


def summary_rows(
    found: ScenarioResponse,
    bare: ScenarioResponse,
    points: Sequence[str],
    *,
    thickness: float,
    power_balance_error: float,
) -> list[dict[str, Any]]:
    """Rms values of a scenario, a row per point.

    Parameters
    ----------
    found, bare
        The scenario and the panel without damper at the same sound level.
    points
        Names of the response points.
    thickness
        Of the panel, m: linear plate theory is left when w_rms exceeds a tenth of it.
    power_balance_error
        Largest |put in − lost| / put in over the lines looked at.
    """
    rows = []
    for index, point in enumerate(points):
        acceleration = found.response.acceleration_rms[index]
        displacement = found.response.displacement_rms[index]
        rows.append(
            {
                "point": point,
                "acceleration_rms_g": acceleration / STANDARD_GRAVITY,
                "displacement_rms_mm": displacement * 1e3,
                "reduction_db": 20 * np.log10(bare.response.acceleration_rms[index] / acceleration),
                "damping_read_at_g": found.acceleration_g,
                "patch_motion_g": found.patch_acceleration_g,
                "outside_run_points_share": 1 - float(np.mean(found.inside)),
                "levels": found.levels,
                "beyond_linear_plate": bool(displacement > thickness / 10),
                "power_balance_error": power_balance_error,
            }
        )
    return rows


def psd_dataset(
    found: Mapping[tuple[str, str], ScenarioResponse],
    frequency: Floats,
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
        (nf,) Hz.
    readings, labels, points
        The coordinates.
    """
    shape = (len(readings), len(labels), len(frequency))
    acceleration = np.full((*shape, len(points)), np.nan)
    displacement = acceleration.copy()
    damping, mass, inside = np.full((3, *shape), np.nan)
    for (reading, label), one in found.items():
        at = (readings.index(reading), labels.index(label))
        acceleration[at] = one.response.acceleration_psd
        displacement[at] = one.response.displacement_psd
        damping[at], mass[at], inside[at] = one.equivalent_damping, one.apparent_mass, one.inside
    dims = ("reading", "scenario", "frequency")
    variables: list[tuple[str, tuple[str, ...], Floats, str, str]] = [
        ("acceleration_psd", (*dims, "point"), acceleration, "m2 s-4 Hz-1",
         "one-sided acceleration PSD"),
        ("displacement_psd", (*dims, "point"), displacement, "m2 Hz-1",
         "one-sided displacement PSD"),
        ("equivalent_damping", dims, damping, "N s m-3", "C_e of the patch"),
        ("apparent_mass", dims, mass, "kg m-2", "m_a of the patch"),
        ("inside", dims, inside, "1", "1 where the damping rests on run points"),
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
