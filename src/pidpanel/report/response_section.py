"""Families of scenarios on the page: PSDs, reductions, the damping behind them."""

import itertools
from collections.abc import Mapping

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.coupled import COUPLED
from pidpanel.report import response_figures, style
from pidpanel.report.html import Chart, ColourTable, Fragment, PageCurve, PageSection, Picture
from pidpanel.report.inputs import Inputs
from pidpanel.report.names import ComparedScenarios, Scenario
from pidpanel.report.response_figures import PSD_UNIT, chart_picture, nested_width
from pidpanel.report.rms import band_rms_of, inside_of, psd_curve
from pidpanel.report.text import READINGS, number
from pidpanel.solve.bands import reduction

# Where C_e is read, by ``damping.level.kind``.
READ_AT = {"patch": "the patch's own acceleration", "stated": "a stated acceleration"}

# Of a damper in ``response/psd.nc``: name, label, whether on a logarithmic axis.
QUANTITIES = (
    ("equivalent_damping", "$C_e$, N s/m³", True),
    ("apparent_mass", "apparent mass $m_a$, kg/m²", False),
)

# What the rows of reductions differ in.
ROW_NAMES = {"fill_fraction": "fill fraction r", "patch": "patch", "oaspl_db": "sound level, dB"}


def response_section(inputs: Inputs, family: ComparedScenarios) -> PageSection:
    """Return one family of scenarios: PSDs at every point, reductions by band, the damping."""
    name, heading = f"response-{family.key}", family.title or f"Scenarios: {family.key}"
    readings = stable_readings(inputs, family)
    if not readings:
        return PageSection(name, heading, [Fragment("unsteady.html", {})])
    frequency = inputs.psd["frequency"].to_numpy()
    points = inputs.moving_points
    titles = {reading: reading_title(inputs, family, reading) for reading in readings}
    notes = {reading: acceleration_note(inputs, family, reading) for reading in readings}
    psds = []
    for point in points:
        curves_of = {r: psd_curves(inputs, family, r, point) for r in readings}
        charts = [Chart(titles[r], frequency, PSD_UNIT, curves_of[r], notes[r]) for r in readings]
        curves = list(itertools.chain.from_iterable(curves_of.values()))
        psds.append(
            {
                "point": point,
                "picture": chart_picture(f"psd_{family.key}_{point}", charts),
                "is_dashed": any(c.inside is not None and not c.inside.all() for c in curves),
            }
        )
    values = {
        "unstable": [reading for reading in inputs.study.readings if reading not in readings],
        "reductions": reductions_of(inputs, family, titles) if points else [],
        "key": family.key,
        "psds": psds,
        "damping": damping_block(inputs, family, titles, notes),
    }
    return PageSection(name, heading, [Fragment("response.html", values)])


def stable_readings(inputs: Inputs, family: ComparedScenarios) -> list[str]:
    """Return the readings in which every scenario of a family has a response."""
    labels = [s.label for s in family.scenarios]
    psd = inputs.psd["acceleration_psd"].sel(scenario=labels)
    return [r for r in inputs.study.readings if bool(np.isfinite(psd.sel(reading=r)).all())]


def _known_as(inputs: Inputs, family: ComparedScenarios, scenario: Scenario) -> tuple[str, str]:
    """Return the name of a scenario within its family, and its colour."""
    varied = family.varied
    if varied == "fill_fraction":
        return f"r = {scenario.fill_fraction:g}", style.fill_colour(scenario.fill_fraction)
    if varied == "patch":
        place = str(scenario.patch)
        return place, style.place_colour(place, list(inputs.study.panel.patches))
    levels = [s.oaspl_db or 0.0 for s in family.scenarios]
    level = scenario.oaspl_db or 0.0
    return f"{level:g} dB", style.level_colour(level, levels)


