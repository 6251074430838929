"""C_e and m_a of a damper from universal files with force over acceleration (data set 58).

With F the force of the shaker on the damper and a its acceleration, both as e^{iωt}, the apparent
mass is M = F/a, and per area of the cells

    m_a = Re M − fixture,   C_e = −ω Im M.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.measurement.files import ACCELERATION, RESPONSE, is_in_g, read_data_set
from pidpanel.spectra.third_octaves import edge_frequency

FORCE = 13  # code of data set 58, kind of ordinate
NEWTON = ("", "N", "NONE")  # units of the force
LEAST_LINES = 4  # of a band


class ThirdOctaveDamping(NamedTuple):
    """Means over third octaves, and their standard errors from the scatter of the lines."""

    frequency: Array  # (n,) [Hz]
    # (n,) [N s/m³]
    damping: Array
    damping_error: Array
    # (n,) [kg/m²]
    mass: Array
    mass_error: Array


def read_force(
    path: Path, record: int | None, area: float, fixture_mass: float
) -> ThirdOctaveDamping:
    """Read force over acceleration, or its inverse, as C_e and m_a in third octaves.

    Parameters
    ----------
    record
        Number of the data set 58, from 1; needed where there are several.
    area
        Area of the cells [m²].
    fixture_mass
        Mass that the force moves besides the particles [kg].

    Raises
    ------
    ColumnsError
        If the file has no such function, other units than N and m/s² or g, or no band with
        positive C_e.
    """
    frequency, mass = _apparent_mass(path, record)
    mass = (mass - fixture_mass) / area
    used = frequency > 0
    bands = _by_band(frequency[used], mass[used])
    if not (bands.damping > 0).any():
        message = "C_e is negative in all third octaves; the force must be that on the damper, "
        raise ColumnsError([f"{path}: {message}with at least {LEAST_LINES} lines in a band"])
    return ThirdOctaveDamping(*(values[bands.damping > 0] for values in bands))


def _apparent_mass(path: Path, record: int | None) -> tuple[Array, Array]:
    """Return the frequency (n,) [Hz] and force over acceleration (n,) [kg]."""
    data = read_data_set(path, record)
    numerator, denominator = (
        (int(data[f"{place}_spec_data_type"]), str(data[f"{place}_axis_units_lab"]).strip())
        for place in ("ordinate", "orddenom")
    )
    if data["func_type"] != RESPONSE or {numerator[0], denominator[0]} != {FORCE, ACCELERATION}:
        message = f"must be a frequency response, function type {RESPONSE}, of force over "
        message += f"acceleration or the inverse, data types {FORCE} and {ACCELERATION}"
        raise ColumnsError([f"{path}: {message}"])
    is_inverse = numerator[0] == ACCELERATION
    units = numerator[1], denominator[1]
    force_unit, unit = units[::-1] if is_inverse else units
    if force_unit not in NEWTON:
        raise ColumnsError([f"{path}: the force must be in N, not {force_unit}"])
    values = data["data"].astype(complex)
    if is_inverse:
        with np.errstate(divide="ignore", invalid="ignore"):
            values = 1 / values
    if is_in_g(unit):
        values = values / STANDARD_GRAVITY
    frequency = data["x"].astype(float)
    if frequency.size < LEAST_LINES or not np.isfinite(values[frequency > 0]).all():
        raise ColumnsError([f"{path}: must have {LEAST_LINES} lines or more, all of them finite"])
    return frequency, values


def _by_band(frequency: Array, mass: Array) -> ThirdOctaveDamping:
    """Return the means over the third octaves that have enough lines, of m_a − i C_e/ω (n,)."""
    ends = np.round(10 * np.log10(frequency[[0, -1]])).astype(int)
    rows = []
    for low, high in edge_frequency(np.arange(ends[0], ends[1] + 1)):
        in_band = (frequency >= low) & (frequency < high)
        count = int(in_band.sum())
        if count < LEAST_LINES:
            continue
        f = frequency[in_band]
        damping, inertia = -2 * np.pi * f * mass[in_band].imag, mass[in_band].real
        row = [float(np.exp(np.log(f).mean()))]
        for values in (damping, inertia):
            row += [float(values.mean()), float(values.std(ddof=1) / np.sqrt(count))]
        rows.append(row)
    return ThirdOctaveDamping(*np.array(rows).reshape(-1, 5).T)
