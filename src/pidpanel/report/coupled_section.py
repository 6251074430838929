"""C_e and m_a of every patch on the page: from coupled runs, or from the atlas."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd

from pidpanel.report import style
from pidpanel.report.html import Chart, PageCurve, PageSection, Picture, template_section
from pidpanel.report.inputs import AtlasResults, CoupledResults
from pidpanel.report.layout import pick
from pidpanel.report.response_figures import chart_picture
from pidpanel.report.text import number, plain, records, signed, span

CURVES = 6  # patches in the figure at most

# Columns of the figure: name, label, whether on a logarithmic axis.
QUANTITIES = (
    ("equivalent_damping_n_s_m3", "Cₑ, N s/m³", True),
    ("apparent_mass_kg_m2", "apparent mass mₐ, kg/m²", False),
)


def coupled_section(
    results: CoupledResults,
    names: Mapping[str, str],
    points: Sequence[str],
    *,
    in_air: bool = False,
) -> PageSection:
    """Return what the coupled runs know and found: a table, and C_e and m_a over frequency."""
    values = {
        "in_air": in_air,
        "rows": coupled_rows(results, names, points),
        "damping": damping_picture("coupled_damping", results.impedance, names),
    }
    return template_section("coupled.html", "Panel and particles together", values)


def coupled_rows(
    results: CoupledResults, names: Mapping[str, str], points: Sequence[str]
) -> list[dict[str, str]]:
    """Return a row for each scenario; parameters are those of `coupled_section`."""
    summary = results.summary[results.summary["point"].isin(points)]
    by_label = dict(list(results.impedance.groupby("scenario")))
    rows = []
    for label, beds in ((name, by_label[name]) for name in names if name in by_label):
        scenario_rows = summary[summary["scenario"] == label]
        error = 100 * scenario_rows["g_rms_error"] / scenario_rows["g_rms"]
        share = 100 * (1 - (scenario_rows["linear_g_rms"] / scenario_rows["g_rms"]) ** 2)
        rows.append(
            {
                "name": names[label],
                "runs": str(int(scenario_rows["runs"].iloc[0])),
                "error": span(number(value, 2) for value in (error.min(), error.max())),
                "residual": span(signed(f(scenario_rows["residual_db"]), 2) for f in (min, max)),
                "share": span(plain(value, 1) for value in (share.min(), share.max())),
                "modulus": _by_patch(beds, "youngs_modulus_mpa", "{:g}".format),
                "mass": _by_patch(beds, "particle_mass_per_area_kg_m2"),
            }
        )
    return rows


def _by_patch(beds: pd.DataFrame, column: str, text: Callable[[float], str] = number) -> str:
    """Return a quantity of the simulated beds, by patch where they differ; "–" without it."""
    if column not in beds:
        return "–"
    first = beds.drop_duplicates("patch")
    values = {patch: text(x) for patch, x in zip(first["patch"], first[column], strict=True)}
    if len(set(values.values())) == 1:
        return next(iter(values.values()))
    return ", ".join(f"{value} ({patch})" for patch, value in values.items())


def damping_picture(name: str, table: pd.DataFrame, names: Mapping[str, str]) -> Picture:
    """Return C_e and m_a over frequency with their errors, of at most `CURVES` patches."""
    groups = list(table.groupby(["scenario", "patch"], sort=False))
    beds = [groups[int(place)] for place in pick(np.arange(float(len(groups))), CURVES)]
    frequency, charts = np.unique(table["frequency_hz"]), []
    for column, label, is_log in QUANTITIES:
        curves = []
        for ((scenario, patch), rows), colour in zip(beds, style.PLACES, strict=False):
            several = table.loc[table["scenario"] == scenario, "patch"].nunique() > 1
            rows = rows.set_index("frequency_hz").reindex(frequency)
            error = rows[column.replace("_n_s", "_error_n_s").replace("_kg", "_error_kg")]
            curve_name = names[str(scenario)] + (f": {patch}" if several else "")
            values = rows[column].to_numpy()
            curves.append(PageCurve(curve_name, values, colour, error=error.to_numpy()))
        charts.append(Chart("", frequency, label, curves, is_log=is_log))
    return chart_picture(name, charts, height=3.4)


LINES = 40  # frequencies of a curve


def atlas_section(
    atlas: AtlasResults,
    layouts: pd.DataFrame,
    names: Mapping[str, str],
    frequency: tuple[float, float],
    *,
    is_coupled: bool,
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
    is_coupled
        Whether the study has coupled runs.
    """
    beds = curves(atlas, layouts, frequency)
    picture = None
    if len(beds):  # else the atlas has no bed at any of these motions
        picture = damping_picture("atlas_damping", beds, names)
    values = {"atlas": atlas.text, "damping": picture, "is_coupled": is_coupled}
    return template_section("atlas.html", "Damping from the atlas", values)


def curves(
    atlas: AtlasResults, layouts: pd.DataFrame, frequency: tuple[float, float]
) -> pd.DataFrame:
    """Return a row for each patch read from the atlas and each frequency, as `coupled_figure`."""
    f, parts = np.geomspace(*frequency, LINES), []
    for row in records(layouts[layouts["damper"].isin(list(atlas.models))]):
        model = atlas.models[row["damper"]]
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
    return pd.concat(parts) if parts else pd.DataFrame()  # none without scenarios
