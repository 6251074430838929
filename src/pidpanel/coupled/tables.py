"""C_e, m_a and own force of scenarios that are carried from other levels, as a table."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from pidpanel.coupled.carried import extrapolated, interpolated
from pidpanel.damping.coupled import BAND_COLUMNS, BandDamping


def carried_impedances(
    scenario: str, source: str, level: float, near: Sequence[tuple[float, pd.DataFrame]]
) -> pd.DataFrame:
    """Return the rows of `impedances` of a scenario that was not run, from one or two levels."""

    def bed(rows: pd.DataFrame) -> BandDamping:
        bands = {name: rows[column].to_numpy() for name, column in BAND_COLUMNS.items()}
        return BandDamping(**bands, common_error=float(rows["common_error"].iloc[0]))

    parts = []
    for patch, rows in near[0][1].groupby("patch", sort=False):
        beds = [bed(table[table["patch"] == patch]) for _, table in near]
        if len(near) == 1:
            carried = extrapolated(level - near[0][0], *beds)
        else:
            low, high = near[0][0], near[1][0]
            carried = interpolated((level - low) / (high - low), *beds)
        values = {column: getattr(carried, name) for name, column in BAND_COLUMNS.items()}
        parts.append(
            rows.assign(
                scenario=scenario, **values, common_error=carried.common_error, carried_from=source
            )
        )
    return pd.concat(parts)
