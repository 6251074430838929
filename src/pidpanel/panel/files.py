"""Files of the panel's basis and its plate: NetCDF for later stages, VTU for viewing.

The response compares its reduced basis with all elements: for that it needs the sparse matrices of
the assembled plate and the shapes of its basis.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import xarray as xr

from pidpanel.arrays import Array, Index, described_variables, variable
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate, Stretching
from pidpanel.provenance.results import read_netcdf

VARIABLES = described_variables(Path(__file__).with_name("variables.csv"))
OPTIONAL = {"quadrature_normal", "frequency_shift", "tangential_share"}  # of structures
# In single precision: errors of 6e-8 of each value are 1e-9 of an integral over the panel.
SINGLE = {"shape_at_quadrature", "shape_at_vertices"}
# Only for viewing: 16 bits, scaled to the largest value of each shape
PACKED = {"curvature_at_vertices", "shear_at_vertices"}
FULL = 2**15 - 1
# NetCDF 3 holds big-endian numbers and 32-bit integers: the types to compute with, by kind
NATIVE = {"f": np.float64, "i": np.int64, "b": np.bool_}
# Arrays of a plate that only structures have, with dimensions and unit
OF_STRUCTURE = {
    "quadrature_normal": ("quadrature space", "1"),
    "vertex_normal": ("vertex space", "1"),
    "participation": ("coordinate space", "kg"),
    "patch_translation": ("patch bordered_coordinate space", "m2"),
    "point_direction": ("point space", "1"),
}
SYMMETRIC = ("stiffness", "mass")  # matrices stored by their upper triangle


def write_basis(path: Path, basis: PanelBasis, attributes: Mapping[str, str]) -> None:
    """Write a basis to a NetCDF file (real arrays, each with ``units`` and ``long_name``).

    Curvature and shear at the vertices are multiples of a step of each shape, `PACKED`.
    """
    variables = {}
    for name, (dimensions, unit, long_name) in VARIABLES.items():
        value = getattr(basis, name)
        if value is None:
            continue
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
    ResultsDamaged
        If the file lacks a variable or cannot be read.
    """
    required = VARIABLES.keys() - OPTIONAL
    dataset = read_netcdf(path, [*required, *(f"{name}_step" for name in PACKED)])
    values: dict[str, Any] = {}
    for name in [name for name in VARIABLES if name in dataset]:
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
    write_vtu(path, basis.vertex_position, basis.cells, shapes)


def write_vtu(path: Path, position: Array, cells: Index, data: Mapping[str, Array]) -> None:
    """Write values at vertices, by name, to a VTU file."""
    import meshio  # slow to import, for files alone

    kind = {4: "quad", 3: "triangle"}[cells.shape[1]]
    meshio.Mesh(in_space(position), [(kind, cells)], point_data=dict(data)).write(path)


def in_space(position: Array) -> Array:
    """Return positions (n, 3), with z = 0 of those in a plane."""
    return np.pad(position, ((0, 0), (0, 3 - position.shape[1])))


def write_plate(path: Path, plate: StoredPlate, attributes: Mapping[str, str]) -> None:
    """Write the matrices of a plate and the shapes of its basis."""
    long_name = "shapes of the basis in the free coordinates"
    variables: dict[str, Any] = {
        "quadrature_position": variable("quadrature axis", plate.quadrature_position, "m"),
        "quadrature_weight": variable("quadrature", plate.quadrature_weight, "m2"),
        "inertia": variable("coordinate", plate.inertia, "kg"),
        "shapes": variable("coordinate shape", plate.shapes.astype(np.float32), "1", long_name),
    }
    for name in SYMMETRIC:
        variables |= _as_variables(name, sp.csr_array(sp.triu(getattr(plate, name))))
    for kind, matrices in (
        ("patch", plate.patch_overlap.values()),
        ("curvature", plate.curvature_at_vertices),
        ("shear", plate.shear_at_vertices),
        ("reaction", plate.reactions),
    ):
        for k, matrix in enumerate(matrices):
            variables |= _as_variables(f"{kind}_{k}", matrix)
    for name in ("at_vertices", "at_points", "point_weight", "at_quadrature"):
        variables |= _as_variables(name, getattr(plate, name))
    for name, (dimensions, unit) in OF_STRUCTURE.items():
        if (value := getattr(plate, name)) is not None:
            variables[name] = variable(dimensions, value, unit)
    if plate.stretching is not None:
        axes, name = "mode mode_2 mode_3 mode_4", "membrane energy of the lowest modes"
        variables["stretching"] = variable(axes, plate.stretching.tensor, "N m-3", name)
        modes = plate.stretching.modes.astype(np.int32)
        variables["stretched_mode"] = variable("mode", modes, "1", "number of the mode")
    dataset = xr.Dataset(variables, attrs={**attributes, "patches": "\n".join(plate.patch_overlap)})
    dataset.to_netcdf(path, engine="scipy")


def read_plate(path: Path) -> StoredPlate:
    """Read what `write_plate` wrote.

    Raises
    ------
    ResultsDamaged
        If the file is of something else.
    """
    data = read_netcdf(path, ["stiffness_data"])

    def array(name: str, kind: type = np.float64) -> Any:
        return data[name].to_numpy().astype(kind)

    def matrix(name: str) -> sp.csr_array:
        rows = array(f"{name}_column", np.int32), array(f"{name}_row_start", np.int32)
        shape = tuple(data[f"{name}_data"].attrs["shape"])
        upper = sp.csr_array((array(f"{name}_data"), *rows), shape=shape)
        if name in SYMMETRIC:
            return sp.csr_array(upper + sp.triu(upper, 1).T)
        return upper

    names = [name for name in str(data.attrs["patches"]).split("\n") if name]
    curvature = [f"curvature_{k}" for k in range(6) if f"curvature_{k}_data" in data]
    return StoredPlate(
        stiffness=matrix("stiffness"),
        mass=matrix("mass"),
        patch_overlap={name: matrix(f"patch_{k}") for k, name in enumerate(names)},
        at_vertices=matrix("at_vertices"),
        at_points=matrix("at_points"),
        point_weight=matrix("point_weight"),
        curvature_at_vertices=tuple(map(matrix, curvature)),
        shear_at_vertices=(matrix("shear_0"), matrix("shear_1")),
        reactions=(matrix("reaction_0"), matrix("reaction_1")),
        quadrature_position=array("quadrature_position"),
        quadrature_weight=array("quadrature_weight"),
        at_quadrature=matrix("at_quadrature"),
        inertia=array("inertia"),
        **{name: array(name) for name in OF_STRUCTURE if name in data},
        shapes=array("shapes", np.float32),
        stretching=Stretching(array("stretched_mode", np.int64), array("stretching"))
        if "stretching" in data
        else None,
    )


def _as_variables(name: str, matrix: sp.csr_array) -> dict[str, Any]:
    """Return compressed rows; an empty array has one unused entry, as NetCDF 3 needs one."""
    entries = f"{name}_entry"
    return {
        f"{name}_data": ((entries,), matrix.data, {"shape": np.array(matrix.shape, np.int32)}),
        f"{name}_column": ((entries,), matrix.indices.astype(np.int32)),
        f"{name}_row_start": ((f"{name}_row",), matrix.indptr.astype(np.int32)),
    }
