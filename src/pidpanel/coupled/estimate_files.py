"""Tables of the estimate of a scenario, and the NetCDF file that keeps them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.estimate import PatchEstimate, ScenarioEstimate
from pidpanel.provenance import durable
from pidpanel.solve.bands import band_rms, whole_third_octaves

DECIBEL = 10 / np.log(10)  # dB of ln of a mean square


class SimulatedBed(NamedTuple):
    """The simulated bed of a patch."""

    patch: str
    cell_area: float  # of a cell [m²]
    mass_per_area: float  # of the particles [kg/m²]
    modulus: float  # Young's modulus of the contacts [Pa]


def estimate_tables(
    estimate: ScenarioEstimate, beds: Sequence[SimulatedBed], points: Sequence[str], runs: int
) -> dict[str, pd.DataFrame]:
    """Return the tables of a scenario by name; units as in the names of the columns."""
    frequency = estimate.frequency
    scale = ((2 * np.pi * frequency) ** 4 / STANDARD_GRAVITY**2)[:, None]
    psd, linear = scale * estimate.psd, scale * estimate.linear_psd
    centre, edge = whole_third_octaves(frequency[0], frequency[-1])
    g_rms, linear_g_rms = (np.sqrt(np.trapezoid(v, frequency, axis=0)) for v in (psd, linear))
    summary = {
        "point": list(points),
        "g_rms": g_rms,
        "g_rms_error": g_rms * estimate.log_error / 2,
        "linear_g_rms": linear_g_rms,
        "recorded_g_rms": np.sqrt(estimate.recorded) / STANDARD_GRAVITY,
        "residual_db": DECIBEL * estimate.residual,
        "runs": runs,
    }

    def long_table(axis: Array, columns: Mapping[str, Array]) -> pd.DataFrame:
        frames = []
        for p, name in enumerate(points):
            of_point = {column: values[:, p] for column, values in columns.items()}
            frames.append(pd.DataFrame({"point": name, "frequency_hz": axis, **of_point}))
        return pd.concat(frames)

    third_octaves = {
        "g_rms": band_rms(frequency, psd, edge),
        "error_db": DECIBEL * estimate.log_band_error,
        "residual_db": DECIBEL * estimate.band_residual,
    }
    lines = {
        "acceleration_psd_g2_hz": psd,
        "error_db": DECIBEL * estimate.log_psd_error,
        "linear_acceleration_psd_g2_hz": linear,
    }
    patches = zip(estimate.patches, beds, strict=True)
    return {
        "summary": pd.DataFrame(summary),
        "third_octaves": long_table(centre, third_octaves),
        "psd": long_table(frequency, lines),
        "impedance": pd.concat(_impedance(estimate.centre, *patch) for patch in patches),
    }


def _impedance(centre: Array, patch: PatchEstimate, bed: SimulatedBed) -> pd.DataFrame:
    """Return a row for each band of a patch, and what is the same in all of them."""
    impedance, own_force = patch.impedance, patch.own_force
    return pd.DataFrame(
        {
            "patch": bed.patch,
            "band_hz": centre,
            "frequency_hz": impedance.frequency,
            "equivalent_damping_n_s_m3": impedance.value.real,
            "equivalent_damping_error_n_s_m3": patch.equivalent_damping_error,
            "apparent_mass_kg_m2": impedance.apparent_mass,
            "apparent_mass_error_kg_m2": patch.apparent_mass_error,
            "own_force_psd_pa2_hz": own_force.psd,
            "own_force_coherence": own_force.coherence,
            "own_force_error": patch.own_force_error,
            "own_force_length_m_hz": own_force.length,
            "cell_area_m2": bed.cell_area,
            "common_error": patch.common_error,
            "particle_mass_per_area_kg_m2": bed.mass_per_area,
            "youngs_modulus_mpa": bed.modulus / 1e6,
        }
    )


def write_tables(
    path: Path, tables: Mapping[str, pd.DataFrame], attributes: Mapping[str, str]
) -> None:
    """Write tables to a ``.nc`` file: a dimension each, and a variable for each column."""
    variables = {
        f"{name}.{column}": (name, values.to_numpy())
        for name, table in tables.items()
        for column, values in table.items()
    }
    with durable.replacing(path) as draft:
        xr.Dataset(variables, attrs=dict(attributes)).to_netcdf(draft, engine="scipy")


def read_tables(path: Path) -> dict[str, pd.DataFrame]:
    """Read what `write_tables` wrote."""
    tables: dict[str, dict[str, Any]] = {}
    for variable, values in xr.load_dataset(path, engine="scipy").data_vars.items():
        name, _, column = str(variable).partition(".")
        tables.setdefault(name, {})[column] = values.to_numpy()
    return {name: pd.DataFrame(columns) for name, columns in tables.items()}
