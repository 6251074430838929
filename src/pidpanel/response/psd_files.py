"""The dataset of ``response/psd.nc``."""

from pathlib import Path

import numpy as np
import xarray as xr


def read_psd(path: Path) -> xr.Dataset:
    """Read the dataset of ``response/psd.nc``, in memory."""
    return xr.load_dataset(path, engine="scipy")


def is_steady(psd: xr.Dataset, reading: str, scenario: str) -> bool:
    """Return whether a scenario has a response: it has none if the damping feeds the panel."""
    accelerations = psd["acceleration_psd"].sel(reading=reading, scenario=scenario)
    return not bool(np.isnan(accelerations).any())
