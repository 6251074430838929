"""File of the assembled plate: NetCDF with its sparse matrices and the shapes of its basis.

The response compares its reduced basis with all elements; for that it needs the elements.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.panel.plate import AssembledPlate

SYMMETRIC = ("stiffness", "mass")  # matrices of which the upper triangle is stored


@dataclass(frozen=True)
class StoredPlate:
    """What `AssembledPlate` has in arrays, with the shapes of the panel's basis."""

    # As of `AssembledPlate`
    stiffness: sp.csr_array
    mass: sp.csr_array
    patch_overlap: dict[str, sp.csr_array]
    at_vertices: sp.csr_array
    curvature_at_vertices: tuple[sp.csr_array, ...]
    shear_at_vertices: tuple[sp.csr_array, ...]
    quadrature_position: Array
    quadrature_weight: Array
    at_quadrature: sp.csr_array
    inertia: Array
    shapes: Array  # (n_free, n) of the basis, in its order and size, in single precision
    # (n_patches, n_quadrature) weights over patches that elements do not follow [m²]; None where a
    # patch is whole elements
    patch_weight: sp.csr_array | None = None


def write_plate(
    path: Path, plate: AssembledPlate, shapes: Array, attributes: Mapping[str, str]
) -> None:
    """Write the matrices of a plate and the shapes of its basis."""
    variables: dict[str, Any] = {
        "quadrature_position": (("quadrature", "axis"), plate.quadrature_position, {"units": "m"}),
        "quadrature_weight": (("quadrature",), plate.quadrature_weight, {"units": "m2"}),
        "inertia": (("coordinate",), plate.inertia, {"units": "kg"}),
        "shapes": (
            ("coordinate", "shape"),
            shapes.astype(np.float32),
            {"units": "1", "long_name": "shapes of the basis in the free coordinates"},
        ),
    }
    for name, matrix in _matrices(plate):
        stored = sp.csr_array(sp.triu(matrix)) if name in SYMMETRIC else matrix
        variables |= _as_variables(name, stored)
    dataset = xr.Dataset(variables, attrs={**attributes, "patches": "\n".join(plate.patch_overlap)})
    dataset.to_netcdf(path, engine="scipy")


def read_plate(path: Path) -> StoredPlate:
    """Read what `write_plate` wrote.

    Raises
    ------
    ValueError
        If the file is of something else.
    """
    with xr.open_dataset(path, engine="scipy") as dataset:
        if "stiffness_data" not in dataset:
            raise ValueError(f"{path}: not the matrices of a plate")
        data = dataset.load()

    def matrix(name: str) -> sp.csr_array:
        upper = sp.csr_array(
            (
                data[f"{name}_data"].to_numpy().astype(np.float64),
                data[f"{name}_column"].to_numpy().astype(np.int32),
                data[f"{name}_row_start"].to_numpy().astype(np.int32),
            ),
            shape=tuple(data[f"{name}_data"].attrs["shape"]),
        )
        if name in SYMMETRIC:
            return sp.csr_array(upper + sp.triu(upper, 1).T)
        return upper

    names = [name for name in str(data.attrs["patches"]).split("\n") if name]
    return StoredPlate(
        stiffness=matrix("stiffness"),
        mass=matrix("mass"),
        patch_overlap={name: matrix(f"patch_{k}") for k, name in enumerate(names)},
        at_vertices=matrix("at_vertices"),
        curvature_at_vertices=tuple(matrix(f"curvature_{k}") for k in range(3)),
        shear_at_vertices=tuple(matrix(f"shear_{k}") for k in range(2)),
        quadrature_position=data["quadrature_position"].to_numpy().astype(np.float64),
        quadrature_weight=data["quadrature_weight"].to_numpy().astype(np.float64),
        at_quadrature=matrix("at_quadrature"),
        inertia=data["inertia"].to_numpy().astype(np.float64),
        shapes=data["shapes"].to_numpy().astype(np.float32),
    )


def _matrices(plate: AssembledPlate) -> Iterator[tuple[str, sp.csr_array]]:
    yield "stiffness", plate.stiffness
    yield "mass", plate.mass
    for k, overlap in enumerate(plate.patch_overlap.values()):
        yield f"patch_{k}", overlap
    yield "at_vertices", plate.at_vertices
    for k, matrix in enumerate(plate.curvature_at_vertices):
        yield f"curvature_{k}", matrix
    for k, matrix in enumerate(plate.shear_at_vertices):
        yield f"shear_{k}", matrix
    yield "at_quadrature", plate.at_quadrature


def _as_variables(name: str, matrix: sp.csr_array) -> dict[str, Any]:
    """Compressed rows; an empty array has one entry that counts nothing, NetCDF 3 has no less."""
    entries = f"{name}_entry"
    return {
        f"{name}_data": ((entries,), matrix.data, {"shape": np.array(matrix.shape, np.int32)}),
        f"{name}_column": ((entries,), matrix.indices.astype(np.int32)),
        f"{name}_row_start": ((f"{name}_row",), matrix.indptr.astype(np.int32)),
    }
