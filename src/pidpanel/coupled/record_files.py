"""File of a record of panel and particles: NetCDF."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.coupled.results import SettledRecord


def write_record(
    path: Path, record: SettledRecord, attributes: Mapping[str, str | float | list[float]]
) -> None:
    """Write a record with its sound.

    Parameters
    ----------
    path
        The ``.nc`` file.
    record
        The modal forces are written in single precision.
    attributes
        Global attributes of the file.
    """
    amplitude = record.amplitude.astype(np.complex64)
    xr.Dataset(
        {
            "frequency": (("tone",), record.frequency, {"units": "Hz"}),
            "modal_force_real": (("tone", "shape"), amplitude.real, {"units": "N"}),
            "modal_force_imag": (("tone", "shape"), amplitude.imag, {"units": "N"}),
            "displacement_at_stations": (("row", "station"), record.at_stations, {"units": "m"}),
            "displacement_at_points": (("row", "point"), record.at_points, {"units": "m"}),
            "impulse": (
                ("row", "station"),
                record.impulse,
                {"units": "N s/m2", "long_name": "of the walls on the particles, per area"},
            ),
        },
        attrs={
            **attributes,
            "interval_s": record.interval,
            "first_tone": record.first,
            "settled_row": record.settled,
        },
    ).to_netcdf(path, engine="scipy")


def read_masses(path: Path) -> Array:
    """Return what the particles of each patch weigh [kg/m²], as the file of a record says."""
    with xr.open_dataset(path, engine="scipy") as dataset:
        return np.atleast_1d(np.asarray(dataset.attrs["mass_per_area_kg_m2"], dtype=np.float64))


def read_record(path: Path) -> SettledRecord:
    """Read what `write_record` wrote."""
    with xr.open_dataset(path, engine="scipy") as dataset:
        data = dataset.load()
    real, imaginary = (data[f"modal_force_{part}"].to_numpy() for part in ("real", "imag"))
    stations, points, impulse = (
        data[name].to_numpy().astype(np.float64)
        for name in ("displacement_at_stations", "displacement_at_points", "impulse")
    )
    return SettledRecord(
        frequency=data["frequency"].to_numpy().astype(np.float64),
        amplitude=real.astype(np.float64) + 1j * imaginary.astype(np.float64),
        first=int(data.attrs["first_tone"]),
        rows=len(stations),
        settled=int(data.attrs["settled_row"]),
        interval=float(data.attrs["interval_s"]),
        at_stations=stations,
        at_points=points,
        impulse=impulse,
    )
