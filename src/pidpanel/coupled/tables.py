"""C_e, m_a and own force of scenarios that are carried from other levels, as a table."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from pidpanel.coupled.carried import FoundBed, between, beyond

OF_A_BED = {
    "equivalent_damping": "equivalent_damping_n_s_m3",
    "equivalent_damping_error": "equivalent_damping_error_n_s_m3",
    "apparent_mass": "apparent_mass_kg_m2",
    "apparent_mass_error": "apparent_mass_error_kg_m2",
    "own_psd": "own_force_psd_pa2_hz",
    "own_coherence": "own_force_coherence",
}
"""Columns by the names of `carried.FoundBed`."""


def carried_impedances(
    scenario: str, source: str, level: float, near: Sequence[tuple[float, pd.DataFrame]]
) -> pd.DataFrame:
    """Return the rows of `impedances` of a scenario that was not run, from one or two levels.

    Parameters
    ----------
    scenario, source
        Its name, and those of the runs.
    level
        Of it [dB].
    near
        Levels that were run, rising, and their rows.
    """

    def bed(rows: pd.DataFrame) -> FoundBed:
        columns = {**OF_A_BED, "common_error": "common_error"}
        return FoundBed.of({name: rows[column].to_numpy() for name, column in columns.items()})

    parts = []
    for patch, like in near[0][1].groupby("patch", sort=False):
        beds = [bed(table[table["patch"] == patch]) for _, table in near]
        if len(near) == 1:
            found = beyond(level - near[0][0], *beds)
        else:
            low, high = near[0][0], near[1][0]
            found = between((level - low) / (high - low), *beds)
        values = {column: getattr(found, name) for name, column in OF_A_BED.items()}
        parts.append(
            like.assign(
                scenario=scenario, **values, common_error=found.common_error, carried_from=source
            )
        )
    return pd.concat(parts)
