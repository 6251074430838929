"""All scenarios on the page, each with every point and damping model."""

from itertools import product

import pandas as pd

from pidpanel.report import text
from pidpanel.report.html import PageSection, template_section
from pidpanel.report.names import Study, names_of


def summary_section(study: Study, summary: pd.DataFrame) -> PageSection:
    """Return mass, rms values and reductions of all scenarios."""
    by_key = {(row["scenario"], row["reading"], row["point"]): row for row in text.records(summary)}
    rows, names = [], names_of(study)
    decimals = {}
    for reading, of in summary.groupby("reading"):
        gain_decimals = text.common_decimals(of["reduction_error_db"], text.DECIBEL_DECIMALS)
        rms_decimals = text.common_decimals(of["acceleration_rms_error_g"])
        decimals[reading] = {"rms_decimals": rms_decimals, "decimals": gain_decimals}
    for scenario, reading, point in product(
        study.all_scenarios(), study.readings, study.panel.points
    ):
        if scenario.is_bare and reading != study.readings[0]:
            continue  # the same with every damping model
        name = names[scenario.label]
        if name == scenario.label and not scenario.is_bare:
            name += f" ({scenario.filling_text})"
        row = by_key[scenario.label, reading, point]
        rows.append({**row, "name": name, "is_bare": scenario.is_bare, **decimals[reading]})
    return template_section("summary.html", "All scenarios", {"rows": rows})