def psd_curves(
    inputs: Inputs, family: ComparedScenarios, reading: str, point: str
) -> list[PageCurve]:
    """Return PSDs [g²/Hz] of the bare panel at each sound level, then of the scenarios."""
    scenarios, place = family.scenarios, {"reading": reading, "point": point}
    levels = {s.bare.label: f", {s.oaspl_db or 0.0:g} dB" for s in scenarios}
    curves = []
    for label, level in levels.items():
        name = "bare panel" + (level if len(levels) > 1 else "")
        curves.append(psd_curve(inputs.psd, {**place, "scenario": label}, name, style.BARE, 0.8))
    for index, scenario in enumerate(scenarios):
        look = *_known_as(inputs, family, scenario), nested_width(index, len(scenarios))
        # no bands: those of several curves would hide them
        curves.append(psd_curve(inputs.psd, {**place, "scenario": scenario.label}, *look))
    return curves


def reading_title(inputs: Inputs, family: ComparedScenarios, reading: str) -> str:
    """Return the name of a reading over its figures, with how often coupled runs refute it."""
    if inputs.coupled is None or inputs.coupled.verdict is None:
        return READINGS[reading]
    table = inputs.coupled.verdict
    wrong = set(table.loc[(table["reading"] == reading) & (table["holds"] == "no"), "scenario"])
    scenarios = [scenario.label for scenario in family.scenarios]
    count = len(wrong.intersection(scenarios))
    return READINGS[reading] + (f" – refuted in {count} of {len(scenarios)}" if count else "")


def acceleration_note(inputs: Inputs, family: ComparedScenarios, reading: str) -> str:
    """Return the line under the title of the axes: at which Γ the damping was read."""
    if reading == COUPLED:
        return "$C_e$ at the patch's own motion"
    rows = inputs.summary[inputs.summary["reading"] == reading].drop_duplicates("scenario")
    read_at = rows.set_index("scenario")["damping_read_at_g"]
    read_at = read_at[[scenario.label for scenario in family.scenarios]]
    if read_at.isna().all():
        return "$C_e$ independent of Γ"
    low, high = number(read_at.min()), number(read_at.max())
    kind = READ_AT[inputs.study.damping.level.kind]
    return f"$C_e$ at {kind}, Γ = {low}" + (f" to {high}" if high != low else "")


def reductions_of(
    inputs: Inputs, family: ComparedScenarios, titles: Mapping[str, str]
) -> list[ColourTable]:
    """Return third-octave reductions of a family, by point and reading."""
    points = inputs.moving_points
    gained: dict[tuple[str, str], Array] = {}
    scenarios = family.scenarios
    for reading, title in titles.items():
        centre, treated = band_rms_of(inputs.psd, reading, [s.label for s in scenarios], points)
        _, bare = band_rms_of(inputs.psd, reading, [s.bare.label for s in scenarios], points)
        values = reduction(bare, treated)
        gained |= {(point, title): values[..., index] for index, point in enumerate(points)}
    rows = [
        _known_as(inputs, family, s)[0].removeprefix("r = ").removesuffix(" dB") for s in scenarios
    ]
    return response_figures.reduction_tables(centre, rows, gained, ROW_NAMES[family.varied])


def damping_block(
    inputs: Inputs, family: ComparedScenarios, titles: Mapping[str, str], notes: Mapping[str, str]
) -> Picture:
    """Return C_e and m_a with which a family was computed, by reading."""
    frequency, charts = inputs.psd["frequency"].to_numpy(), []
    for reading, title in titles.items():
        for quantity, unit, is_log in QUANTITIES:
            curves = [
                _damping_curve(inputs, family, reading, s, quantity) for s in family.scenarios
            ]
            charts.append(Chart(title, frequency, unit, curves, notes[reading], is_log))
    return chart_picture(f"damping_{family.key}", charts, height=2.9)


def _damping_curve(
    inputs: Inputs, family: ComparedScenarios, reading: str, scenario: Scenario, quantity: str
) -> PageCurve:
    selection = {"reading": reading, "scenario": scenario.label, "patch": scenario.patch}
    values = inputs.psd[quantity].sel(selection).to_numpy()
    inside = inside_of(inputs.psd, reading, scenario.label)
    label, colour = _known_as(inputs, family, scenario)
    return PageCurve(label, values, colour, width=1.1, inside=inside)
