"""Standard errors of the coupled runs at the points."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.solve.uncertainty import StandardErrors


def read_errors(folder: Path, frequency: Array, points: Sequence[str]) -> dict[str, StandardErrors]:
    """Return the errors of the coupled runs in a folder at the points, by scenario."""
    files = (folder / "summary.csv", folder / "psd.csv")
    summary, psd = (pd.read_csv(path, dtype={"point": str}) for path in files)
    errors = {}
    for scenario, rows in summary.groupby("scenario", sort=False):
        at_points = rows.set_index("point").loc[list(points)]
        lines = psd[psd["scenario"] == scenario]
        by_point = [lines[lines["point"] == point] for point in points]
        log_psd = [
            np.interp(np.log(frequency), np.log(table["frequency_hz"]), table["error_db"])
            for table in by_point
        ]
        errors[str(scenario)] = StandardErrors(
            np.log(10) / 10 * np.stack(log_psd, axis=1),
            (at_points["g_rms_error"] / at_points["g_rms"]).to_numpy(float),
            np.array([np.nan]),
        )
    return errors
