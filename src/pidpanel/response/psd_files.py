"""The dataset of ``response/psd.nc``."""

from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.provenance.results import read_netcdf


def read_psd(path: Path) -> xr.Dataset:
    """Read the dataset of ``response/psd.nc`` or ``stress.nc``, in memory."""
    return read_netcdf(path, ["frequency"])


def is_steady(psd: xr.Dataset, scenario: str) -> bool:
    """Return whether a scenario has a response: it has none if the damping feeds the panel."""
    accelerations = psd["acceleration_psd"].sel(scenario=scenario)
    return not bool(np.isnan(accelerations).any())
