"""Files of the panel's basis: NetCDF for later stages, VTU for viewing."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import xarray as xr

from pidpanel.arrays import described_variables, variable
from pidpanel.panel.basis import PanelBasis

VARIABLES = described_variables(Path(__file__).with_name("variables.csv"))
# In single precision: errors of 6e-8 of each value are 1e-9 of an integral over the panel.
SINGLE = {"shape_at_quadrature", "shape_at_vertices"}
# Only for viewing: 16 bits, scaled to the largest value of each shape
PACKED = {"curvature_at_vertices", "shear_at_vertices"}
FULL = 2**15 - 1
# NetCDF 3 holds big-endian numbers and 32-bit integers: the types to compute with, by kind
NATIVE = {"f": np.float64, "i": np.int64, "b": np.bool_}


def write_basis(path: Path, basis: PanelBasis, attributes: Mapping[str, str]) -> None:
    """Write a basis to a NetCDF file (real arrays, each with ``units`` and ``long_name``).

    Curvature and shear at the vertices are multiples of a step of each shape, `PACKED`.
    """
    variables = {}
    for name, (dimensions, unit, long_name) in VARIABLES.items():
        value = getattr(basis, name)
        if isinstance(value, tuple):
            value = np.array(value, dtype=object)
        if name in SINGLE:
            value = np.asarray(value, dtype=np.float32)
        if name in PACKED:
            largest = np.abs(value).max(axis=(0, 1), initial=0.0)
            step = np.where(largest > 0, largest, 1.0) / FULL
            value = np.round(value / step).astype(np.int16)
            variables[f"{name}_step"] = variable("shape", step, unit, f"unit of {name}")
            unit = f"{name}_step"
        variables[name] = variable(dimensions, value, unit, long_name)
    xr.Dataset(variables, attrs=dict(attributes)).to_netcdf(path, engine="scipy")


def read_basis(path: Path) -> PanelBasis:
    """Read a basis that `write_basis` wrote.

    Raises
    ------
    ValueError
        If the file lacks a variable.
    """
    with xr.open_dataset(path, engine="scipy") as dataset:
        missing = [name for name in VARIABLES if name not in dataset]
        if missing:
            raise ValueError(f"{path}: not the basis of a panel: {missing} missing")
        values: dict[str, Any] = {}
        for name in VARIABLES:
            value = dataset[name].to_numpy()
            if name.endswith("_names"):
                values[name] = tuple(str(entry) for entry in value)
            elif name in PACKED:
                values[name] = value * dataset[f"{name}_step"].to_numpy().astype(np.float64)
            elif value.ndim == 0:
                values[name] = float(value)
            else:
                values[name] = value.astype(NATIVE[value.dtype.kind])
    return PanelBasis(**values)


def write_shapes(path: Path, basis: PanelBasis) -> None:
    """Write the shapes at the vertices to a VTU file, one array per shape.

    The arrays are named by number from 1 and frequency, such as ``mode_001_64.90_hz``.
    """
    shapes = {}
    for i, frequency in enumerate(basis.natural_frequency):
        kind = "residual" if basis.is_residual[i] else "mode"
        shapes[f"{kind}_{i + 1:03d}_{frequency:.2f}_hz"] = basis.shape_at_vertices[:, i]
    position = np.pad(basis.vertex_position, ((0, 0), (0, 1)))
    kind = {4: "quad", 3: "triangle"}[basis.cells.shape[1]]
    meshio.Mesh(position, [(kind, basis.cells)], point_data=shapes).write(path)
