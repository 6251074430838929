"""The surface as ``damping/surface.nc``, its data, and a table for inspection."""

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import variable
from pidpanel.damping.models import DampingError
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import (
    CASE_COLUMNS,
    PARTICLE_MASS,
    Constants,
    SurfaceBed,
    training_data,
)

# Columns of the cases that are stored
UNITS = ("1", "Hz", "g", "N s m-3", "N s m-3", "kg m-2", "kg m-2")
CASE_UNITS = dict(zip(CASE_COLUMNS, UNITS, strict=True))


def to_dataset(surface: DampingSurface) -> xr.Dataset:
    """Return what the surface is made of: its cases and constants."""
    variables = {
        f"case_{name}": variable("case", surface.cases[name].to_numpy(float), unit)
        for name, unit in CASE_UNITS.items()
    }
    meaning = "lengths of r, ln Γ and ln W/L, size and scatter of the process of beds"
    for name, processes in (("damping", surface.damping), ("mass", surface.mass)):
        for side, process in {} if processes is None else vars(processes).items():
            if process is not None:
                constants = variable("constant", process.constants, "1", f"{meaning} {side}")
                variables[f"{name}_{side}"] = constants
    attributes = {
        "onset_g": surface.onset_g,
        "mass_per_fill_kg_m2": surface.bed.mass_per_fill,
        "depth_m": surface.bed.depth,
    }
    return xr.Dataset(variables, attrs=attributes)


def from_dataset(dataset: xr.Dataset) -> DampingSurface:
    """Return the inverse of `to_dataset`."""
    cases = pd.DataFrame({name: dataset[f"case_{name}"].to_numpy() for name in CASE_UNITS})
    attrs = ("onset_g", "mass_per_fill_kg_m2", "depth_m")
    try:
        bed = SurfaceBed(*(float(dataset.attrs[name]) for name in attrs))
        data = training_data(cases, bed)
        damping = data.damping_sides(_constants(dataset, "damping"))
    except KeyError as error:
        raise DampingError(f"{error} is missing: not a surface of this version") from error
    mass = data.mass_sides(_constants(dataset, "mass")) if "mass_riding" in dataset else None
    return DampingSurface(cases, bed, damping, mass, data.jump())


def _constants(dataset: xr.Dataset, name: str) -> Constants:
    crossing = f"{name}_crossing"
    return (
        dataset[f"{name}_riding"].to_numpy(),
        dataset[crossing].to_numpy() if crossing in dataset else None,
    )


def to_frame(surface: DampingSurface) -> pd.DataFrame:
    """Return the surface on equally spaced r, ln f and ln Γ within its domain, as a table."""
    axes = (
        np.unique(np.linspace(surface.low[0], surface.high[0], 5)),
        np.unique(np.geomspace(surface.low[1], surface.high[1], 9)),
        np.unique(np.geomspace(surface.low[2], surface.high[2], 7)),
    )
    points = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)
    points = points[surface.simulated.contains(points)]
    values = surface.evaluate(*points.T)
    results = values.equivalent_damping, values.equivalent_damping_error, values.apparent_mass
    frame = pd.DataFrame(np.column_stack([points, *results]), columns=CASE_COLUMNS[:-1])
    if np.isfinite(surface.bed.mass_per_fill):
        frame[PARTICLE_MASS] = surface.bed.mass_per_fill * frame["fill_fraction"]
    return frame
