"""Strain and stress in the layer of the panel where they are worst."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from pidpanel.report.html import Table
from pidpanel.report.tables import number, records

SYMBOLS = {
    "von_mises": "σ_v",
    "stress_xx": "σ_xx",
    "stress_yy": "σ_yy",
    "stress_xy": "τ_xy",
    "strain_xx": "ε_xx",
    "strain_yy": "ε_yy",
    "strain_xy": "γ_xy",
}
"""Heads of the columns by what ``response/stress.csv`` calls the quantities of a layer."""

UNITS = {"MPa": "MPa", "microstrain": "µm/m"}
"""What the units of ``response/stress.csv`` are called on the page."""


def stress_table(stress: pd.DataFrame, names: Mapping[str, str]) -> Table:
    """The layer of largest von Mises stress at each point, with all its strains and stresses.

    Parameters
    ----------
    stress
        ``response/stress.csv`` with the points as text; the core, which has no von Mises stress,
        is left out.
    names
        What each reading is called.
    """
    units = stress.drop_duplicates("quantity").set_index("quantity")["unit"]
    where = ["reading", "scenario", "point"]
    von_mises = stress[stress["quantity"] == "von_mises"]
    worst = von_mises.loc[von_mises.groupby(where, sort=False)["three_sigma"].idxmax()]
    shown = {
        tuple(row[key] for key in (*where, "layer", "quantity")): (
            f"{number(row['rms'])} / {number(row['three_sigma'])}"
        )
        for row in records(stress)
    }
    rows = []
    for row in records(worst[[*where, "layer"]]):
        cells = [shown[(*row.values(), quantity)] for quantity in SYMBOLS]
        rows.append([names[row["reading"]], row["scenario"], row["point"], row["layer"], *cells])
    return Table(
        "Strain and stress, rms / 3σ, in the layer where the von Mises stress σ_v is largest; its "
        "rms takes in the correlations between the components, its 3σ is three times that by "
        "custom; γ_xy is the engineering shear strain",
        [*where, "layer", *(f"{symbol}, {UNITS[units[q]]}" for q, symbol in SYMBOLS.items())],
        rows,
        folded=True,
    )
