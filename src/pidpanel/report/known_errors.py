"""Scenarios without errors: one damper without a stated error leaves none to the whole."""

from collections.abc import Collection

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.damping.coupled import COUPLED

# Columns of ``response/summary.csv`` with errors.
COLUMNS = ("acceleration_rms_error_g", "reduction_error_db", "damping_read_at_error_g")

PARTLY = ("stated", COUPLED)  # readings in which patches are read as the study states them


def without_errors(
    labels: Collection[str], summary: pd.DataFrame, psd: xr.Dataset
) -> tuple[pd.DataFrame, xr.Dataset]:
    """Return ``summary.csv`` and ``psd.nc`` without the errors of some scenarios in `PARTLY`."""
    if not labels:
        return summary, psd
    summary, psd = summary.copy(), psd.copy()
    selected = summary["reading"].isin(PARTLY) & summary["scenario"].isin(list(labels))
    summary.loc[selected, [name for name in COLUMNS if name in summary]] = np.nan
    if "acceleration_psd_log_error" in psd:
        of_psd = psd["reading"].isin(PARTLY) & psd["scenario"].isin(list(labels))
        psd["acceleration_psd_log_error"] = psd["acceleration_psd_log_error"].where(~of_psd)
    return summary, psd
