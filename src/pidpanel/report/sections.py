"""The order of the page: what is shown, and what each caption says of it.

Every function takes what has been read and returns blocks of the page; the numbers in the
texts come from the same frames as the figures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from pidpanel.damping.laws import paper_corrected
from pidpanel.panel.modes import PanelBasis
from pidpanel.report import (
    figures,
    findings,
    maps,
    panel,
    pictures,
    radiation,
    stress,
    style,
    tables,
)
from pidpanel.report.damping_section import DampingResults, damping_section
from pidpanel.report.evidence import Beads
from pidpanel.report.figures import Curve, Panel, Record
from pidpanel.report.html import Block, Page, Paragraph, Picture, Section, Table
from pidpanel.report.losses import losses_picture
from pidpanel.response.bands import reduction
from pidpanel.study import Scenario, Study

Array = NDArray[np.float64]

EQUIVALENT_SINE = (
    "Γ = √2 a_rms/g of the patch, the sine of equal rms, is an assumption; C_e of a single tone "
    "read under broadband motion overstates the damping."
)

OVERSTATED = (
    "C_e and m_a come from coupons shaken by one tone at a time. The panel moves at all "
    "frequencies at once, and a bed kept loose by the low ones dissipates less at the high ones: "
    "driven at random (10 g rms flat from 20 to 2000 Hz; one measurement on 600 spheres, not at "
    "the levels met here) C_e came out about 6 times lower at 2 kHz than from single tones of "
    "about that level. So the damping of the reading DEM is overstated, most of all at high "
    "frequency. The level is that of the sine with the patch's rms acceleration over the whole "
    "spectrum, Γ = √2 a_rms/g, which is an assumption of its own."
)

BANDS = "Bands: one standard error by that of C_e and m_a, where they have one. "


@dataclass(frozen=True)
class Coupon:
    """What the coupon stage left: cases, cycles of a few, the spheres of one."""

    cases: pd.DataFrame
    records: Sequence[Sequence[Record]]
    beads: Beads


@dataclass(frozen=True)
class Inputs:
    """All that the page is made from.

    Attributes
    ----------
    study, stamp
        The study, and what its results are stamped with.
    summary, psd
        ``response/summary.csv`` (points as text), ``response/psd.nc``.
    modes, basis, section
        ``panel/modes.csv``, ``panel/modes.nc``, ``panel/section.csv``.
    bands
        ``sound/spectrum.csv``.
    printed
        Table 1 of the paper.
    coupon
        None for a study without a coupon.
    stress
        ``response/stress.csv`` (points as text).
    radiation
        ``response/radiation.csv`` (points as text); None where nothing was asked beside.
    maps
        ``response/maps.nc``.
    damping
        None for a study that does not read its own cases.
    """

    study: Study
    stamp: Mapping[str, str]
    summary: pd.DataFrame
    psd: xr.Dataset
    modes: pd.DataFrame
    basis: PanelBasis
    section: pd.DataFrame
    bands: pd.DataFrame
    printed: pd.DataFrame
    coupon: Coupon | None
    stress: pd.DataFrame
    radiation: pd.DataFrame | None = None
    maps: xr.Dataset | None = None
    damping: DampingResults | None = None


def page(inputs: Inputs, steps: Sequence[tuple[str, str]]) -> Page:
    """The whole report."""
    study = inputs.study
    sections = [
        panel.panel_section(study, inputs.basis, inputs.modes, inputs.section, inputs.printed),
        sound_section(inputs),
    ]
    if inputs.coupon is not None:
        sections.append(coupon_section(study, inputs.coupon))
    if inputs.damping is not None:
        sections.append(damping_section(inputs.damping))
    sections += [response_section(inputs, name) for name in study.scenarios]
    if inputs.radiation is not None:
        sections.append(
            radiation.radiation_section(
                inputs.summary,
                inputs.radiation,
                study.response.radiation,
                list(study.panel.points),
                tables.READINGS,
            )
        )
    if inputs.maps is not None:
        sections.append(maps.map_section(inputs.maps, inputs.basis.cell_in_patch, tables.READINGS))
    sections.append(summary_section(inputs))
    return Page(
        title=study.title or study.name,
        facts=facts(inputs),
        assumptions=study.assumptions,
        summary=findings.outcome(study, inputs.summary, tables.READINGS),
        warnings=warnings(inputs),
        claims=tables.verdict_table(
            findings.verdicts(
                study, inputs.summary, inputs.psd, findings.patch_distance(inputs.basis)
            )
        ),
        sections=sections,
        steps=steps,
    )


def warnings(inputs: Inputs) -> list[str]:
    """Where the numbers must not be trusted, most important first."""
    said = findings.response_warnings(inputs.study, inputs.summary, inputs.psd, tables.READINGS)
    if inputs.summary["damping_read_at_g"].notna().any():
        said.append(OVERSTATED)
    if inputs.radiation is not None:
        both = radiation.compared(inputs.summary, inputs.radiation)
        own, points = inputs.study.response.radiation, list(inputs.study.panel.points)
        said.append(radiation.finding(both, own, points))
    if inputs.damping is not None:
        said += findings.target_warnings(inputs.damping.rounds)
    if inputs.coupon is not None:
        said += findings.coupon_warnings(inputs.coupon.cases)
    return said


def facts(inputs: Inputs) -> list[tuple[str, str]]:
    """What was computed and with what."""
    study, stamp = inputs.study, inputs.stamp
    low, high = study.response.frequency_hz
    good = inputs.summary[inputs.summary["status"] == "ok"]
    level = study.damping.level
    read_at = (
        "the motion of the patch itself (level.kind: patch)"
        if level.kind == "patch"
        else f"a stated Γ = {level.acceleration_g:g} (level.kind: stated)"
    )
    rows = [
        ("Panel", panel.panel_text(study, inputs.basis, inputs.section)),
        (
            "Sound",
            f"{study.sound.field} field, {study.sound.spectrum.name}, "
            + (f"{study.sound.oaspl_db:g} dB overall, " if study.sound.oaspl_db else "")
            + f"pressure reference: {study.sound.pressure_reference}",
        ),
        (
            "Response",
            f"{low:g} to {high:g} Hz, {inputs.psd.sizes['frequency']} lines; "
            f"{study.response.modal_damping} modal damping matrix; apparent mass of the damper "
            + ("acts" if study.response.damper_mass else "left out"),
        ),
        ("Damping", ", ".join(tables.READINGS[r] for r in study.damping.readings)),
        ("C_e(r, f, Γ) read at", read_at),
        (
            "Power balance",
            f"put in and lost agree within {tables.number(good['power_balance_error'].max(), 2)} "
            "of the power put in, in every scenario",
        ),
    ]
    if inputs.coupon is not None:
        cases = inputs.coupon.cases
        rows.append(
            ("Coupon", f"{len(cases)} cases, {int((cases['status'] == 'ok').sum())} of them ok")
        )
    rows.append(
        (
            "Made by",
            f"pidpanel {stamp['pidpanel_version']}, LIGGGHTS {stamp['liggghts_version']}; "
            f"study {stamp['study']}, hash {stamp['study_hash']}",
        )
    )
    return rows


# --------------------------------------------------------------------------- sound


def sound_section(inputs: Inputs) -> Section:
    """Band levels and PSD."""
    low, high = inputs.study.response.frequency_hz
    sound = inputs.study.sound
    level = 10 * np.log10(np.sum(10 ** (inputs.bands["band_spl_db"] / 10)))
    caption = (
        f"The sound as it was put in: {sound.spectrum.name}, {level:.1f} dB overall. Its shape is "
        "an assumption where the source gives none (the paper's Fig. 2 is not recoverable). The "
        "PSD is constant in each band and integrates back to its level. Grey: outside the "
        "response's frequencies."
    )
    figure = figures.spectrum_figure(inputs.bands, low, high)
    return Section("sound", "Sound", [Picture("spectrum", _drawn(figure), caption)])


# --------------------------------------------------------------------------- coupon


def coupon_section(study: Study, coupon: Coupon) -> Section:
    """The spheres, how steady the runs are, and what came out of them."""
    cases = coupon.cases
    good = cases[cases["status"] == "ok"].copy()
    mass = good["particle_mass_per_area_kg_m2"]
    good["apparent_mass_share"] = good["apparent_mass_kg_m2"] / mass
    good["apparent_mass_share_error"] = good["apparent_mass_error_kg_m2"] / mass
    relative = good["equivalent_damping_error_n_s_m3"] / good["equivalent_damping_n_s_m3"].abs()
    law = paper_corrected if "paper_corrected" in study.damping.readings else None
    law_text = (
        " Dashed: the paper's law, corrected (|a₁|, f in Hz), which knows no Γ." if law else ""
    )
    bound_text = (
        " Dotted: C_e = 4 m″ω/π, the most that a perfectly inelastic bed of this mass without "
        "gravity can give."
    )
    bars = (
        "Bars: one standard error, from the scatter of the cycles and between seeds. Cases that "
        "are not ok are left out."
    )
    F, G = figures.FREQUENCY, figures.LEVEL
    drawn: list[tuple[str, Any, str]] = [
        (
            "damping_over_frequency",
            figures.sweep_figure(
                good, F, figures.EQUIVALENT_DAMPING, G, law=law, bound="bound_n_s_m3"
            ),
            f"Equivalent damping per area over frequency at constant Γ. {bars}{law_text}"
            f"{bound_text}",
        ),
        (
            "damping_over_level",
            figures.sweep_figure(
                good, G, figures.EQUIVALENT_DAMPING, F, law=law, bound="bound_n_s_m3"
            ),
            f"The same over the acceleration amplitude at constant frequency. {bars}{law_text}"
            f"{bound_text}",
        ),
        (
            "loss_factor",
            figures.sweep_figure(good, G, figures.LOSS_FACTOR, F),
            "Loss factor η = E_d/(π m″(ωW)²) over the acceleration amplitude; the inelastic bound "
            f"is 4/π = 1.27. {bars}",
        ),
        (
            "apparent_mass",
            figures.sweep_figure(good, G, figures.MASS_SHARE, F),
            "Share of the spheres' mass that moves in phase with the cell (apparent mass over "
            f"mass, both per area). {bars}",
        ),
    ]
    blocks: list[Block] = [
        Paragraph(
            f"{len(cases)} cases, {len(good)} of them ok; the median standard error of C_e is "
            f"{relative.median():.1%}, the largest {relative.max():.0%}."
        ),
        beads_block(coupon.beads),
        Picture(
            "steadiness",
            _drawn(figures.steadiness_figure(coupon.records)),
            "Energy dissipated per cycle and area in a few runs, cycle by cycle. Dotted: end of "
            "the transient, found from the data (marginal standard error); band: mean of the "
            "cycles after it ± one standard error (blocking).",
        ),
        *(Picture(name, _drawn(figure), caption) for name, figure, caption in drawn),
        *([losses] if (losses := losses_picture(good)) else []),
        tables.case_table(cases),
    ]
    return Section("coupon", "Coupon", blocks)


def beads_block(beads: Beads) -> Picture:
    """Picture of the spheres of one run in their cells."""
    packing = beads.run.packing
    limits = (0.0, float(beads.speed.max()))
    shape = {"hexagon": "hexagonal", "square": "square", "circle": "round"}[packing.shape]
    where = (
        f"{len(beads.positions)} spheres of {packing.diameter * 1e3:g} mm in {packing.count} "
        f"{shape} cells of {packing.across_flats * 1e3:g} mm × {packing.depth * 1e3:g} mm (set "
        f"side by side for the picture), r = {beads.run.fill_fraction:g}, "
        f"{beads.run.frequency:g} Hz, "
        f"Γ = {beads.run.acceleration / figures.STANDARD_GRAVITY:.4g} ({beads.label})."
    )
    caption = f"{where} State after {beads.cycles} cycles; colour: speed relative to the cell."
    image = pictures.beads_picture(
        beads.positions,
        beads.diameters,
        beads.speed,
        limits,
        outline=packing.outline,
        across_flats=packing.across_flats,
        depth=packing.depth,
        count=packing.count,
    )
    figure = figures.pictures_figure(
        [image],
        [""],
        columns=1,
        colormap="plasma",
        limits=limits,
        label="speed relative to the cell, m/s",
        width=6.0,
    )
    return Picture("beads", _drawn(figure), caption)


# --------------------------------------------------------------------------- response


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
        blocks.append(Picture(f"psd_{name}_{point}", _drawn(figure), caption))
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


def _inside(inputs: Inputs, reading: str, label: str) -> NDArray[np.bool_]:
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
    return Picture(f"reduction_{name}", _drawn(figure), caption)


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
    return Picture(f"damping_{name}", _drawn(figure), caption)


def summary_section(inputs: Inputs) -> Section:
    """All scenarios and points: accelerations, then strain and stress."""
    study = inputs.study
    labels = [s.label for s in study.all_scenarios()]
    table: Table = tables.response_table(inputs.summary, labels, list(study.panel.points))
    strained = stress.stress_table(inputs.stress, tables.READINGS)
    return Section("summary", "All scenarios", [table, strained])


def _drawn(figure: figures.Figure) -> bytes:
    return style.png(figure)
