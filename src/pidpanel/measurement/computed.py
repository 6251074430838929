"""Computed curves that measured ones are compared with."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
import xarray as xr

from pidpanel.arrays import Array, Complexes
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.eigen import factors
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.solve.model import ModalBasis
from pidpanel.sound.radiation import Air

CHOSEN = {"input": "stated", "direction": "up"}  # of the inputs and directions under base motion

# Variables of the response, of random and of sine motion of the supports, and their errors
ERRORS = {
    "acceleration_psd": "acceleration_psd_log_error",
    "absolute_acceleration_psd": "log_error",
    "acceleration": "acceleration_log_error",
    "squared_accelerance": "",
}
HAMMER = "hammer"  # what excites a panel whose acceleration over a force is measured
LINES_AT_ONCE = 64


def point_remainder(plate: PlateMatrices, modal: ModalBasis, deflection: Array) -> Array:
    """Return the static compliance (n_points, n_points) that the shapes of a basis lack [m/N].

    P K⁻¹ Pᵀ − φ K_φ⁻¹ φᵀ: modes above the basis respond to a force at a point at once. Of a panel
    that moves rigidly both are those of K + ω₁² M, with its first frequency above 0 Hz.
    """
    square = modal.angular_frequency**2
    shift = 0.0 if square.all() else float(square[square > 0].min())
    rows = plate.at_points.toarray()
    whole = rows @ factors(sp.csr_array(plate.stiffness + shift * plate.mass)).solve(rows.T)
    return np.asarray(whole - (deflection / (modal.modal_mass * (square + shift))) @ deflection.T)


def squared_accelerance(
    modal: ModalBasis, deflection: Array, remainder: Array, frequency: Array, air: Air | None
) -> Array:
    """Return |a/F|² (nf, n_points, n_points) of points over those hit by a force [1/kg²].

    a/F = −ω² (φ Z⁻¹ φᵀ + R) with Z = Z₀ − ω²M_air + iωR_air, of the bare panel.

    Parameters
    ----------
    deflection
        (n_points, n) w of the shapes at the points.
    remainder
        R; see `point_remainder`.
    frequency
        (nf,) [Hz].
    air
        Air on the panel; None in vacuum.
    """
    parts = []
    for lines in np.array_split(frequency, -(-frequency.size // LINES_AT_ONCE)):
        stiffness = modal.dynamic_stiffness(lines)
        moved: Complexes = deflection.T / stiffness[:, :, None]
        if air is not None:
            matrices = air(lines) + stiffness[:, :, None] * np.eye(stiffness.shape[1])
            moved = np.linalg.solve(matrices, moved * stiffness[:, :, None])
        parts.append(
            (2 * np.pi * lines[:, None, None]) ** 4 * np.abs(deflection @ moved + remainder) ** 2
        )
    return np.concatenate(parts)


class ComputedPsd(NamedTuple):
    """(nf,) frequency [Hz] and PSD [g²/Hz], or over that of the supports [1]."""

    frequency: Array
    psd: Array
    log_error: Array | None  # standard error of ln of the PSD; None without one


def computed_psd(
    curves: xr.Dataset, place: Mapping[str, str], *, over_base: bool
) -> ComputedPsd | None:
    """Return a computed PSD; None where there is no steady motion.

    Parameters
    ----------
    curves
        Curves of ``response/psd.nc``, ``base/psd.nc`` or ``base/sine.nc``.
    place
        Scenario and point, and the point that a hammer hits.
    over_base
        Whether the PSD is over that of the supports, the square of the transmissibility. Always so
        for a sine.
    """
    place = {**CHOSEN, **place}
    case = curves.sel({name: value for name, value in place.items() if name in curves.dims})
    name = next(name for name in ERRORS if name in case)
    values, error = case[name].to_numpy(), case.get(ERRORS[name])
    if not np.isfinite(values).all():
        return None
    log_error = None if error is None or bool(error.isnull().any()) else error.to_numpy()
    if name == "acceleration":  # an amplitude
        psd = (values / STANDARD_GRAVITY / curves.attrs["acceleration_g"]) ** 2
        log_error = None if log_error is None else 2 * log_error
    elif name == "squared_accelerance":
        psd = values
    elif over_base:
        psd = values / case["input_psd"].to_numpy()
    else:
        psd = values / STANDARD_GRAVITY**2
    return ComputedPsd(case["frequency"].to_numpy(), psd, log_error)
