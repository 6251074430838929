"""Strain and stress on the page: the layer of the panel where they are largest."""

from collections.abc import Collection

import pandas as pd

from pidpanel.report.html import PageSection, template_section
from pidpanel.report.text import NAMES, records


def stress_section(stress: pd.DataFrame, bare: Collection[str] = ()) -> PageSection:
    """Return the layer of largest von Mises stress at each point, all its strains and stresses."""
    units = stress.drop_duplicates("quantity").set_index("quantity")
    place = ["reading", "scenario", "point", "layer"]
    von_mises = stress[stress["quantity"] == "von_mises"]
    is_again = von_mises.duplicated(place[1:])  # a bare panel is the same with every damping model
    von_mises = von_mises[~(is_again & von_mises["scenario"].isin(bare))]
    worst = von_mises.loc[von_mises.groupby(place[:3], sort=False)["three_sigma"].idxmax()]
    rms = stress.pivot(index=place, columns="quantity", values="rms")
    values = {
        "rows": records(worst[[*place, "three_sigma"]].join(rms, on=place)),
        "bare": bare,
        "units": units["unit"].to_dict(),
        "symbols": NAMES["stresses"],
    }
    return template_section("stress.html", "Strain and stress", values)
