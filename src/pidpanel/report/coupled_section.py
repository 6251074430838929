"""C_e and m_a of every patch on the page: from coupled runs, or from the atlas."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pidpanel.report import style
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.inputs import AtlasResults, CoupledResults
from pidpanel.report.layout import add_legend, figure_of_axes, frequency_axis, log_scale, pick
from pidpanel.report.text import number, plain, records, signed, span

CURVES = 6  # patches in the figure at most


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
        "damping": figure_picture("coupled_damping", coupled_figure, results.impedance, names),
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


def coupled_figure(table: pd.DataFrame, names: Mapping[str, str]) -> Figure:
    """Draw C_e and m_a over frequency, at most `CURVES` patches."""
    figure, (damping, mass) = figure_of_axes(2, 2, 3.4, 0.0)
    groups = list(table.groupby(["scenario", "patch"], sort=False))
    beds = [groups[int(place)] for place in pick(np.arange(float(len(groups))), CURVES)]
    for index, ((label, patch), rows) in enumerate(beds):
        several = table.loc[table["scenario"] == label, "patch"].nunique() > 1
        look: dict[str, Any] = {
            "fmt": f"-{style.MARKERS[index % len(style.MARKERS)]}",
            "color": style.PLACES[index % len(style.PLACES)],
            "capsize": 1.5,
            "elinewidth": 0.7,
            "label": names[str(label)] + (f": {patch}" if several else ""),
        }
        positive = rows["equivalent_damping_n_s_m3"].where(rows["equivalent_damping_n_s_m3"] > 0)
        errors = rows["equivalent_damping_error_n_s_m3"], rows["apparent_mass_error_kg_m2"]
        damping.errorbar(rows["frequency_hz"], positive, errors[0], **look)
        mass.errorbar(rows["frequency_hz"], rows["apparent_mass_kg_m2"], errors[1], **look)
    for axes in (damping, mass):
        frequency_axis(axes, 0.9 * table["frequency_hz"].min(), 1.1 * table["frequency_hz"].max())
    log_scale(damping)
    drawn = table.loc[table["equivalent_damping_n_s_m3"] > 0, "equivalent_damping_n_s_m3"]
    damping.set_ylim(bottom=drawn.min() / 3 if len(drawn) else None)  # not to an error's lower end
    damping.set_ylabel("Cₑ, N s/m³")
    mass.set_ylabel("mₐ, kg/m²")
    mass.axhline(0, color="#999999", lw=0.6)
    add_legend(figure, 3)
    return figure


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
        picture = figure_picture("atlas_damping", coupled_figure, beds, names)
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
    return pd.concat(parts)
