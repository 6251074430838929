"""Families of scenarios on the page: PSDs, reductions, the damping behind them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.report import figures, findings, style, tables
from pidpanel.report.figures import Curve, Panel
from pidpanel.report.html import Block, Paragraph, Picture, Section
from pidpanel.report.inputs import Inputs
from pidpanel.response.bands import reduction
from pidpanel.study import Scenario

EQUIVALENT_SINE = (
    "Γ = √2 a_rms/g of the patch, the sine of equal rms, is an assumption; C_e of a single tone "
    "read under broadband motion overstates the damping."
)

BANDS = "Bands: one standard error by that of C_e and m_a, where they have one. "


def response_section(inputs: Inputs, name: str) -> Section:
    """One family of scenarios: PSDs at every point, band reductions, the damping behind them."""
    study, psd = inputs.study, inputs.psd
    title = study.scenarios[name].title or f"Scenarios: {name}"
    readings = stable_readings(inputs, name)
    if not readings:
        text = "No reading of the damping gives a steady response: C_e is negative."
        return Section(f"response-{name}", title, [Paragraph(text)])
    frequency = psd["frequency"].to_numpy()
    text = level_text(inputs, name, readings)
    blocks: list[Block] = []
    for point in study.panel.points:
        panels = [
            Panel(
                tables.READINGS[reading],
                level_note(inputs, name, reading),
                psd_curves(inputs, name, reading, point),
            )
            for reading in readings
        ]
        caption = (
            f"{title}: acceleration PSD at point {point}, one-sided. Steps lie at the edges of the "
            f"sound's bands. {BANDS}{text}"
        )
        figure = figures.psd_figure(frequency, panels)
        blocks.append(Picture(f"psd_{name}_{point}", style.png(figure), caption))
    blocks.append(reduction_block(inputs, name, readings))
    blocks.append(damping_block(inputs, name, readings, text))
    return Section(f"response-{name}", title, blocks)


def stable_readings(inputs: Inputs, name: str) -> list[str]:
    """Readings in which every scenario of a family has a response."""
    labels = [s.label for s in inputs.study.family_scenarios(name)]
    psd = inputs.psd["acceleration_psd"]
    return [
        reading
        for reading in inputs.study.damping.readings
        if bool(np.isfinite(psd.sel(reading=reading, scenario=labels)).all())
    ]


def _known_as(inputs: Inputs, name: str, scenario: Scenario) -> tuple[str, str]:
    """What a scenario is called within its family, and its colour."""
    study = inputs.study
    varied = study.scenarios[name].varied
    if varied == "fill_fraction":
        return f"r = {scenario.fill_fraction:g}", style.fill_colour(scenario.fill_fraction)
    if varied == "patch":
        place = str(scenario.patch)
        return place, style.place_colour(place, list(study.panel.patches))
    levels = [s.oaspl_db or 0.0 for s in study.family_scenarios(name)]
    level = scenario.oaspl_db or 0.0
    return f"{level:g} dB", style.level_colour(level, levels)


def _inside(inputs: Inputs, reading: str, label: str) -> Flags:
    inside = inputs.psd["inside"].sel(reading=reading, scenario=label).to_numpy()
    return np.asarray(inside > 0.5)


def psd_curves(inputs: Inputs, name: str, reading: str, point: str) -> list[Curve]:
    """The bare panel at each level of a family, then its scenarios, (m/s²)²/Hz."""
    scenarios = inputs.study.family_scenarios(name)
    psd = inputs.psd["acceleration_psd"].sel(reading=reading, point=point)
    bare = list(dict.fromkeys(s.bare.label for s in scenarios))
    called = "bare panel" if len(bare) == 1 else "bare panel at these levels"
    curves = [
        Curve(called, psd.sel(scenario=label).to_numpy(), style.BARE, width=0.8) for label in bare
    ]
    for scenario in scenarios:
        label, colour = _known_as(inputs, name, scenario)
        values = psd.sel(scenario=scenario.label).to_numpy()
        error = _log_error(inputs, reading, scenario.label, point)
        inside = _inside(inputs, reading, scenario.label)
        curves.append(Curve(label, values, colour, inside, log_error=error))
    return curves


def _log_error(inputs: Inputs, reading: str, label: str, point: str) -> Array | None:
    """Standard error of ln of a PSD by that of its damping; None where it has none."""
    if "acceleration_psd_log_error" not in inputs.psd:
        return None
    of = inputs.psd["acceleration_psd_log_error"]
    error = of.sel(reading=reading, scenario=label, point=point).to_numpy()
    return error if np.isfinite(error).all() else None


def _levels(inputs: Inputs, name: str, reading: str) -> dict[str, float]:
    """Γ at which the damping of each scenario of a family was read; NaN for none."""
    of = inputs.summary[inputs.summary["reading"] == reading].drop_duplicates("scenario")
    read_at = of.set_index("scenario")["damping_read_at_g"]
    return {
        _known_as(inputs, name, s)[0]: float(read_at[s.label])
        for s in inputs.study.family_scenarios(name)
    }


def level_note(inputs: Inputs, name: str, reading: str) -> str:
    """One line under the title of the axes: at which Γ the damping was read."""
    levels = np.array(list(_levels(inputs, name, reading).values()))
    if np.isnan(levels).all():
        return "knows no Γ: $C_e$ is the same at every level"
    kind = (
        "the patch's own motion" if inputs.study.damping.level.kind == "patch" else "a stated level"
    )
    low, high = tables.number(levels.min()), tables.number(levels.max())
    return f"$C_e$ read at {kind}, Γ = {low}" + (f" to {high}" if high != low else "")


def level_text(inputs: Inputs, name: str, readings: Sequence[str]) -> str:
    """What a caption says of the levels, the dashes and the readings left out."""
    parts = []
    for reading in readings:
        levels = _levels(inputs, name, reading)
        if all(np.isnan(level) for level in levels.values()):
            parts.append(f"{tables.READINGS[reading]}: knows no Γ.")
            continue
        kind = inputs.study.damping.level.kind
        at = "the patch's own motion" if kind == "patch" else "a stated level"
        each = ", ".join(f"{tables.number(level)} ({known})" for known, level in levels.items())
        parts.append(
            f"{tables.READINGS[reading]}: C_e read at {at} (level.kind: {kind}), Γ = {each}. "
            f"{EQUIVALENT_SINE}"
        )
        labels = [s.label for s in inputs.study.family_scenarios(name)]
        if not all(_inside(inputs, reading, label).all() for label in labels):
            parts.append("Dashed lines: that Γ or frequency lies outside the run points.")
    for reading in inputs.study.damping.readings:
        if reading not in readings:
            parts.append(f"{tables.READINGS[reading]}: not drawn, C_e feeds the panel.")
    return " ".join(parts)


def reduction_block(inputs: Inputs, name: str, readings: Sequence[str]) -> Picture:
    """Third-octave reductions of a family as maps."""
    study = inputs.study
    scenarios = study.family_scenarios(name)
    points = list(study.panel.points)
    gained = {}
    centre = np.empty(0)
    for reading in readings:
        labels, bare = [s.label for s in scenarios], [s.bare.label for s in scenarios]
        centre, treated = findings.scenario_band_rms(inputs.psd, reading, labels, points)
        _, untreated = findings.scenario_band_rms(inputs.psd, reading, bare, points)
        for number, point in enumerate(points):
            gained[point, tables.READINGS[reading]] = reduction(untreated, treated)[..., number]
    row_name = {
        "fill_fraction": "fill fraction r",
        "patch": "patch",
        "oaspl_db": "sound, dB",
    }[study.scenarios[name].varied]
    rows = [
        _known_as(inputs, name, s)[0].removeprefix("r = ").removesuffix(" dB") for s in scenarios
    ]
    figure = figures.reduction_figure(
        centre, rows, gained, points, [tables.READINGS[r] for r in readings], row_name
    )
    caption = (
        "Reduction of the rms acceleration in third octaves against the bare panel under the same "
        "sound, dB; positive (blue) is less. Read at the levels of the PSDs above; where those are "
        "dashed, these numbers rest on damping outside the run points."
    )
    return Picture(f"reduction_{name}", style.png(figure), caption)


def damping_block(inputs: Inputs, name: str, readings: Sequence[str], text: str) -> Picture:
    """C_e and m_a with which a family was computed."""
    damping, mass = [], []
    for reading in readings:
        above, below = [], []
        for scenario in inputs.study.family_scenarios(name):
            label, colour = _known_as(inputs, name, scenario)
            one = inputs.psd.sel(reading=reading, scenario=scenario.label)
            inside = _inside(inputs, reading, scenario.label)
            above.append(Curve(label, one["equivalent_damping"].to_numpy(), colour, inside, 1.1))
            below.append(Curve(label, one["apparent_mass"].to_numpy(), colour, inside, 1.1))
        title, note = tables.READINGS[reading], level_note(inputs, name, reading)
        damping.append(Panel(title, note, above))
        mass.append(Panel(title, note, below))
    figure = figures.damping_figure(inputs.psd["frequency"].to_numpy(), damping, mass)
    caption = (
        f"Equivalent damping and apparent mass with which these responses were computed. {text}"
    )
    return Picture(f"damping_{name}", style.png(figure), caption)
