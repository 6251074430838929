"""All scenarios on the page, each with every point: motion, strain and stress."""

from itertools import product

import numpy as np
import pandas as pd

from pidpanel.report.html import PageSection, template_section
from pidpanel.report.names import Study, names_of
from pidpanel.report.text import DECIBEL_DECIMALS, NAMES, common_decimals, records
from pidpanel.response.stretching import COLUMNS as STRETCHED


def summary_section(study: Study, summary: pd.DataFrame) -> PageSection:
    """Return mass, rms values and reductions of all scenarios."""
    by_key = {(row["scenario"], row["point"]): row for row in records(summary)}
    rows, names = [], names_of(study)
    decimals = {}
    for source, group in summary.groupby("damping_source"):
        gain_decimals = common_decimals(group["reduction_error_db"], DECIBEL_DECIMALS)
        rms_decimals = common_decimals(group["acceleration_rms_error_g"])
        decimals[source] = {"rms_decimals": rms_decimals, "decimals": gain_decimals}
    for scenario, point in product(study.all_scenarios(), study.panel.points):
        name = names[scenario.label]
        if name == scenario.label and not scenario.is_bare:
            name += f" ({scenario.filling_text})"
        columns = *STRETCHED, "tolerance_error_db"
        row = dict.fromkeys(columns, np.nan) | by_key[scenario.label, point]
        row |= decimals[row["damping_source"]]
        rows.append({**row, "name": name, "is_bare": scenario.is_bare})
    values = {"rows": rows, "in_plane_edges": study.panel.in_plane_edges}
    return template_section("summary.html", "All scenarios", values)


def stress_section(stress: pd.DataFrame) -> PageSection:
    """Return the layer of largest von Mises stress at each point, all its strains and stresses."""
    units = stress.drop_duplicates("quantity").set_index("quantity")
    place = ["scenario", "point", "layer"]
    von_mises = stress[stress["quantity"] == "von_mises"]
    worst = von_mises.loc[von_mises.groupby(place[:2], sort=False)["three_sigma"].idxmax()]
    rms = stress.pivot(index=place, columns="quantity", values="rms")
    values = {
        "rows": records(worst[[*place, "three_sigma"]].join(rms, on=place)),
        "units": units["unit"].to_dict(),
        "symbols": NAMES["stresses"],
    }
    return template_section("stress.html", "Strain and stress", values)
