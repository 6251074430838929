"""File of a record of panel and particles: NetCDF."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.coupled.checkpoints import identity_of
from pidpanel.coupled.segments import SettledRecord
from pidpanel.provenance import durable

# Attributes with the hash of all that a record depends on, and of what it holds.
IDENTITY, CONTENT = "identity", "content"


def write_record(
    path: Path, record: SettledRecord, attributes: Mapping[str, str | float | list[float]]
) -> None:
    """Write a record with its sound in single precision, which rounds to 1e-7 of the largest."""
    single = np.float32
    amplitude = record.amplitude
    dataset = xr.Dataset(
        {
            "frequency": (("tone",), record.frequency, {"units": "Hz"}),
            "modal_force_real": (("tone", "shape"), amplitude.real.astype(single), {"units": "N"}),
            "modal_force_imag": (("tone", "shape"), amplitude.imag.astype(single), {"units": "N"}),
            "displacement_at_cells": (
                ("row", "cell"),
                record.at_cells.astype(single),
                {"units": "m"},
            ),
            "displacement_at_points": (
                ("row", "point"),
                record.at_points.astype(single),
                {"units": "m"},
            ),
            "impulse": (
                ("row", "cell"),
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
    )
    dataset.attrs[CONTENT] = _content(dataset)
    with durable.replacing(path) as draft:
        dataset.to_netcdf(draft, engine="scipy")


def read_record(path: Path, identity: str) -> SettledRecord | None:
    """Read the record of a run; None without one, of another run, or with a changed byte."""
    try:
        data = xr.load_dataset(path, engine="scipy")
        if data.attrs[IDENTITY] != identity or data.attrs[CONTENT] != _content(data):
            return None
        real, imaginary = (data[f"modal_force_{part}"].to_numpy() for part in ("real", "imag"))
        cells, points, impulse = (
            data[name].to_numpy().astype(np.float64)
            for name in ("displacement_at_cells", "displacement_at_points", "impulse")
        )
        return SettledRecord(
            frequency=data["frequency"].to_numpy().astype(np.float64),
            amplitude=real.astype(np.float64) + 1j * imaginary.astype(np.float64),
            first=int(data.attrs["first_tone"]),
            rows=len(cells),
            settled=int(data.attrs["settled_row"]),
            interval=float(data.attrs["interval_s"]),
            at_cells=cells,
            at_points=points,
            impulse=impulse,
        )
    except (OSError, ValueError, TypeError, KeyError, IndexError):
        return None


def _content(dataset: xr.Dataset) -> str:
    """Return a hash of all arrays and of the numbers that go with them."""
    names = sorted(str(name) for name in dataset.variables)
    numbers = [float(dataset.attrs[name]) for name in ("interval_s", "first_tone", "settled_row")]
    # in the byte order of the machine: the file has its own
    arrays = [np.asarray(dataset[name].to_numpy()) for name in names]
    native = [array.astype(array.dtype.newbyteorder("=")) for array in arrays]
    return identity_of(*names, *native, *numbers)
