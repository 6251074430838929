"""What ``response/psd.nc`` says of one scenario."""

from __future__ import annotations

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, Flags


def inside_of(psd: xr.Dataset, reading: str, scenario: str) -> Flags:
    """Return (nf,) whether the damping of all patches is within the range of its data."""
    if "inside" not in psd:  # a panel without patches
        return np.ones(psd.sizes["frequency"], dtype=np.bool_)
    inside = psd["inside"].sel(reading=reading, scenario=scenario).transpose("patch", "frequency")
    return np.asarray((inside.to_numpy() > 0.5).all(axis=0))


def log_error_of(psd: xr.Dataset, reading: str, scenario: str, point: str) -> Array | None:
    """Return (nf,) the standard error of ln of a PSD due to its damping; None without one."""
    if "acceleration_psd_log_error" not in psd:
        return None
    errors = psd["acceleration_psd_log_error"]
    error = errors.sel(reading=reading, scenario=scenario, point=point).to_numpy()
    return error if np.isfinite(error).all() else None
