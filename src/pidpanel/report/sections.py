"""The order of the page: what is shown, and what each caption says of it.

Every function takes what has been read and returns blocks of the page; the numbers in the
texts come from the same frames as the figures.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pidpanel.report import figures, findings, maps, panel, radiation, stress, style, tables
from pidpanel.report.coupon_section import coupon_section
from pidpanel.report.damping_section import damping_section
from pidpanel.report.html import Page, Picture, Section, Table
from pidpanel.report.inputs import Inputs
from pidpanel.report.response_section import response_section

OVERSTATED = (
    "C_e and m_a come from coupons shaken by one tone at a time. The panel moves at all "
    "frequencies at once, and a bed kept loose by the low ones dissipates less at the high ones: "
    "driven at random (10 g rms flat from 20 to 2000 Hz; one measurement on 600 spheres, not at "
    "the levels met here) C_e came out about 6 times lower at 2 kHz than from single tones of "
    "about that level. So the damping of the reading DEM is overstated, most of all at high "
    "frequency. The level is that of the sine with the patch's rms acceleration over the whole "
    "spectrum, Γ = √2 a_rms/g, which is an assumption of its own."
)


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
    return Section("sound", "Sound", [Picture("spectrum", style.png(figure), caption)])


def summary_section(inputs: Inputs) -> Section:
    """All scenarios and points: accelerations, then strain and stress."""
    study = inputs.study
    labels = [s.label for s in study.all_scenarios()]
    table: Table = tables.response_table(inputs.summary, labels, list(study.panel.points))
    strained = stress.stress_table(inputs.stress, tables.READINGS)
    return Section("summary", "All scenarios", [table, strained])
