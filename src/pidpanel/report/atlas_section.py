"""The atlas of particle beds on the page: its source, and C_e and m_a of every patch."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from pidpanel.constants import ATLAS
from pidpanel.damping.coupled import COUPLED
from pidpanel.report.coupled_section import coupled_figure
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.inputs import AtlasResults
from pidpanel.report.text import records

LINES = 40  # frequencies of a curve


def atlas_text(atlas: AtlasResults) -> str:
    """Return version and size of the atlas."""
    return f"version {atlas.version}, {atlas.cases} simulated cases"


def atlas_section(
    atlas: AtlasResults,
    layouts: pd.DataFrame,
    names: Mapping[str, str],
    frequency: tuple[float, float],
) -> PageSection:
    """Return C_e and m_a from the atlas at the motions of the patches.

    Parameters
    ----------
    layouts
        Rows of ``response/layouts.csv``.
    names
        Names of the scenarios by label.
    frequency
        Range of the response [Hz].
    """
    beds = curves(atlas, layouts, frequency)
    picture = figure_picture("atlas_damping", coupled_figure, beds, names)
    is_coupled = (layouts["reading"] == COUPLED).any()
    values = {"atlas": atlas_text(atlas), "damping": picture, "is_coupled": is_coupled}
    return template_section("atlas.html", "Damping from the atlas", values)


def curves(
    atlas: AtlasResults, layouts: pd.DataFrame, frequency: tuple[float, float]
) -> pd.DataFrame:
    """Return a row for each patch read from the atlas and each frequency, as `coupled_figure`."""
    f, parts = np.geomspace(*frequency, LINES), []
    for row in records(layouts[layouts["reading"] == ATLAS]):
        model = atlas.models.get(row["damper"])
        if model is None:
            continue
        point = float(row["fill_fraction"]), float(row["damping_read_at_g"])
        values = model(f, *point)
        mass_error = np.sqrt(np.diag(model.covariance(f, *point))[LINES:])
        part = pd.DataFrame(
            {
                "scenario": row["scenario"],
                "patch": row["patch"],
                "frequency_hz": f,
                "equivalent_damping_n_s_m3": values.equivalent_damping,
                "equivalent_damping_error_n_s_m3": values.equivalent_damping_error,
                "apparent_mass_kg_m2": values.apparent_mass,
                "apparent_mass_error_kg_m2": mass_error,
            }
        )
        parts.append(part[values.inside])
    return pd.concat(parts)
