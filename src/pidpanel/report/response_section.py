"""Families of scenarios on the page: PSDs, reductions, the damping behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.coupled import COUPLED
from pidpanel.report import response_figures, style
from pidpanel.report.charts import chart_of
from pidpanel.report.html import Block, Fold, PageSection, Paragraph, Picture
from pidpanel.report.inputs import Inputs, ReportedFamily
from pidpanel.report.layouts_section import mass_table
from pidpanel.report.names import ReportedScenario
from pidpanel.report.psds import inside_of
from pidpanel.report.response_figures import FigurePanel, PsdCurve, Steps, nested_width
from pidpanel.report.rms import band_rms_of
from pidpanel.report.text import READINGS, does_not_move, number
from pidpanel.solve.bands import reduction, third_octaves

EQUIVALENT_SINE = "Γ = √2 a_rms/g, the sine of equal rms, is an assumption."

READ_AT = {"patch": "the patch's own acceleration", "stated": "a stated acceleration"}
"""Where C_e is read, by ``damping.level.kind``."""

ROW_NAMES = {"fill_fraction": "fill fraction r", "patch": "patch", "oaspl_db": "sound level, dB"}
"""What the rows of reductions differ in."""


def response_section(inputs: Inputs, family: ReportedFamily) -> PageSection:
    """Return one family of scenarios: PSDs at every point, reductions by band, the damping."""
    name, heading = f"response-{family.key}", family.title or f"Scenarios: {family.key}"
    readings = stable_readings(inputs, family)
    if not readings:
        text = "No damping model gives a steady response, because C_e is negative."
        return PageSection(name, heading, [Paragraph(text)])
    frequency = inputs.psd["frequency"].to_numpy()
    text = acceleration_text(inputs, family, readings)
    points = inputs.moving_points
    fixed = [point for point in inputs.study.panel.points if point not in points]
    blocks: list[Block] = [Paragraph(f"{does_not_move(fixed)} {text}" if fixed else text)]
    titles = {reading: reading_title(inputs, family, reading) for reading in readings}
    if points:
        blocks.append(reduction_block(inputs, family, titles))
    for point in points:
        panels = [
            FigurePanel(
                title,
                acceleration_note(inputs, family, reading),
                psd_curves(inputs, family, reading, point),
            )
            for reading, title in titles.items()
        ]
        charts = [chart_of(panel.title, frequency, panel.curves) for panel in panels]
        steps = {
            title: reduction_steps(inputs, family, reading, point)
            for reading, title in titles.items()
        }
        pictures = [
            Picture(
                f"psd_{family.key}_{point}",
                style.png(response_figures.psd_figure(frequency, panels)),
                f"One-sided acceleration PSD at point {point}; steps are at the edges of the "
                "sound's bands.",
                charts,
            ),
            Picture(
                f"steps_{family.key}_{point}",
                style.png(response_figures.steps_figure(steps)),
                f"Reduction of the rms acceleration at point {point} in third octaves.",
            ),
        ]
        blocks.append(Fold(f"Point {point}", pictures))
    if inputs.summary["added_mass_kg"].gt(0).any():
        blocks.append(mass_table(inputs, family.scenarios, layouts=False))
    blocks.append(Fold("Damping behind these responses", [damping_block(inputs, family, titles)]))
    return PageSection(name, heading, blocks)


def _reductions(
    inputs: Inputs, family: ReportedFamily, reading: str, points: Sequence[str]
) -> tuple[Array, Array]:
    """Return centres [Hz] and reductions (n_scenarios, n_bands, n_points) [dB] of a family."""
    scenarios = family.scenarios
    centre, treated = band_rms_of(inputs.psd, reading, [s.label for s in scenarios], points)
    _, bare = band_rms_of(inputs.psd, reading, [s.bare_label for s in scenarios], points)
    return centre, reduction(bare, treated)


def reduction_steps(
    inputs: Inputs, family: ReportedFamily, reading: str, point: str
) -> list[Steps]:
    """Return reductions of a family in third octaves at a point."""
    _, gained = _reductions(inputs, family, reading, [point])
    frequency = inputs.psd["frequency"].to_numpy()
    _, edge = third_octaves(frequency[0], frequency[-1])
    edges = np.append(edge[:, 0], edge[-1, 1])
    return [
        Steps(*_known_as(inputs, family, scenario), edges, values)
        for scenario, values in zip(family.scenarios, gained[..., 0], strict=True)
    ]


def stable_readings(inputs: Inputs, family: ReportedFamily) -> list[str]:
    """Return the readings in which every scenario of a family has a response."""
    labels = [s.label for s in family.scenarios]
    psd = inputs.psd["acceleration_psd"]
    return [
        reading
        for reading in inputs.study.readings
        if bool(np.isfinite(psd.sel(reading=reading, scenario=labels)).all())
    ]


def _known_as(
    inputs: Inputs, family: ReportedFamily, scenario: ReportedScenario
) -> tuple[str, str]:
    """Return the name of a scenario within its family, and its colour."""
    varied = family.varied
    if varied == "fill_fraction":
        return f"r = {scenario.fill_fraction:g}", style.fill_colour(scenario.fill_fraction)
    if varied == "patch":
        place = str(scenario.patch)
        return place, style.place_colour(place, inputs.study.panel.patches)
    levels = [s.oaspl_db or 0.0 for s in family.scenarios]
    level = scenario.oaspl_db or 0.0
    return f"{level:g} dB", style.level_colour(level, levels)


def psd_curves(inputs: Inputs, family: ReportedFamily, reading: str, point: str) -> list[PsdCurve]:
    """Return PSDs [(m/s²)²/Hz] of the bare panel at each sound level, then of the scenarios."""
    scenarios = family.scenarios
    psd = inputs.psd["acceleration_psd"].sel(reading=reading, point=point)
    bare = list(dict.fromkeys(s.bare_label for s in scenarios))
    levels = {s.bare_label: f"bare panel, {s.oaspl_db or 0.0:g} dB" for s in scenarios}
    curves = [
        PsdCurve(levels[label] if len(bare) > 1 else "bare panel",
                 psd.sel(scenario=label).to_numpy(), style.BARE, width=0.8)
        for label in bare
    ]  # fmt: skip
    for index, scenario in enumerate(scenarios):
        label, colour = _known_as(inputs, family, scenario)
        width = nested_width(index, len(scenarios))
        values = psd.sel(scenario=scenario.label).to_numpy()
        # no bands: those of several curves would hide them
        inside = inside_of(inputs.psd, reading, scenario.label)
        curves.append(PsdCurve(label, values, colour, inside, width))
    return curves


def _accelerations(inputs: Inputs, family: ReportedFamily, reading: str) -> dict[str, float]:
    """Return Γ at which the damping of each scenario was read; NaN where it depends on none."""
    rows = inputs.summary[inputs.summary["reading"] == reading].drop_duplicates("scenario")
    read_at = rows.set_index("scenario")["damping_read_at_g"]
    return {_known_as(inputs, family, s)[0]: float(read_at[s.label]) for s in family.scenarios}


def refuted(inputs: Inputs, family: ReportedFamily, reading: str) -> list[str]:
    """Return the scenarios of a family in which coupled runs refute a reading."""
    if inputs.coupled is None or inputs.coupled.verdict is None:
        return []
    table = inputs.coupled.verdict
    wrong = set(table.loc[(table["reading"] == reading) & (table["holds"] == "no"), "scenario"])
    scenarios = family.scenarios
    return [_known_as(inputs, family, s)[0] for s in scenarios if s.label in wrong]


def reading_title(inputs: Inputs, family: ReportedFamily, reading: str) -> str:
    """Return the name of a reading over its figures, with how often it does not hold."""
    wrong, count = len(refuted(inputs, family, reading)), len(family.scenarios)
    return READINGS[reading] + (f" – refuted in {wrong} of {count}" if wrong else "")


def acceleration_note(inputs: Inputs, family: ReportedFamily, reading: str) -> str:
    """Return the line under the title of the axes: at which Γ the damping was read."""
    if reading == COUPLED:
        return "$C_e$ at the patch's own motion"
    read_at = np.array(list(_accelerations(inputs, family, reading).values()))
    if np.isnan(read_at).all():
        return "$C_e$ independent of Γ"
    low, high = number(read_at.min()), number(read_at.max())
    kind = READ_AT[inputs.study.read_kind]
    return f"$C_e$ at {kind}, Γ = {low}" + (f" to {high}" if high != low else "")


def acceleration_text(inputs: Inputs, family: ReportedFamily, readings: Sequence[str]) -> str:
    """Return what a caption says of Γ, the dashes and the readings left out."""
    parts = []
    for reading in readings:
        if wrong := refuted(inputs, family, reading):
            parts.append(
                f"{READINGS[reading]}: refuted by coupled runs for {', '.join(wrong)} (Which "
                "damping model holds)."
            )
        if reading == COUPLED:
            parts.append(f"{READINGS[reading]}: C_e at the patch's own motion.")
            continue
        read_at = _accelerations(inputs, family, reading)
        if all(np.isnan(gamma) for gamma in read_at.values()):
            parts.append(f"{READINGS[reading]}: C_e independent of Γ.")
            continue
        kind = inputs.study.read_kind
        motions = ", ".join(f"{number(gamma)} ({scenario})" for scenario, gamma in read_at.items())
        parts.append(
            f"{READINGS[reading]}: C_e at {READ_AT[kind]} (level.kind: {kind}), Γ = {motions}. "
            f"{EQUIVALENT_SINE}"
        )
        labels = [s.label for s in family.scenarios]
        if not all(inside_of(inputs.psd, reading, label).all() for label in labels):
            parts.append("Dashed: Γ or frequency outside the range of the data.")
    for reading in inputs.study.readings:
        if reading not in readings:
            parts.append(f"{READINGS[reading]}: not drawn, because its C_e is negative.")
    return " ".join(parts)


def reduction_block(inputs: Inputs, family: ReportedFamily, titles: Mapping[str, str]) -> Picture:
    """Return third-octave reductions of a family as maps, by reading."""
    points = inputs.moving_points
    gained: dict[tuple[str, str], Array] = {}
    for reading, title in titles.items():
        centre, values = _reductions(inputs, family, reading, points)
        gained |= {(point, title): values[..., index] for index, point in enumerate(points)}
    rows = [
        _known_as(inputs, family, s)[0].removeprefix("r = ").removesuffix(" dB")
        for s in family.scenarios
    ]
    figure = response_figures.reduction_figure(
        centre, rows, gained, points, list(titles.values()), ROW_NAMES[family.varied]
    )
    caption = (
        "Reduction of the rms acceleration in third octaves against the bare panel under the "
        "same sound; positive (blue): less acceleration. Where the PSDs are dashed, these "
        "values use damping outside the range of its data."
    )
    return Picture(f"reduction_{family.key}", style.png(figure), caption)


def damping_block(inputs: Inputs, family: ReportedFamily, titles: Mapping[str, str]) -> Picture:
    """Return C_e and m_a with which a family was computed, by reading."""

    def panels(quantity: str) -> list[FigurePanel]:
        return [
            FigurePanel(
                title,
                acceleration_note(inputs, family, reading),
                [_damping_curve(inputs, family, reading, s, quantity) for s in family.scenarios],
            )
            for reading, title in titles.items()
        ]

    figure = response_figures.damping_figure(
        inputs.psd["frequency"].to_numpy(), panels("equivalent_damping"), panels("apparent_mass")
    )
    caption = "Equivalent damping and apparent mass used for these responses."
    return Picture(f"damping_{family.key}", style.png(figure), caption)


def _damping_curve(
    inputs: Inputs, family: ReportedFamily, reading: str, scenario: ReportedScenario, quantity: str
) -> PsdCurve:
    selection = {"reading": reading, "scenario": scenario.label, "patch": scenario.patch}
    values = inputs.psd[quantity].sel(selection).to_numpy()
    inside = inside_of(inputs.psd, reading, scenario.label)
    label, colour = _known_as(inputs, family, scenario)
    return PsdCurve(label, values, colour, inside, 1.1)
