"""The file of a modal force table."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.sound.field import ModalForceTable


def write_modal_force(path: Path, table: ModalForceTable, attributes: Mapping[str, str]) -> None:
    """Write a table to NetCDF.

    Parameters
    ----------
    path
        The ``.nc`` file.
    table
        The table.
    attributes
        Global attributes of the file.
    """
    xr.Dataset(
        {
            "modal_force": (
                ("wavenumber", "shape", "other_shape"),
                table.modal_force,
                {"units": "m4", "long_name": "modal force per pressure PSD, G"},
            )
        },
        coords={
            "wavenumber": (
                "wavenumber",
                table.wavenumber,
                {"units": "rad m-1", "long_name": "acoustic wavenumber, Chebyshev nodes"},
            )
        },
        attrs={**attributes, "wavenumber_max_rad_m": table.wavenumber_max},
    ).to_netcdf(path, engine="scipy")


def read_modal_force(path: Path) -> ModalForceTable:
    """Read a table that `write_modal_force` wrote."""
    with xr.open_dataset(path, engine="scipy") as dataset:
        return ModalForceTable(
            float(dataset.attrs["wavenumber_max_rad_m"]),
            dataset["wavenumber"].to_numpy().astype(np.float64),
            dataset["modal_force"].to_numpy().astype(np.float64),
        )
