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
    "oaspl_db": "sound level, dB", "layout": "layout",
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
        "damping": None
        if family.varied == "layout"
        else damping_block(inputs, family, groups, notes),
        "has_layouts": family.varied == "layout",
    }
    return html.PageSection(name, heading, [html.Fragment("response.html", values)])


def _known_as(inputs: Inputs, family: ComparedScenarios, scenario: Scenario) -> tuple[str, str]:
    """Return the name of a scenario within its family, and its colour."""
    varied = family.varied
    if varied == "layout":
        rank = family.scenarios.index(scenario)
        return inputs.names[scenario.label], style.PLACES[rank % len(style.PLACES)]
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
    return inputs.study.acoustics.level_text(level), style.level_colour(level, levels)


def psd_curves(
    inputs: Inputs, family: ComparedScenarios, scenarios: Sequence[Scenario], point: str
) -> list[html.PageCurve]:
    """Return PSDs [g²/Hz] of the bare panel at each sound level, then of the scenarios."""
    place = {"point": point}
    is_layout = family.varied == "layout"
    levels = {s.bare.label: _known_as(inputs, family, s) for s in scenarios}
    curves, treated = [], []
    for label, (level, colour) in levels.items():
        curve = psd_curve(inputs.psd, {**place, "scenario": label}, "bare panel", style.BARE, 0.8)
        if len(levels) > 1:
            name = label if is_layout else f"bare panel, {level}"
            colour = style.BARE if is_layout else colour
            curve = replace(curve, label=name, colour=colour, line="dotted")
        curves.append(curve)
    for index, scenario in enumerate(scenarios):
        look = *_known_as(inputs, family, scenario), nested_width(index, len(scenarios))
        if is_layout:
            dead = _dead_weight(inputs, scenario, point, look[1])
            curves += [dead] if np.isfinite(dead.values).all() else []
        # no bands: those of several curves would hide them
        at_point = {**place, "scenario": scenario.label}
        treated.append(psd_curve(inputs.psd, at_point, *look, has_band=len(scenarios) == 1))
    return curves + treated


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
    """Return the explicit layouts with their dead weights, `DRAWN_TOGETHER` in a chart."""
    layouts = tuple(layouts_of(inputs.study))
    steady = [scenario for scenario in layouts if is_steady(inputs.psd, scenario.label)]
    count = -(-len(steady) // DRAWN_TOGETHER)
    groups = {
        f"part {part + 1} of {count}" if count > 1 else "": tuple(steady[part::count])
        for part in range(count)
    }
    family = ComparedScenarios("layouts", "Layouts", "layout", layouts, groups)
    return replace(response_section(inputs, family), name="layouts")


def _dead_weight(inputs: Inputs, scenario: Scenario, point: str, colour: str) -> html.PageCurve:
    """Return the PSD [g²/Hz] with the same masses as dead weight."""
    dead = inputs.psd["dead_weight_acceleration_psd"].sel(scenario=scenario.label, point=point)
    values = dead.to_numpy() / STANDARD_GRAVITY**2
    name = f"{inputs.names[scenario.label]}: dead weight"
    return html.PageCurve(name, values, style.pale(colour), "dotted", 1.0)
