"""File of the estimate of a scenario: NetCDF; and its tables."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, variable
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.estimate import ScenarioEstimate
from pidpanel.provenance import durable
from pidpanel.solve.bands import band_rms, whole_third_octaves

DECIBEL = 10 / np.log(10)  # dB of ln of a mean square


class SimulatedBed(NamedTuple):
    """The simulated bed of a patch."""

    patch: str
    cell_area: float  # of a cell [m²]
    mass_per_area: float  # of the particles [kg/m²]
    modulus: float  # Young's modulus of the contacts [Pa]


def write_estimate(
    path: Path,
    estimate: ScenarioEstimate,
    beds: Sequence[SimulatedBed],
    points: Sequence[str],
    runs: int,
    attributes: Mapping[str, str],
) -> None:
    """Write the estimate of a scenario from its runs to a ``.nc`` file."""
    dataset = xr.Dataset(
        {**_patch_variables(estimate, beds), **_point_variables(estimate)},
        coords={
            "band": variable("band", estimate.centre, "Hz"),
            "frequency": variable("frequency", estimate.frequency, "Hz"),
            "patch": ("patch", [bed.patch for bed in beds]),
            "point": ("point", list(points)),
        },
        attrs={**attributes, "runs": runs},
    )
    with durable.replacing(path) as draft:
        dataset.to_netcdf(draft, engine="scipy")


def _patch_variables(estimate: ScenarioEstimate, beds: Sequence[SimulatedBed]) -> dict[str, Any]:
    """Return values by patch, and by patch and band."""
    rows = [
        {
            "impedance_frequency": (patch.impedance.frequency, "Hz"),
            "equivalent_damping": (patch.impedance.value.real, "N s m-3"),
            "equivalent_damping_error": (patch.equivalent_damping_error, "N s m-3"),
            "apparent_mass": (patch.impedance.apparent_mass, "kg m-2"),
            "apparent_mass_error": (patch.apparent_mass_error, "kg m-2"),
            "own_force_psd": (patch.own_force.psd, "Pa2 Hz-1"),
            "own_force_coherence": (patch.own_force.coherence, "1"),
            "own_force_error": (patch.own_force_error, "1"),
            "own_force_length": (patch.own_force.length, "m Hz"),
            "cell_area": (bed.cell_area, "m2"),
            "common_error": (patch.common_error, "1"),
            "mass_per_area": (bed.mass_per_area, "kg m-2"),
            "youngs_modulus": (bed.modulus, "Pa"),
        }
        for patch, bed in zip(estimate.patches, beds, strict=True)
    ]
    variables = {}
    for name, (_, units) in rows[0].items():
        values = np.array([row[name][0] for row in rows], dtype=np.float64)
        variables[name] = variable("patch band" if values.ndim == 2 else "patch", values, units)
    return variables


def _point_variables(estimate: ScenarioEstimate) -> dict[str, Any]:
    """Return values by point, and by point and line or band."""
    lines, bands = "frequency point", "band point"
    return {
        "displacement_psd": variable(lines, estimate.psd, "m2 Hz-1"),
        "linear_displacement_psd": variable(lines, estimate.linear_psd, "m2 Hz-1"),
        "displacement_psd_log_error": variable(lines, estimate.log_psd_error, "1"),
        "band_log_error": variable(bands, estimate.log_band_error, "1"),
        "band_residual": variable(bands, estimate.band_residual, "1"),
        "log_error": variable("point", estimate.log_error, "1"),
        "residual": variable("point", estimate.residual, "1"),
        "recorded": variable("point", estimate.recorded, "m2 s-4"),
    }


def frames(scenario: str, stored: xr.Dataset) -> dict[str, pd.DataFrame]:
    """Return the tables of a scenario by name; units as in the names of the columns."""
    frequency = stored["frequency"].to_numpy()
    scale = ((2 * np.pi * frequency) ** 4 / STANDARD_GRAVITY**2)[:, None]
    names = ("displacement_psd", "linear_displacement_psd")
    psd, linear = (scale * stored[name].to_numpy() for name in names)
    centre, edge = whole_third_octaves(frequency[0], frequency[-1])
    squares, linear_squares = (np.trapezoid(v, frequency, axis=0) for v in (psd, linear))
    points = [str(name) for name in stored["point"].to_numpy()]
    g_rms = np.sqrt(squares)
    recorded = np.sqrt(stored["recorded"].to_numpy()) / STANDARD_GRAVITY
    summary = pd.DataFrame(
        {
            "scenario": scenario,
            "point": points,
            "g_rms": g_rms,
            "g_rms_error": g_rms * stored["log_error"].to_numpy() / 2,
            "linear_g_rms": np.sqrt(linear_squares),
            "recorded_g_rms": recorded,
            "residual_db": DECIBEL * stored["residual"].to_numpy(),
            "runs": int(stored.attrs["runs"]),
        }
    )

    def long_table(axis: Array, columns: Mapping[str, Array]) -> pd.DataFrame:
        frames = []
        for p, name in enumerate(points):
            first = {"scenario": scenario, "point": name, "frequency_hz": axis}
            of_point = {column: values[:, p] for column, values in columns.items()}
            frames.append(pd.DataFrame(first | of_point))
        return pd.concat(frames)

    third_octaves = {
        "g_rms": band_rms(frequency, psd, edge),
        "error_db": DECIBEL * stored["band_log_error"].to_numpy(),
        "residual_db": DECIBEL * stored["band_residual"].to_numpy(),
    }
    lines = {
        "acceleration_psd_g2_hz": psd,
        "error_db": DECIBEL * stored["displacement_psd_log_error"].to_numpy(),
        "linear_acceleration_psd_g2_hz": linear,
    }
    return {
        "summary": summary,
        "third_octaves": long_table(centre, third_octaves),
        "psd": long_table(frequency, lines),
        "impedance": _impedance(scenario, stored),
    }


# Columns of the table whose names do not follow from those in the file of an estimate.
RENAMED = {
    "impedance_frequency": "frequency_hz",
    "mass_per_area": "particle_mass_per_area_kg_m2",
    "youngs_modulus": "youngs_modulus_mpa",
}


def _impedance(scenario: str, stored: xr.Dataset) -> pd.DataFrame:
    """Return what is known of patches by band; names of the columns end with the unit."""
    values = stored[[name for name in stored.data_vars if stored[name].dims[0] == "patch"]]
    rows = values.to_dataframe(["patch", "band"]).reset_index()
    names = {
        str(name): f"{name}_{_suffix(variable.attrs['units'])}"
        for name, variable in values.variables.items()
        if variable.attrs.get("units", "1") != "1"
    }
    rows = rows.rename(columns=names | RENAMED)
    rows["youngs_modulus_mpa"] /= 1e6
    rows.insert(0, "scenario", scenario)
    return rows


def _suffix(unit: str) -> str:
    """Return ``n_s_m3`` of ``N s m-3``, and ``pa2_hz`` of ``Pa2 Hz-1``."""
    return unit.lower().replace("-1", "").replace("-", "").replace(" ", "_")
