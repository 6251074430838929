"""Responses as tables: one row per scenario and point, and a dataset of the PSDs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.solve.bands import reduction
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.lines import root_mean_square
from pidpanel.solve.model import Response


def summary_rows(
    found: LayoutResponse,
    bare: LayoutResponse,
    points: Sequence[str],
    *,
    thickness: float,
    power_balance_error: float,
    full: Response,
    read_at_g: float,
    patch_motion_g: float,
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
    read_at_g, patch_motion_g
        Γ at which the damping of the patch is read, and of its motion; NaN for several patches.
    """
    rows = []
    outside = 1 - float(found.inside.all(axis=0).mean()) if len(found.inside) else 0.0
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
                "reduction_db": float(reduction(of_bare[index], acceleration)),
                "diagonal_form_error_db": float(reduction(acceleration, of_full[index])),
                "damping_read_at_g": read_at_g,
                "patch_motion_g": patch_motion_g,
                "outside_run_points_share": outside,
                "levels": found.fixed_points,
                "beyond_linear_plate": bool(displacement > thickness / 10),
                "power_balance_error": power_balance_error,
                "motion_residual": found.residual,
            }
        )
    return rows


def dead_weight_columns(
    bare: LayoutResponse, dead: LayoutResponse | None, masses: Array, panel_mass: float
) -> list[dict[str, float]]:
    """Columns of a scenario's mass, and of what the same mass does without damping, by point.

    Parameters
    ----------
    bare
        The panel without damper at the same sound level.
    dead
        The panel with the same masses in the same places; None where they are not known.
    masses
        (n_loads,) [kg].
    panel_mass
        Of the panel with what is attached to it [kg].
    """
    total, of_bare = float(masses.sum()), bare.response.acceleration_rms
    treated = np.full(of_bare.shape, np.nan) if dead is None else dead.response.acceleration_rms
    if not len(masses):
        treated = of_bare
    gained = reduction(of_bare, treated)
    return [
        {
            "added_mass_kg": total,
            "added_mass_percent": 100 * total / panel_mass,
            "dead_weight_acceleration_rms_g": own / STANDARD_GRAVITY,
            "dead_weight_reduction_db": lowered,
        }
        for own, lowered in zip(treated.tolist(), gained.tolist(), strict=True)
    ]


def beside_rows(
    found: LayoutResponse, bare: LayoutResponse, points: Sequence[str], read_at_g: float
) -> list[dict[str, Any]]:
    """Rms acceleration of a scenario under another assumption, a row per point.

    Parameters are those of `summary_rows`.
    """
    acceleration, of_bare = found.response.acceleration_rms, bare.response.acceleration_rms
    return [
        {
            "point": point,
            "acceleration_rms_g": acceleration[index] / STANDARD_GRAVITY,
            "reduction_db": float(reduction(of_bare[index], acceleration[index])),
            "damping_read_at_g": read_at_g,
        }
        for index, point in enumerate(points)
    ]


@dataclass(frozen=True)
class OnPatches:
    """A response with the damping on every patch of the panel.

    Attributes
    ----------
    response
        PSDs at the points.
    equivalent_damping, apparent_mass
        (n_patches, nf) C_e [N s/m³] and m_a [kg/m²]; 0 where the patch is not filled.
    inside
        (n_patches, nf) whether the damping is within the simulated range.
    """

    response: Response
    equivalent_damping: Array
    apparent_mass: Array
    inside: Array


def psd_dataset(
    found: Mapping[tuple[str, str], OnPatches],
    dead_weight: Mapping[tuple[str, str], Array],
    frequency: Array,
    readings: Sequence[str],
    labels: Sequence[str],
    points: Sequence[str],
    patches: Sequence[str],
) -> xr.Dataset:
    """PSDs, C_e and m_a of all scenarios; NaN where a scenario has no response.

    Parameters
    ----------
    found
        By (reading, scenario label).
    dead_weight
        Acceleration PSDs (nf, n_points) with the same masses and no damping.
    frequency
        (nf,) [Hz].
    readings, labels, points, patches
        The coordinates.
    """
    shape = (len(readings), len(labels), len(frequency))
    acceleration, velocity, displacement, dead = np.full((4, *shape, len(points)), np.nan)
    damping, mass, inside = np.full((3, *shape[:2], len(patches), shape[2]), np.nan)
    for (reading, label), psd in dead_weight.items():
        dead[readings.index(reading), labels.index(label)] = psd
    for (reading, label), one in found.items():
        at = (readings.index(reading), labels.index(label))
        acceleration[at] = one.response.acceleration_psd
        velocity[at] = one.response.velocity_psd
        displacement[at] = one.response.displacement_psd
        damping[at], mass[at], inside[at] = one.equivalent_damping, one.apparent_mass, one.inside
    dims = ("reading", "scenario", "frequency")
    by_patch = ("reading", "scenario", "patch", "frequency")
    variables: list[tuple[str, tuple[str, ...], Array, str, str]] = [
        ("acceleration_psd", (*dims, "point"), acceleration, "m2 s-4 Hz-1",
         "one-sided acceleration PSD"),
        ("velocity_psd", (*dims, "point"), velocity, "m2 s-2 Hz-1", "one-sided velocity PSD"),
        ("displacement_psd", (*dims, "point"), displacement, "m2 Hz-1",
         "one-sided displacement PSD"),
        ("dead_weight_acceleration_psd", (*dims, "point"), dead, "m2 s-4 Hz-1",
         "one-sided acceleration PSD with the same masses and no damping"),
        ("equivalent_damping", by_patch, damping, "N s m-3", "C_e of the patch, 0 if not filled"),
        ("apparent_mass", by_patch, mass, "kg m-2", "m_a of the patch, 0 if not filled"),
        ("inside", by_patch, inside, "1", "1 where the damping is within the simulated range"),
    ]  # fmt: skip
    # a NetCDF 3 file has no dimension of length 0
    kept = [one for one in variables if patches or "patch" not in one[1]]
    return xr.Dataset(
        {
            name: (of, values, {"units": units, "long_name": long_name})
            for name, of, values, units, long_name in kept
        },
        coords={
            "frequency": ("frequency", frequency, {"units": "Hz", "long_name": "frequency"}),
            "reading": list(readings),
            "scenario": list(labels),
            "point": list(points),
            **({"patch": list(patches)} if patches else {}),
        },
    )


SHOWN = {"1": ("microstrain", 1e6), "Pa": ("MPa", 1e-6)}
"""Unit of a quantity: the unit a person reads, and its factor."""


def stress_rows(
    frequency: Array,
    psd: Array,
    quantities: Mapping[str, str],
    points: Sequence[str],
    log_error: Array | None = None,
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
    log_error
        (nf, n_points) standard error of ln of the acceleration PSD, as which that of the strain
        counts at the same line, all lines erring together; None without errors.
    """
    rms = root_mean_square(frequency, psd)
    error = np.full(rms.shape, np.nan)
    if log_error is not None:
        of_square = np.trapezoid(psd * log_error[:, :, None], frequency, axis=0)
        error = np.divide(of_square, 2 * rms**2, out=np.zeros_like(rms), where=rms > 0)
    rows = []
    for index, point in enumerate(points):
        for (quantity, unit), value, own in zip(
            quantities.items(), rms[index], error[index], strict=True
        ):
            shown, factor = SHOWN[unit]
            row = {"point": point, "quantity": quantity, "unit": shown}
            sizes = {"rms": value * factor, "three_sigma": 3 * value * factor}
            rows.append({**row, **sizes, "relative_error": own})
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
