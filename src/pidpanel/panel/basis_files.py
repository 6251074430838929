"""Files of the panel's basis: NetCDF for the stages that follow, VTU to look at."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import xarray as xr

from pidpanel.arrays import variable
from pidpanel.panel.basis import PanelBasis

# variable: dimensions, unit, long name
VARIABLES: dict[str, tuple[str, str, str]] = {
    "natural_frequency": ("shape", "Hz", "natural frequency of each shape"),
    "modal_mass": ("shape", "kg", "modal mass of each shape"),
    "is_residual": ("shape", "1", "whether the shape is a residual vector, not a mode"),
    "shape_at_points": ("point shape", "1", "deflection at the response points"),
    "patch_overlap": ("patch shape other_shape", "m2",
                      "integral over the patch of the product of two shapes"),
    "quadrature_position": ("quadrature axis", "m", "positions of the load quadrature"),
    "quadrature_weight": ("quadrature", "m2", "weights of the load quadrature"),
    "shape_at_quadrature": ("quadrature shape", "1", "deflection at the load quadrature"),
    "quadrature_wavenumber": ("", "rad m-1", "wavenumber that the load quadrature serves"),
    "face_overlap": ("shape other_shape", "m2",
                     "integral over the face of the product of two shapes"),
    "vertex_position": ("vertex axis", "m", "vertices of the mesh"),
    "cells": ("cell corner", "1", "vertex numbers of each cell, from 0"),
    "shape_at_vertices": ("vertex shape", "1", "deflection at the vertices"),
    "curvature_at_vertices": ("vertex curvature shape", "m-1",
                              "curvature (xx, yy, xy) of the shapes at the vertices"),
    "shear_at_vertices": ("vertex shear shape", "m-1",
                          "shear angle (xz, yz) of the shapes at the vertices"),
    "curvature_at_points": ("point curvature shape", "m-1",
                            "curvature of the shapes at the response points"),
    "shear_at_points": ("point shear shape", "m-1",
                        "shear angle of the shapes at the response points"),
    "reactions": ("power held shape", "J0.5 m-1",
                  "reactions of what stands at single points, per power of omega squared"),
    "layer_names": ("layer", "1", "names of the layers of the section"),
    "layer_strain": ("layer strain curvature", "m", "strain of a layer per curvature"),
    "layer_stress": ("layer strain curvature", "Pa m", "stress of a layer per curvature"),
    "core_stress": ("core shear", "Pa", "shear stress of the core per shear angle"),
    "point_position": ("point axis", "m", "positions of the response points"),
    "cell_in_patch": ("patch cell", "1", "whether a cell belongs to a patch"),
    "point_names": ("point", "1", "names of the response points"),
    "patch_names": ("patch", "1", "names of the damper patches"),
}  # fmt: skip
# Of single precision: the 6e-8 by which each value errs are 1e-9 of an integral over the panel.
SINGLE = {"shape_at_quadrature", "shape_at_vertices"}
# Only looked at: 16 bits, of which the largest value of each shape takes all
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
