"""File of the assembled plate: NetCDF with its sparse matrices and the shapes of its basis.

The response compares its reduced basis with all elements; for that it needs the elements.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import xarray as xr

from pidpanel.arrays import variable
from pidpanel.panel.matrices import StoredPlate

SYMMETRIC = ("stiffness", "mass")  # matrices stored by their upper triangle


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
    for name in ("at_vertices", "at_quadrature"):
        variables |= _as_variables(name, getattr(plate, name))
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
    return StoredPlate(
        stiffness=matrix("stiffness"),
        mass=matrix("mass"),
        patch_overlap={name: matrix(f"patch_{k}") for k, name in enumerate(names)},
        at_vertices=matrix("at_vertices"),
        curvature_at_vertices=tuple(matrix(f"curvature_{k}") for k in range(3)),
        shear_at_vertices=(matrix("shear_0"), matrix("shear_1")),
        reactions=(matrix("reaction_0"), matrix("reaction_1")),
        quadrature_position=array("quadrature_position"),
        quadrature_weight=array("quadrature_weight"),
        at_quadrature=matrix("at_quadrature"),
        inertia=array("inertia"),
        shapes=array("shapes", np.float32),
    )


def _as_variables(name: str, matrix: sp.csr_array) -> dict[str, Any]:
    """Return compressed rows; an empty array has one unused entry, as NetCDF 3 needs one."""
    entries = f"{name}_entry"
    return {
        f"{name}_data": ((entries,), matrix.data, {"shape": np.array(matrix.shape, np.int32)}),
        f"{name}_column": ((entries,), matrix.indices.astype(np.int32)),
        f"{name}_row_start": ((f"{name}_row",), matrix.indptr.astype(np.int32)),
    }
