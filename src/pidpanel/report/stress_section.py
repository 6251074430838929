"""Strain and stress on the page: the layer of the panel where they are largest."""

from __future__ import annotations

import pandas as pd

from pidpanel.report.html import PageSection, Table
from pidpanel.report.text import READINGS, number, records, unit

SYMBOLS = {
    "von_mises": "σ_v",
    "stress_xx": "σ_xx",
    "stress_yy": "σ_yy",
    "stress_xy": "τ_xy",
    "strain_xx": "ε_xx",
    "strain_yy": "ε_yy",
    "strain_xy": "γ_xy",
}
"""Symbols of the quantities of a layer in ``response/stress.csv``."""


def stress_section(stress: pd.DataFrame) -> PageSection:
    """Return strain and stress at every point in every scenario."""
    return PageSection("stress", "Strain and stress", [stress_table(stress)])


def stress_table(stress: pd.DataFrame) -> Table:
    """Return the layer of largest von Mises stress at each point, all its strains and stresses."""
    units = stress.drop_duplicates("quantity").set_index("quantity")["unit"]
    where = ["reading", "scenario", "point"]
    von_mises = stress[stress["quantity"] == "von_mises"]
    worst = von_mises.loc[von_mises.groupby(where, sort=False)["three_sigma"].idxmax()]
    texts = {
        tuple(row[key] for key in (*where, "layer", "quantity")): (
            f"{number(row['rms'])} ({number(row['three_sigma'])})"
            if row["quantity"] == "von_mises"
            else number(row["rms"])
        )
        for row in records(stress)
    }
    layers = list(dict.fromkeys(worst["layer"]))
    readings = [READINGS[name] for name in worst["reading"].unique()]
    one_layer, one_reading = len(layers) == 1, len(readings) == 1
    rows = []
    for row in records(worst[[*where, "layer"]]):
        cells = [texts[(*row.values(), quantity)] for quantity in SYMBOLS]
        read = [] if one_reading else [READINGS[row["reading"]]]
        layer = [] if one_layer else [row["layer"]]
        rows.append([row["scenario"], *read, row["point"], *layer, *cells])
    heads = [f"{symbol}, {unit(units[q])}" for q, symbol in SYMBOLS.items()]
    heads[0] = f"{heads[0]} rms (3σ)"
    place = f" (here always: {layers[0]})" if one_layer else ""
    head = f"{readings[0]}. " if one_reading else ""
    reading, layer = [] if one_reading else ["damping model"], [] if one_layer else ["layer"]
    return Table(
        f"{head}Rms strain and stress in the layer with the largest von Mises stress σ_v{place}. "
        "The rms of σ_v includes the correlations between the components; brackets give 3σ, "
        "three times the rms. γ_xy is the engineering shear strain.",
        ["scenario", *reading, "point", *layer, *heads],
        rows,
        folded=True,
        title="Strain and stress of the most highly stressed layer",
    )
