"""Strain and stress on the page: the layer of the panel where they are largest."""

import pandas as pd

from pidpanel.report.html import Cell, PageSection, table_of
from pidpanel.report.text import READINGS, number, records, unit

# Symbols of the quantities of a layer in ``response/stress.csv``.
SYMBOLS = {
    "von_mises": "σ_v",
    "stress_xx": "σ_xx",
    "stress_yy": "σ_yy",
    "stress_xy": "τ_xy",
    "strain_xx": "ε_xx",
    "strain_yy": "ε_yy",
    "strain_xy": "γ_xy",
}


def stress_section(stress: pd.DataFrame) -> PageSection:
    """Return the layer of largest von Mises stress at each point, all its strains and stresses."""
    units = stress.drop_duplicates("quantity").set_index("quantity")["unit"]
    place = ["reading", "scenario", "point", "layer"]
    von_mises = stress[stress["quantity"] == "von_mises"]
    worst = von_mises.loc[von_mises.groupby(place[:3], sort=False)["three_sigma"].idxmax()]
    rms = stress.pivot(index=place, columns="quantity", values="rms")
    cells: dict[str, Cell] = {
        "scenario": lambda row: row["scenario"],
        "damping model": lambda row: READINGS[row["reading"]],
        "point": lambda row: row["point"],
        "layer": lambda row: row["layer"],
        f"σ_v 3σ, {unit(units['von_mises'])}": lambda row: number(row["three_sigma"]),
    }
    cells |= {f"{symbol}, {unit(units[q])}": _rms(q) for q, symbol in SYMBOLS.items()}
    table = table_of(
        records(worst[[*place, "three_sigma"]].join(rms, on=place)),
        "Rms strain and stress in the layer with the largest von Mises stress σ_v. The rms of σ_v "
        "includes the correlations between the components; 3σ is three times the rms. γ_xy is the "
        "engineering shear strain.",
        cells,
        folded=True,
        title="Strain and stress of the most highly stressed layer",
    )
    return PageSection("stress", "Strain and stress", [table])


def _rms(quantity: str) -> Cell:
    return lambda row: number(row[quantity])
