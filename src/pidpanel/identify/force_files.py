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
from pidpanel.measurement.universal import (
    ACCELERATION,
    FORCE,
    RESPONSE,
    RecordChoice,
    read_function,
)
from pidpanel.spectra.third_octaves import edge_frequency
from pidpanel.tabular.units import KILOGRAM

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
        If the file has no such function, units that are not those of both, or no band with
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
    function = read_function(path, RecordChoice(record))
    numerator, denominator = (function.axes[name].kind for name in ("ordinate", "orddenom"))
    if function.kind != RESPONSE or {numerator, denominator} != {FORCE, ACCELERATION}:
        message = f"must be a frequency response, function type {RESPONSE}, of force over "
        message += f"acceleration or the inverse, data types {FORCE} and {ACCELERATION}"
        raise function.refusal(message)
    values, allowed = function.values.astype(complex), "such as N and m/s^2, lbf and g"
    if numerator == FORCE:
        values *= function.factor(KILOGRAM, "force over acceleration", f"units {allowed}")
    else:
        inverse = KILOGRAM.power(-1)
        values *= function.factor(inverse, "acceleration over force", f"units {allowed}")
        with np.errstate(divide="ignore", invalid="ignore"):
            values = 1 / values
    frequency = function.frequency
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
