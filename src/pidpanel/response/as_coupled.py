"""What coupled runs found, as a reading of the damping and as the errors of its answers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping.best_linear import LinearApproximation
from pidpanel.damping.random_reading import RandomReading
from pidpanel.response.uncertainty import StandardErrors


class CoupledReading(RandomReading):
    """C_e, m_a and own force of coupled runs, whose own force is linear in ln f as it is there."""

    def _psd(self, frequency: Array, psd: Array) -> Array:
        found: Array = self._hats(frequency) @ psd
        return found


def read_coupled(path: Path) -> dict[tuple[str, str], RandomReading]:
    """Read ``coupled/impedance.csv``: scenario and patch → C_e, m_a and own force of its bed.

    Parameters
    ----------
    path
        The table.
    """
    table = pd.read_csv(path, dtype={"scenario": str, "patch": str})
    return {
        (str(scenario), str(patch)): _reading(rows)
        for (scenario, patch), rows in table.groupby(["scenario", "patch"], sort=False)
    }


def _reading(rows: pd.DataFrame) -> CoupledReading:
    def column(name: str) -> Array:
        return rows[name].to_numpy(float)

    centre = column("frequency_hz")
    half = 10**0.05
    bands = LinearApproximation(
        low=centre / half,
        high=centre * half,
        frequency=centre,
        equivalent_damping=column("equivalent_damping_n_s_m3"),
        equivalent_damping_error=column("equivalent_damping_error_n_s_m3"),
        apparent_mass=column("apparent_mass_kg_m2"),
        apparent_mass_error=column("apparent_mass_error_kg_m2"),
        coherence=np.full(len(centre), np.nan),
        # no more than chance where it is negative
        common_psd=np.maximum(column("own_psd_in_common_pa2_hz"), 0.0),
        own_psd=column("own_psd_of_a_cell_pa2_hz"),
        # carried from other levels, all bands err together
        packing_error=float(rows["common_error"].iloc[0]),
    )
    return CoupledReading(
        bands,
        weight=float(rows["particle_mass_per_area_kg_m2"].iloc[0]),
        area=float(rows["cell_area_m2"].iloc[0]),
    )


def read_errors(
    summary_csv: Path, psd_csv: Path, frequency: Array, points: Sequence[str]
) -> dict[str, StandardErrors]:
    """Return the errors of the coupled runs at the points, by scenario.

    Parameters
    ----------
    summary_csv, psd_csv
        ``coupled/summary.csv`` and ``coupled/psd.csv``.
    frequency
        (nf,) at which those of the PSDs are wanted [Hz].
    points
        Their names.
    """
    summary, psd = (pd.read_csv(path, dtype={"point": str}) for path in (summary_csv, psd_csv))
    found = {}
    for scenario, of in summary.groupby("scenario", sort=False):
        at = of.set_index("point").loc[list(points)]
        own = psd[psd["scenario"] == scenario]
        by_point = [own[own["point"] == point] for point in points]
        log_psd = [
            np.interp(np.log(frequency), np.log(one["frequency_hz"]), one["error_db"])
            for one in by_point
        ]
        found[str(scenario)] = StandardErrors(
            np.log(10) / 10 * np.stack(log_psd, axis=1),
            (at["g_rms_error"] / at["g_rms"]).to_numpy(float),
            np.array([np.nan]),
        )
    return found
