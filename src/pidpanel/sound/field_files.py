"""The files of the modal force and of the air."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, variable
from pidpanel.sound.microphones import MeasuredTable, Microphones
from pidpanel.sound.wavenumber_table import JoinedTable, Table, WavenumberTable

MODAL_FORCE = "modal_force"  # G of the field that drives the panel [m⁴]

# G of the diffuse field [m⁴], which gives the radiation, and V of the added mass [m³].
DIFFUSE, ADDED_VOLUME = "diffuse_modal_force", "added_volume"

COUPLING = "microphone_coupling"  # X of modal forces and microphones [m²]

# Arrays of `Microphones` and of their cross-spectra, with dimensions, units and meaning.
MICROPHONES = {
    "position": ("microphone xyz", "m", "position of microphones"),
    "wavenumber": ("line", "rad m-1", "wavenumber of the lines"),
    "real": ("line microphone other_microphone", "1", "cross-spectra per PSD on the face, real"),
    "imaginary": ("line microphone other_microphone", "1", "the same, imaginary"),
}

UPPER = "above"  # ending of the second part of a joined table
LOAD_ERROR = "load_error"

KINDS = {
    MODAL_FORCE: ("m4", "modal force per pressure PSD, G"),
    DIFFUSE: ("m4", "modal force of the diffuse field, G"),
    COUPLING: ("m2", "modal force and pressure at microphones in a diffuse field, X"),
    ADDED_VOLUME: ("m3", "added mass of the air on one side over its density, V"),
}


def write_tables(
    path: Path,
    tables: Mapping[str, Table],
    attributes: Mapping[str, str],
    load_error: tuple[Array, Array] | None = None,
) -> None:
    """Write tables to NetCDF, each on its own nodes.

    Parameters
    ----------
    path
        The ``.nc`` file.
    tables
        Tables by the names of `KINDS`.
    load_error
        Wavenumbers (nk,) [rad/m], and the relative error of each shape's load there (nk, n).
    """
    import xarray as xr  # slow to import, and reading does without

    variables = {}
    for name, kind, table in parts_of(tables):
        axis = f"{name}_wavenumber"
        units, long_name = KINDS[kind]
        dims = f"{axis} shape {'microphone' if kind == COUPLING else 'other_shape'}"
        variables[name] = variable(dims, table.even, units, long_name)
        variables[name].attrs["wavenumber_max_rad_m"] = table.wavenumber_max
        variables[name].attrs["wavenumber_power"] = table.power
        if table.odd_over_wavenumber is not None:
            meaning = f"{long_name}: imaginary part over k"
            odd = variable(dims, table.odd_over_wavenumber, f"{units} m rad-1", meaning)
            variables[f"{name}_odd"] = odd
        meaning = "acoustic wavenumber, Chebyshev nodes"
        variables[axis] = variable(axis, table.wavenumber, "rad m-1", meaning)
    for measured in tables.values():
        if isinstance(measured, MeasuredTable):
            microphones, spectra = measured.microphones, measured.microphones.spectra
            arrays = microphones.position, microphones.wavenumber, spectra.real, spectra.imag
            for (name, (dims, units, meaning)), array in zip(
                MICROPHONES.items(), arrays, strict=True
            ):
                variables[f"microphone_{name}"] = variable(dims, array, units, meaning)
            stated = {"noise": microphones.noise, "before_wall": int(microphones.before_wall)}
            variables["microphone_position"].attrs |= stated
    if load_error is not None:
        axis, (wavenumber, error) = f"{LOAD_ERROR}_wavenumber", load_error
        meaning = "relative error of each load"
        variables[axis] = variable(axis, wavenumber, "rad m-1", "acoustic wavenumber")
        variables[LOAD_ERROR] = variable(f"{axis} shape", error, "1", meaning)
    xr.Dataset(variables, attrs=dict(attributes)).to_netcdf(path, engine="scipy")


def parts_of(tables: Mapping[str, Table]) -> Iterator[tuple[str, str, WavenumberTable]]:
    """Yield the tables by their names in the file and of `KINDS`."""
    for kind, table in tables.items():
        if isinstance(table, MeasuredTable):
            yield from parts_of({kind: table.diffuse})
            yield COUPLING, COUPLING, table.coupling
        elif isinstance(table, JoinedTable):
            yield kind, kind, table.lower
            yield f"{kind}_{UPPER}", kind, table.upper
        else:
            assert isinstance(table, WavenumberTable)
            yield kind, kind, table


def read_table(path: Path, name: str) -> Table:
    """Read one table that `write_tables` wrote.

    Raises
    ------
    KeyError
        If the file has no such table.
    """
    from scipy.io import netcdf_file  # slow to import, and a check needs none

    # a copy at a time: of a large panel a table has a gigabyte
    with netcdf_file(path, mmap=True) as file:

        def values(variable: str) -> Array:
            return np.array(file.variables[variable].data, dtype=np.float64)

        def table(part: str) -> WavenumberTable:
            return WavenumberTable(
                float(file.variables[part].wavenumber_max_rad_m),
                values(f"{part}_wavenumber"),
                values(part),
                values(f"{part}_odd") if f"{part}_odd" in file.variables else None,
                int(file.variables[part].wavenumber_power),
            )

        upper = f"{name}_{UPPER}"
        found: Table = table(name)
        if upper in file.variables:
            found = JoinedTable(table(name), table(upper))
        if name != MODAL_FORCE or COUPLING not in file.variables:
            return found
        position, k, real, imaginary = (values(f"microphone_{array}") for array in MICROPHONES)
        noise, before_wall = (
            float(getattr(file.variables["microphone_position"], key))
            for key in ("noise", "before_wall")
        )
        spectra = real + 1j * imaginary
        microphones = Microphones(position, noise, bool(before_wall), k, spectra)
        return MeasuredTable(found, table(COUPLING), microphones)


def read_load_error(path: Path) -> tuple[Array, Array] | None:
    """Read the error of the loads that `write_tables` wrote; None where there is none."""
    from scipy.io import netcdf_file

    with netcdf_file(path, mmap=False) as file:
        if LOAD_ERROR not in file.variables:
            return None
        names = f"{LOAD_ERROR}_wavenumber", LOAD_ERROR
        wavenumber, error = (np.array(file.variables[n].data, dtype=np.float64) for n in names)
    return wavenumber, error
