"""Families of scenarios on the page: PSDs, reductions, the damping behind them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pidpanel.report import response_figures, style
from pidpanel.report.charts import chart_of
from pidpanel.report.html import Block, Fold, PageSection, Paragraph, Picture
from pidpanel.report.inputs import Inputs
from pidpanel.report.layouts_section import mass_table
from pidpanel.report.psds import inside_of
from pidpanel.report.response_figures import FigurePanel, PsdCurve, Steps, nested_width
from pidpanel.report.rms import band_rms_of, moving_points
from pidpanel.report.text import READINGS, does_not_move, number
from pidpanel.solve.bands import reduction, third_octaves
from pidpanel.study import Scenario
from pidpanel.study.damping import COUPLED

EQUIVALENT_SINE = "Γ = √2 a_rms/g, the sine of equal rms, is an assumption."

READ_AT = {"patch": "the patch's own acceleration", "stated": "a stated acceleration"}
"""Where C_e is read, by ``damping.level.kind``."""


def response_section(inputs: Inputs, name: str) -> PageSection:
    """Return one family of scenarios: PSDs at every point, reductions by band, the damping."""
    study, psd = inputs.study, inputs.psd
    title = study.families[name].title or f"Scenarios: {name}"
    readings = stable_readings(inputs, name)
    if not readings:
        text = "No damping model gives a steady response, because C_e is negative."
        return PageSection(f"response-{name}", title, [Paragraph(text)])
    frequency = psd["frequency"].to_numpy()
    text = acceleration_text(inputs, name, readings)
    points = moving_points(inputs.summary, list(study.panel.points))
    fixed = [point for point in study.panel.points if point not in points]
    blocks: list[Block] = [Paragraph(f"{does_not_move(fixed)} {text}" if fixed else text)]
    if points:
        blocks.append(reduction_block(inputs, name, readings))
    for point in points:
        panels = [
            FigurePanel(
                reading_title(inputs, name, reading),
                acceleration_note(inputs, name, reading),
                psd_curves(inputs, name, reading, point),
            )
            for reading in readings
        ]
        caption = (
            f"One-sided acceleration PSD at point {point}; steps are at the edges of the sound's "
            "bands."
        )
        figure = response_figures.psd_figure(frequency, panels)
        charts = [chart_of(panel.title, frequency, panel.curves) for panel in panels]
        steps = {
            reading_title(inputs, name, reading): reduction_steps(inputs, name, reading, point)
            for reading in readings
        }
        pictures = [
            Picture(f"psd_{name}_{point}", style.png(figure), caption, charts),
            Picture(
                f"steps_{name}_{point}",
                style.png(response_figures.steps_figure(steps)),
                f"Reduction of the rms acceleration at point {point} in third octaves.",
            ),
        ]
        blocks.append(Fold(f"Point {point}", pictures))
    if inputs.summary["added_mass_kg"].gt(0).any():
        blocks.append(mass_table(inputs, study.family_scenarios(name), layouts=False))
    blocks.append(Fold("Damping behind these responses", [damping_block(inputs, name, readings)]))
    return PageSection(f"response-{name}", title, blocks)


def reduction_steps(inputs: Inputs, name: str, reading: str, point: str) -> list[Steps]:
    """Return reductions of a family in third octaves at a point."""
    scenarios = inputs.study.family_scenarios(name)
    labels, bare = [s.label for s in scenarios], [s.bare.label for s in scenarios]
    _, treated = band_rms_of(inputs.psd, reading, labels, [point])
    _, untreated = band_rms_of(inputs.psd, reading, bare, [point])
    gained = reduction(untreated, treated)[..., 0]
    frequency = inputs.psd["frequency"].to_numpy()
    _, edge = third_octaves(frequency[0], frequency[-1])
    edges = np.append(edge[:, 0], edge[-1, 1])
    styles = [_known_as(inputs, name, scenario) for scenario in scenarios]
    return [
        Steps(label, colour, edges, values)
        for (label, colour), values in zip(styles, gained, strict=True)
    ]


def stable_readings(inputs: Inputs, name: str) -> list[str]:
    """Return the readings in which every scenario of a family has a response."""
    labels = [s.label for s in inputs.study.family_scenarios(name)]
    psd = inputs.psd["acceleration_psd"]
    return [
        reading
        for reading in inputs.study.readings
        if bool(np.isfinite(psd.sel(reading=reading, scenario=labels)).all())
    ]


def _known_as(inputs: Inputs, name: str, scenario: Scenario) -> tuple[str, str]:
    """Return the name of a scenario within its family, and its colour."""
    study = inputs.study
    varied = study.families[name].varied
    if varied == "fill_fraction":
        return f"r = {scenario.fill_fraction:g}", style.fill_colour(scenario.fill_fraction)
    if varied == "patch":
        place = str(scenario.patch)
        return place, style.place_colour(place, list(study.panel.patches))
    levels = [s.oaspl_db or 0.0 for s in study.family_scenarios(name)]
    level = scenario.oaspl_db or 0.0
    return f"{level:g} dB", style.level_colour(level, levels)


def psd_curves(inputs: Inputs, name: str, reading: str, point: str) -> list[PsdCurve]:
    """Return PSDs [(m/s²)²/Hz] of the bare panel at each sound level, then of the scenarios."""
    scenarios = inputs.study.family_scenarios(name)
    psd = inputs.psd["acceleration_psd"].sel(reading=reading, point=point)
    bare = list(dict.fromkeys(s.bare.label for s in scenarios))
    levels = {s.bare.label: f"bare panel, {s.oaspl_db or 0.0:g} dB" for s in scenarios}
    curves = [
        PsdCurve(levels[label] if len(bare) > 1 else "bare panel",
                 psd.sel(scenario=label).to_numpy(), style.BARE, width=0.8)
        for label in bare
    ]  # fmt: skip
    for index, scenario in enumerate(scenarios):
        label, colour = _known_as(inputs, name, scenario)
        width = nested_width(index, len(scenarios))
        values = psd.sel(scenario=scenario.label).to_numpy()
        # no bands: those of several curves would hide them
        inside = inside_of(inputs.psd, reading, scenario.label)
        curves.append(PsdCurve(label, values, colour, inside, width))
    return curves


def _accelerations(inputs: Inputs, name: str, reading: str) -> dict[str, float]:
    """Return Γ at which the damping of each scenario was read; NaN where it depends on none."""
    rows = inputs.summary[inputs.summary["reading"] == reading].drop_duplicates("scenario")
    read_at = rows.set_index("scenario")["damping_read_at_g"]
    return {
        _known_as(inputs, name, s)[0]: float(read_at[s.label])
        for s in inputs.study.family_scenarios(name)
    }


def refuted(inputs: Inputs, name: str, reading: str) -> list[str]:
    """Return the scenarios of a family in which coupled runs refute a reading."""
    if inputs.coupled is None or inputs.coupled.verdict is None:
        return []
    table = inputs.coupled.verdict
    wrong = set(table.loc[(table["reading"] == reading) & (table["holds"] == "no"), "scenario"])
    scenarios = inputs.study.family_scenarios(name)
    return [_known_as(inputs, name, s)[0] for s in scenarios if s.label in wrong]


def reading_title(inputs: Inputs, name: str, reading: str) -> str:
    """Return the name of a reading over its figures, with how often it does not hold."""
    wrong, count = len(refuted(inputs, name, reading)), len(inputs.study.family_scenarios(name))
    return READINGS[reading] + (f" – refuted in {wrong} of {count}" if wrong else "")


def acceleration_note(inputs: Inputs, name: str, reading: str) -> str:
    """Return the line under the title of the axes: at which Γ the damping was read."""
    if reading == COUPLED:
        return "$C_e$ at the patch's own motion"
    read_at = np.array(list(_accelerations(inputs, name, reading).values()))
    if np.isnan(read_at).all():
        return "$C_e$ independent of Γ"
    low, high = number(read_at.min()), number(read_at.max())
    kind = READ_AT[inputs.study.damping.level.kind]
    return f"$C_e$ at {kind}, Γ = {low}" + (f" to {high}" if high != low else "")


def acceleration_text(inputs: Inputs, name: str, readings: Sequence[str]) -> str:
    """Return what a caption says of Γ, the dashes and the readings left out."""
    parts = []
    for reading in readings:
        if wrong := refuted(inputs, name, reading):
            parts.append(
                f"{READINGS[reading]}: refuted by coupled runs for {', '.join(wrong)} (Which "
                "damping model holds)."
            )
        if reading == COUPLED:
            parts.append(f"{READINGS[reading]}: C_e at the patch's own motion.")
            continue
        read_at = _accelerations(inputs, name, reading)
        if all(np.isnan(gamma) for gamma in read_at.values()):
            parts.append(f"{READINGS[reading]}: C_e independent of Γ.")
            continue
        kind = inputs.study.damping.level.kind
        motions = ", ".join(f"{number(gamma)} ({scenario})" for scenario, gamma in read_at.items())
        parts.append(
            f"{READINGS[reading]}: C_e at {READ_AT[kind]} (level.kind: {kind}), Γ = {motions}. "
            f"{EQUIVALENT_SINE}"
        )
        labels = [s.label for s in inputs.study.family_scenarios(name)]
        if not all(inside_of(inputs.psd, reading, label).all() for label in labels):
            parts.append("Dashed: Γ or frequency outside the simulated range.")
    for reading in inputs.study.readings:
        if reading not in readings:
            parts.append(f"{READINGS[reading]}: not drawn, because its C_e is negative.")
    return " ".join(parts)


def reduction_block(inputs: Inputs, name: str, readings: Sequence[str]) -> Picture:
    """Return third-octave reductions of a family as maps."""
    study = inputs.study
    scenarios = study.family_scenarios(name)
    points = moving_points(inputs.summary, list(study.panel.points))
    gained = {}
    titles = {reading: reading_title(inputs, name, reading) for reading in readings}
    centre = np.empty(0)
    for reading in readings:
        labels, bare = [s.label for s in scenarios], [s.bare.label for s in scenarios]
        centre, treated = band_rms_of(inputs.psd, reading, labels, points)
        _, untreated = band_rms_of(inputs.psd, reading, bare, points)
        for index, point in enumerate(points):
            gained[point, titles[reading]] = reduction(untreated, treated)[..., index]
    row_name = {
        "fill_fraction": "fill fraction r",
        "patch": "patch",
        "oaspl_db": "sound level, dB",
    }[study.families[name].varied]
    rows = [
        _known_as(inputs, name, s)[0].removeprefix("r = ").removesuffix(" dB") for s in scenarios
    ]
    figure = response_figures.reduction_figure(
        centre, rows, gained, points, list(titles.values()), row_name
    )
    caption = (
        "Reduction of the rms acceleration in third octaves against the bare panel under the "
        "same sound; positive (blue): less acceleration. Where the PSDs are dashed, these "
        "values use damping outside the simulated range."
    )
    return Picture(f"reduction_{name}", style.png(figure), caption)


def damping_block(inputs: Inputs, name: str, readings: Sequence[str]) -> Picture:
    """Return C_e and m_a with which a family was computed."""
    damping, mass = [], []
    for reading in readings:
        upper, lower = [], []
        for scenario in inputs.study.family_scenarios(name):
            label, colour = _known_as(inputs, name, scenario)
            selection = {"reading": reading, "scenario": scenario.label, "patch": scenario.patch}
            row = inputs.psd.sel(selection)
            inside = inside_of(inputs.psd, reading, scenario.label)
            upper.append(PsdCurve(label, row["equivalent_damping"].to_numpy(), colour, inside, 1.1))
            lower.append(PsdCurve(label, row["apparent_mass"].to_numpy(), colour, inside, 1.1))
        title = reading_title(inputs, name, reading)
        note = acceleration_note(inputs, name, reading)
        damping.append(FigurePanel(title, note, upper))
        mass.append(FigurePanel(title, note, lower))
    figure = response_figures.damping_figure(inputs.psd["frequency"].to_numpy(), damping, mass)
    caption = "Equivalent damping and apparent mass used for these responses."
    return Picture(f"damping_{name}", style.png(figure), caption)
