"""File of a record of panel and particles: NetCDF."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.arrays import variable
from pidpanel.coupled.checkpoints import identity_of
from pidpanel.coupled.segments import SettledRecord
from pidpanel.provenance import durable

# Attributes with the hash of all that a record depends on, and of what it holds.
IDENTITY, CONTENT = "identity", "content"
NUMBERS = ("interval_s", "first_tone", "settled_row")  # attributes that go with the arrays


def write_record(
    path: Path, record: SettledRecord, attributes: Mapping[str, str | float | list[float]]
) -> None:
    """Write a record with its sound in single precision, which rounds to 1e-7 of the largest."""
    single = np.float32
    real, imaginary = record.amplitude.real.astype(single), record.amplitude.imag.astype(single)
    at_cells, at_points = record.at_cells.astype(single), record.at_points.astype(single)
    meaning = "of the walls on the particles, per area"
    dataset = xr.Dataset(
        {
            "frequency": variable("tone", record.frequency, "Hz"),
            "modal_force_real": variable("tone shape", real, "N"),
            "modal_force_imag": variable("tone shape", imaginary, "N"),
            "displacement_at_cells": variable("row cell", at_cells, "m"),
            "displacement_at_points": variable("row point", at_points, "m"),
            "impulse": variable("row cell", record.impulse, "N s/m2", meaning),
        },
        attrs=dict(attributes),
    )
    settings = (record.interval, record.first, record.settled)
    dataset.attrs |= dict(zip(NUMBERS, settings, strict=True))
    dataset.attrs[CONTENT] = _content(dataset)
    with durable.replacing(path) as draft:
        dataset.to_netcdf(draft, engine="scipy")


def read_record(path: Path, identity: str) -> SettledRecord | None:
    """Read the record of a run; None without one, of another run, or with a changed byte."""
    try:
        data = xr.load_dataset(path, engine="scipy")
        if data.attrs[IDENTITY] != identity or data.attrs[CONTENT] != _content(data):
            return None
        values = {name: data[name].to_numpy().astype(np.float64) for name in data.data_vars}
        interval, first, settled = (data.attrs[name] for name in NUMBERS)
        return SettledRecord(
            frequency=values["frequency"],
            amplitude=values["modal_force_real"] + 1j * values["modal_force_imag"],
            first=int(first),
            rows=len(values["impulse"]),
            settled=int(settled),
            interval=float(interval),
            at_cells=values["displacement_at_cells"],
            at_points=values["displacement_at_points"],
            impulse=values["impulse"],
        )
    except (OSError, ValueError, TypeError, KeyError, IndexError):
        return None


def _content(dataset: xr.Dataset) -> str:
    """Return a hash of all arrays and of the numbers that go with them."""
    names = sorted(str(name) for name in dataset.variables)
    numbers = [float(dataset.attrs[name]) for name in NUMBERS]
    # in the byte order of the machine: the file has its own
    arrays = [np.asarray(dataset[name].to_numpy()) for name in names]
    native = [array.astype(array.dtype.newbyteorder("=")) for array in arrays]
    return identity_of(*names, *native, *numbers)
