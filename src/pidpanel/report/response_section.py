"""Responses on the page: families of scenarios and layouts, the damping behind them."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import html, response_figures, style
from pidpanel.report.inputs import Inputs
from pidpanel.report.names import ComparedScenarios, Scenario, layouts_of
from pidpanel.report.response_figures import chart_picture, nested_width, psd_unit
from pidpanel.report.rms import band_rms_of, inside_of, psd_curve
from pidpanel.report.text import number, span
from pidpanel.response.psd_files import is_steady
from pidpanel.solve.bands import reduction

# Where C_e is read, by ``damping.level.kind``.
READ_AT = {"patch": "the patch's own acceleration", "stated": "a stated acceleration"}

# Quantities of a damper in ``response/psd.nc``: name, label, whether on a logarithmic axis.
QUANTITIES = (
    ("equivalent_damping", "Cₑ, N s/m³", True),
    ("apparent_mass", "apparent mass mₐ, kg/m²", False),
)

# Quantity in which the rows of reductions differ.
ROW_NAMES = {
    "fill_fraction": "fill fraction r", "patch": "patch", "damper": "damper",
    "oaspl_db": "sound level, dB",
}  # fmt: skip


def response_section(inputs: Inputs, family: ComparedScenarios) -> html.PageSection:
    """Return one family of scenarios: PSDs at every point, reductions by band, the damping."""
    name, heading = f"response-{family.key}", family.title or f"Scenarios: {family.key}"
    steady = {
        title: group
        for title, group in family.groups.items()
        if all(is_steady(inputs.psd, scenario.label) for scenario in group)
    }
    if not steady:
        return html.PageSection(name, heading, [html.Fragment("unsteady.html", {})])
    frequency = inputs.psd["frequency"].to_numpy()
    points = inputs.moving_points
    groups = {title + refuted(inputs, group): group for title, group in steady.items()}
    notes = {title: acceleration_note(inputs, group) for title, group in groups.items()}
    psds = []
    for point in points:
        curves_of = {t: psd_curves(inputs, family, group, point) for t, group in groups.items()}
        charts = [
            html.Chart(title, frequency, psd_unit(point), curves, notes[title])
            for title, curves in curves_of.items()
        ]
        curves = list(itertools.chain.from_iterable(curves_of.values()))
        psds.append(
            {
                "point": point,
                "picture": chart_picture(f"psd_{family.key}_{point}", charts),
                "is_dashed": any(c.inside is not None and not c.inside.all() for c in curves),
            }
        )
    values = {
        "unstable": [title for title in family.groups if title not in steady],
        "reductions": reductions_of(inputs, family, groups) if points else [],
        "key": family.key,
        "psds": psds,
        "damping": damping_block(inputs, family, groups, notes),
    }
    return html.PageSection(name, heading, [html.Fragment("response.html", values)])


def _known_as(inputs: Inputs, family: ComparedScenarios, scenario: Scenario) -> tuple[str, str]:
    """Return the name of a scenario within its family, and its colour."""
    varied = family.varied
    if varied == "damper":
        names = list(dict.fromkeys(s.dampers for s in family.scenarios))
        return scenario.dampers, style.place_colour(scenario.dampers, names)
    if varied == "fill_fraction":
        return f"r = {scenario.fill_fraction:g}", style.fill_colour(scenario.fill_fraction)
    if varied == "patch":
        place = str(scenario.patch)
        return place, style.place_colour(place, list(inputs.study.panel.patches))
    levels = [s.oaspl_db or 0.0 for s in family.scenarios]
    level = scenario.oaspl_db or 0.0
    return f"{level:g} dB", style.level_colour(level, levels)


def psd_curves(
    inputs: Inputs, family: ComparedScenarios, scenarios: Sequence[Scenario], point: str
) -> list[html.PageCurve]:
    """Return PSDs [g²/Hz] of the bare panel at each sound level, then of the scenarios."""
    place = {"point": point}
    levels = {s.bare.label: _known_as(inputs, family, s) for s in scenarios}
    curves = []
    for label, (level, colour) in levels.items():
        curve = psd_curve(inputs.psd, {**place, "scenario": label}, "bare panel", style.BARE, 0.8)
        if len(levels) > 1:
            curve = replace(curve, label=f"bare panel, {level}", colour=colour, line="dotted")
        curves.append(curve)
    for index, scenario in enumerate(scenarios):
        look = *_known_as(inputs, family, scenario), nested_width(index, len(scenarios))
        # no bands: those of several curves would hide them
        curves.append(psd_curve(inputs.psd, {**place, "scenario": scenario.label}, *look))
    return curves


def refuted(inputs: Inputs, scenarios: Sequence[Scenario]) -> str:
    """Return in how many scenarios the coupled runs refute their damping model; "" for none."""
    if inputs.coupled is None or inputs.coupled.verdict is None:
        return ""
    study, table = inputs.study, inputs.coupled.verdict
    table = table[table["holds"] == "no"]
    wrong = set(zip(table["scenario"], table["damper"], strict=True))
    count = sum(
        any((other.label, scenario.dampers) in wrong for other in study.alternatives(scenario))
        for scenario in scenarios
    )
    return f" – does not hold in {count} of {len(scenarios)}" if count else ""


def acceleration_note(inputs: Inputs, scenarios: Sequence[Scenario]) -> str:
    """Return the line under the title of the axes: at which Γ the damping was read."""
    if all(map(inputs.study.is_coupled_scenario, scenarios)):
        return "Cₑ at the patch's own motion"
    rows = inputs.summary.drop_duplicates("scenario").set_index("scenario")
    read_at = rows["damping_read_at_g"][[scenario.label for scenario in scenarios]]
    if read_at.isna().all():
        return "Cₑ independent of Γ"
    gamma = span(number(value) for value in (read_at.min(), read_at.max()))
    return f"Cₑ at {READ_AT[inputs.study.damping.level.kind]}, Γ = {gamma}"


Groups = Mapping[str, Sequence[Scenario]]  # scenarios by the title of their damping model


def reductions_of(
    inputs: Inputs, family: ComparedScenarios, groups: Groups
) -> list[html.ColourTable]:
    """Return third-octave reductions of a family, by point and damping model."""
    points = inputs.moving_points
    gained: dict[tuple[str, str], Array] = {}
    centre, rows = np.zeros(0), []
    for title, group in groups.items():
        centre, treated = band_rms_of(inputs.psd, [s.label for s in group], points)
        _, bare = band_rms_of(inputs.psd, [s.bare.label for s in group], points)
        values = reduction(bare, treated)
        gained |= {(point, title): values[..., index] for index, point in enumerate(points)}
        names = [_known_as(inputs, family, scenario)[0] for scenario in group]
        rows = [name.removeprefix("r = ").removesuffix(" dB") for name in names]
    return response_figures.reduction_tables(centre, rows, gained, ROW_NAMES[family.varied])


def damping_block(
    inputs: Inputs, family: ComparedScenarios, groups: Groups, notes: Mapping[str, str]
) -> html.Picture:
    """Return C_e and m_a with which a family was computed, by damping model."""
    frequency, charts = inputs.psd["frequency"].to_numpy(), []
    for title, group in groups.items():
        for quantity, unit, is_log in QUANTITIES:
            curves = []
            for scenario in group:
                place = {"scenario": scenario.label, "patch": scenario.patch}
                values = inputs.psd[quantity].sel(place).to_numpy()
                inside = inside_of(inputs.psd, scenario.label)
                look = _known_as(inputs, family, scenario)
                curves.append(html.PageCurve(look[0], values, look[1], width=1.1, inside=inside))
            charts.append(html.Chart(title, frequency, unit, curves, notes[title], is_log))
    return chart_picture(f"damping_{family.key}", charts, height=2.9)


DRAWN_TOGETHER = 6  # layouts in one figure at most: as many as there are colours without an order


def layouts_section(inputs: Inputs) -> html.PageSection:
    """Return the PSDs of the explicit layouts and of their dead weights at every point."""
    study = inputs.study
    points = []
    drawn = [s for s in layouts_of(study) if is_steady(inputs.psd, s.label)]
    for point in inputs.moving_points:
        psds = []
        for first in range(0, len(drawn), DRAWN_TOGETHER):
            part = drawn[first : first + DRAWN_TOGETHER]
            name = f"psd_layouts_{first // DRAWN_TOGETHER + 1}_{point}"
            inside = [inside_of(inputs.psd, scenario.label) for scenario in part]
            psds.append(
                {
                    "picture": _psd_picture(inputs, part, point, name),
                    "has_band": len(part) == 1,
                    "is_dashed": not np.all(inside),
                }
            )
        if psds:
            points.append([point, psds])
    return html.template_section("layouts.html", "Layouts", {"points": points})


def _psd_picture(
    inputs: Inputs, scenarios: Sequence[Scenario], point: str, name: str
) -> html.Picture:
    """Return PSDs of the bare panel, of layouts and of their dead weights at a point."""
    place = {"point": point}
    bare = dict.fromkeys(s.bare.label for s in scenarios)
    curves = []
    for label in bare:
        name_of = "bare panel" if len(bare) == 1 else label
        curves.append(psd_curve(inputs.psd, {**place, "scenario": label}, name_of, style.BARE, 0.8))
    labels = [layout.label for layout in layouts_of(inputs.study)]
    colours = dict(zip(labels, itertools.cycle(style.PLACES), strict=False))
    dead, treated = [], []
    for index, scenario in enumerate(scenarios):
        label, colour = inputs.names[scenario.label], colours[scenario.label]
        case_place = {**place, "scenario": scenario.label}
        dead_psd = inputs.psd["dead_weight_acceleration_psd"].sel(case_place)
        weight = dead_psd.to_numpy() / STANDARD_GRAVITY**2
        if np.isfinite(weight).all():
            dead.append(
                html.PageCurve(f"{label}: dead weight", weight, style.pale(colour), "dotted", 1.0)
            )
        width = nested_width(index, len(scenarios))
        # a band of one curve hides nothing; those of several would
        has_band = len(scenarios) == 1
        treated.append(psd_curve(inputs.psd, case_place, label, colour, width, has_band=has_band))
    frequency = inputs.psd["frequency"].to_numpy()
    chart = html.Chart("", frequency, psd_unit(point), [*curves, *dead, *treated])
    return chart_picture(name, [chart])
