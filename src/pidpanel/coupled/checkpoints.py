"""Checkpoints, from which a run resumes with identical results, and the files of records.

A run is integrated in pieces. Each has its own process and starts from the files of the piece
before: the state of the panel, and for every patch a restart of LIGGGHTS and the forces on its
spheres. A run that was never stopped does the same. Files of another run, or with a changed byte,
are ignored, and the run starts from the beginning.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, variable
from pidpanel.coupled.integration import Rows, State
from pidpanel.coupled.segments import SettledRecord
from pidpanel.coupon.records import check_files, files_of
from pidpanel.provenance import durable
from pidpanel.provenance.results import damage_named, read_netcdf

FILE = "state.npz"  # rows so far, the state, and the restarts that belong to it with their hashes


def identity_of(*parts: Array | str | float) -> str:
    """Return a hash of all that a run depends on, to the bit.

    Examples
    --------
    >>> identity_of("deck", 1.0) == identity_of("deck", 1.0)
    True
    >>> identity_of(np.zeros(2)) == identity_of(np.zeros((2, 1)))
    False
    """
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(f"{part.shape}{part.dtype}".encode() + b"\0")
            digest.update(np.ascontiguousarray(part).tobytes())
        else:
            digest.update(repr(part).encode() + b"\0")
    return digest.hexdigest()


@dataclass(frozen=True)
class Checkpoint:
    """A run up to a row."""

    rows: tuple[Rows, ...]
    state: State
    restarts: tuple[Path, ...] = ()
    # (n, 6) forces and torques on the spheres of each patch [N], [N m]
    forces: tuple[Array, ...] = ()

    def write(self, folder: Path, identity: str) -> None:
        """Write the file of a checkpoint whose restarts are there, and remove older ones."""
        durable.sync(*self.restarts)
        rows = Rows.joined(self.rows)
        values = {
            **{f"rows_{name}": value for name, value in rows._asdict().items()},
            **{f"state_{name}": value for name, value in self.state._asdict().items()},
            **{f"forces_{k}": force for k, force in enumerate(self.forces)},
        }
        files = files_of(folder, [path.name for path in self.restarts])
        with durable.replacing(folder / FILE) as draft, draft.open("wb") as file:
            hashes = list(files.values())
            np.savez(file, identity=identity, restarts=list(files), hashes=hashes, **values)
        for path in set(folder.glob("*.restart")) - set(self.restarts):
            path.unlink()

    @staticmethod
    def read(folder: Path, identity: str) -> Checkpoint | None:
        """Read what was written of this run; None if there is nothing, or it is damaged."""
        if not (folder / FILE).exists():
            return None
        try:
            with (folder / FILE).open("rb") as stored, np.load(stored) as file:
                values = dict(file)
            if str(values["identity"]) != identity:
                return None
            restarts, hashes = values["restarts"].tolist(), values["hashes"].tolist()
            check_files(folder, dict(zip(restarts, hashes, strict=True)))
            state = State(*(values[f"state_{name}"] for name in State._fields))
            return Checkpoint(
                (Rows(*(values[f"rows_{name}"] for name in Rows._fields)),),
                state._replace(row=int(state.row)),
                tuple(folder / name for name in restarts),
                tuple(values[f"forces_{k}"] for k in range(len(restarts))),
            )
        except Exception as error:  # a flipped bit gives zip, zlib, numpy and others reasons
            print(f"{folder}: damaged ({error}); restarted from the beginning", file=sys.stderr)
            return None


def ends_of_pieces(first: int, rows: int, rows_of_piece: int) -> Sequence[int]:
    """Return the rows at which the pieces from a row on end; each piece ends where it always does.

    Examples
    --------
    >>> ends_of_pieces(0, 25, 10), ends_of_pieces(20, 25, 10), ends_of_pieces(25, 25, 10)
    ([10, 20, 25], [25], [])
    """
    return [*range(first + rows_of_piece, rows, rows_of_piece), rows] if first < rows else []


IDENTITY = "identity"  # attribute with the hash of all that a record depends on
NUMBERS = ("interval_s", "first_tone", "settled_row")  # attributes that go with the arrays


def write_record(
    path: Path, record: SettledRecord, attributes: Mapping[str, str | float | list[float]]
) -> None:
    """Write a record with its sound in single precision, which rounds to 1e-7 of the largest."""
    single = np.float32
    real, imaginary = record.amplitude.real.astype(single), record.amplitude.imag.astype(single)
    at_cells, at_points = record.at_cells.astype(single), record.at_points.astype(single)
    meaning = "of the walls on the particles, per area"
    settings = (record.interval, record.first, record.settled)
    dataset = xr.Dataset(
        {
            "frequency": variable("tone", record.frequency, "Hz"),
            "modal_force_real": variable("tone shape", real, "N"),
            "modal_force_imag": variable("tone shape", imaginary, "N"),
            "displacement_at_cells": variable("row cell", at_cells, "m"),
            "displacement_at_points": variable("row point", at_points, "m"),
            "impulse": variable("row cell", record.impulse, "N s/m2", meaning),
        },
        attrs={**attributes, **dict(zip(NUMBERS, settings, strict=True))},
    )
    with durable.replacing(path) as draft:
        dataset.to_netcdf(draft, engine="scipy")


def read_record(path: Path, identity: str) -> SettledRecord | None:
    """Read the record of a run; None without one, or of another run.

    Raises
    ------
    ResultsDamaged
        If it cannot be read.
    """
    if not path.exists():
        return None
    data = read_netcdf(path)
    with damage_named(path):
        if data.attrs[IDENTITY] != identity:
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
