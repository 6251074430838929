"""Which scenarios have errors at all: one damper without an error leaves none to the whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.study import Study
from pidpanel.study.dampers import Damper
from pidpanel.study.damping import COUPLED

COLUMNS = ("acceleration_rms_error_g", "reduction_error_db", "damping_read_at_error_g")
"""Columns of ``response/summary.csv`` with errors."""

PARTLY = ("stated", COUPLED)
"""Readings in which patches are read as the study states them."""


def states_error(damper: Damper) -> bool:
    """Return whether a damper comes with an error of its damping.

    Examples
    --------
    >>> states_error(Damper(law="paper_corrected")), states_error(
    ...     Damper(equivalent_damping_n_s_m3=100, equivalent_damping_error_n_s_m3=10))
    (False, True)
    >>> states_error(Damper(equivalent_damping_n_s_m3=0, apparent_mass_kg_m2=3))  # dead weight
    True
    """
    if damper.coupon is not None:
        return True
    table = damper.table or damper.impedance
    if table is not None:
        return any("error" in column for column in _columns(table))
    if damper.equivalent_damping_n_s_m3 is not None:
        return damper.equivalent_damping_n_s_m3 == 0 or bool(damper.equivalent_damping_error_n_s_m3)
    if damper.loss_factor is not None:
        return damper.loss_factor == 0 or bool(damper.loss_factor_error)
    return False


def _columns(table: Path) -> list[str]:
    lines = table.read_bytes().decode("utf-8-sig", errors="replace").splitlines()
    header = next((line for line in lines if line.partition("#")[0].strip()), "")
    return [name.strip() for name in header.partition("#")[0].split(",")]


def partly_known(study: Study) -> list[str]:
    """Return the scenarios some of whose dampers state no error, by label.

    What `PARTLY` find for them holds the errors of the others alone.
    """
    with_errors = {name for name, damper in study.all_dampers.items() if states_error(damper)}
    return [
        scenario.label
        for scenario in study.all_scenarios()
        if any(filling.damper not in with_errors for filling in scenario.fillings)
    ]


def with_known_errors(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset
) -> tuple[pd.DataFrame, xr.Dataset]:
    """Return ``summary.csv`` and ``psd.nc`` without the errors of `partly_known` scenarios."""
    labels = partly_known(study) if set(PARTLY) & set(study.readings) else []
    if not labels:
        return summary, psd
    summary, psd = summary.copy(), psd.copy()
    selected = summary["reading"].isin(PARTLY) & summary["scenario"].isin(labels)
    summary.loc[selected, [name for name in COLUMNS if name in summary]] = np.nan
    if "acceleration_psd_log_error" in psd:
        of_psd = psd["reading"].isin(PARTLY) & psd["scenario"].isin(labels)
        psd["acceleration_psd_log_error"] = psd["acceleration_psd_log_error"].where(~of_psd)
    return summary, psd
