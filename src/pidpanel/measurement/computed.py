"""Computed curves that measured ones are compared with."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY

CHOSEN = {"input": "stated", "direction": "up"}  # of the inputs and directions under base motion

# Variables of the response, of random and of sine motion of the supports, and their errors
ERRORS = {
    "acceleration_psd": "acceleration_psd_log_error",
    "absolute_acceleration_psd": "log_error",
    "acceleration": "acceleration_log_error",
}


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
        Scenario and point.
    over_base
        Whether the PSD is over that of the supports, the square of the transmissibility. Always so
        for a sine.
    """
    case = curves.sel({**place, **{n: value for n, value in CHOSEN.items() if n in curves.dims}})
    name = next(name for name in ERRORS if name in case)
    values, error = case[name].to_numpy(), case.get(ERRORS[name])
    if not np.isfinite(values).all():
        return None
    log_error = None if error is None or bool(error.isnull().any()) else error.to_numpy()
    if name == "acceleration":  # an amplitude
        psd = (values / STANDARD_GRAVITY / curves.attrs["acceleration_g"]) ** 2
        log_error = None if log_error is None else 2 * log_error
    elif over_base:
        psd = values / case["input_psd"].to_numpy()
    else:
        psd = values / STANDARD_GRAVITY**2
    return ComputedPsd(case["frequency"].to_numpy(), psd, log_error)
