"""Base motion on the page: transmissibility, PSDs, effective masses, notches, the sine sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.base_figures import charts_figure
from pidpanel.report.html import (
    Block,
    Chart,
    Fold,
    PageCurve,
    PageSection,
    Paragraph,
    Picture,
    Table,
    table_of,
)
from pidpanel.report.inputs import BaseResults
from pidpanel.report.text import READINGS, common_decimals, number, percent, records, value_text

MODES_SHOWN = 12
"""Modes with the largest effective masses in the table."""

SAME_MOTION = 0.01
"""Relative difference of amplitudes of the two sweeps from which there are several motions."""

Names = Mapping[str, str]
"""Names of the scenarios by label, without a sound level."""


def base_section(base: BaseResults, names: Names, points: Sequence[str]) -> PageSection:
    """Return the section of base motion."""
    blocks: list[Block] = []
    if base.summary is not None and base.psd is not None:
        good = base.summary[base.summary["status"] == "ok"]
        blocks += [Paragraph(_of_random(base, good)), _summary_table(good, names)]
        blocks += _random_pictures(base.psd, names, points)
    if base.notches is not None:
        blocks.append(_notch_table(base.notches, names))
    if base.sine is not None and base.peaks is not None:
        blocks += [Paragraph(_of_sine(base.sine, names)), _peak_table(base.peaks, names)]
        blocks += _sine_pictures(base.sine, names, points)
    return PageSection("base", "Base motion", [*blocks, _mode_table(base.modes)])


def _of_random(base: BaseResults, good: pd.DataFrame) -> str:
    level = good[good["input"] == "stated"]["input_rms_g"].iloc[0]
    text = (
        f"All supports move along the normal with {level:.3g} g rms, the panel in vacuum. "
        "Accelerations are absolute, displacements relative to the supports."
    )
    if base.notches is not None:
        text += (
            " The notched input keeps all limits at the motion it leads to. Each scenario has its "
            "own, line by line in base/notched.csv."
        )
    return text


def _summary_table(good: pd.DataFrame, names: Names) -> Table:
    """Return g rms, displacement and force of each scenario, by input."""
    decimals = common_decimals(good["acceleration_rms_error_g"])
    points = list(dict.fromkeys(good["point"]))[:-1]
    rows = []
    for (reading, scenario, level), group in good.groupby(
        ["reading", "scenario", "input"], sort=False
    ):
        *cells, interface = records(group)
        beyond = " ‡" * bool(interface["outside_run_points_share"] > 0)
        row = [names[str(scenario)] + beyond, READINGS[str(reading)]]
        row.append(f"{level}, {interface['input_rms_g']:.2f}")
        row += [
            value_text(cell["acceleration_rms_g"], cell["acceleration_rms_error_g"], decimals)
            for cell in cells
        ]
        row.append(number(max(cell["relative_displacement_rms_mm"] for cell in cells)))
        rows.append([*row, number(interface["force_rms_n"])])
    return Table(
        "Random base motion: rms of the absolute acceleration at the points, the largest of their "
        "relative displacements, and the force of all supports. ±: one standard error from the "
        "damping. ‡ partly outside the range of the damping's data.",
        [
            "scenario", "damping model", "input, g rms", *(f"{p}: g rms" for p in points),
            "displacement, mm rms", "interface force, N rms",
        ],
        rows,
    )  # fmt: skip


def _curves(values: xr.DataArray, names: Names, error: xr.DataArray | None = None) -> list[Any]:
    """Return a curve (n_lines,) per scenario: the bare panel black, the others in colours."""
    curves = []
    for index, label in enumerate(values["scenario"].to_numpy().tolist()):
        curve = values.sel(scenario=label).to_numpy()
        if not np.isfinite(curve).all():  # C_e is negative
            continue
        log_error = None if error is None else error.sel(scenario=label).to_numpy()
        if log_error is not None and not np.isfinite(log_error).all():
            log_error = None
        colour = style.PLACES[(index - 1) % len(style.PLACES)] if index else style.BARE
        curves.append(PageCurve(names[label], curve, colour, log_error=log_error))
    return curves


def _random_pictures(psd: xr.Dataset, names: Names, points: Sequence[str]) -> list[Block]:
    """Return transmissibility and PSD by point, then interface force and input."""
    f, reading = psd["frequency"].to_numpy(), str(psd["reading"].to_numpy()[0])
    stated, lowered = (psd.sel(reading=reading, input=name) for name in ("stated", "notched"))
    model, square_g = READINGS[reading], STANDARD_GRAVITY**2
    pictures = []
    for point in points:
        response = stated["absolute_acceleration_psd"].sel(point=point)
        error = stated["log_error"].sel(point=point)
        gain = (response / stated["input_psd"]) ** 0.5
        charts = [
            Chart("transmissibility", f, "|a/a_base|", _curves(gain, names)),
            Chart(
                "absolute acceleration", f, "acceleration PSD, g²/Hz",
                _curves(response / square_g, names, error),
            ),
        ]  # fmt: skip
        caption = f"Random base motion at point {point}, stated input; {model}."
        pictures.append(Picture(f"base_{point}", style.png(charts_figure(charts)), caption, charts))
    inputs = _curves(lowered["input_psd"] / square_g, names)
    level = replace(_curves(stated["input_psd"] / square_g, names)[0], label="stated input")
    charts = [
        Chart(
            "interface force", f, "force PSD, N²/Hz", _curves(stated["interface_force_psd"], names)
        ),
        Chart(
            "input", f, "acceleration PSD, g²/Hz",
            [*inputs, replace(level, colour="#777777", line="dashed")],
        ),
    ]  # fmt: skip
    caption = f"Force of all supports under the stated input, and the inputs; {model}."
    interface = Picture("base_interface", style.png(charts_figure(charts)), caption, charts)
    first, *others = pictures
    return [first, Fold("Further points", others), interface] if others else [first, interface]


def _notch_table(notches: pd.DataFrame, names: Names) -> Table:
    return table_of(
        records(notches),
        "Notches: bands in which a limit lowers the input, the deepest line of each, and the "
        "limit. A limit of an overall value caps the highest peaks of the PSD there.",
        {
            "scenario": lambda row: names[row["scenario"]],
            "damping model": lambda row: READINGS[row["reading"]],
            "from, Hz": lambda row: number(row["lower_hz"]),
            "to, Hz": lambda row: number(row["upper_hz"]),
            "deepest at, Hz": lambda row: number(row["deepest_hz"]),
            "depth, dB": lambda row: f"{row['depth_db']:.1f}",
            "limit": lambda row: row["reason"],
        },
        folded=True,
        title=f"Notches ({len(notches)})",
    )


def _with_jumps(sine: xr.Dataset) -> list[str]:
    """Return the scenarios whose sweeps up and down differ."""
    up, down = (sine["acceleration"].sel(direction=way) for way in ("up", "down"))
    apart = abs(up / down - 1).max(("reading", "frequency", "point")) > SAME_MOTION
    labels: list[str] = sine["scenario"].to_numpy()[apart.to_numpy()].tolist()
    return labels


def _of_sine(sine: xr.Dataset, names: Names) -> str:
    f, jumps = sine["frequency"].to_numpy(), [names[label] for label in _with_jumps(sine)]
    text = (
        f"A slow sine sweep from {f[0]:g} to {f[-1]:g} Hz at {sine.attrs['acceleration_g']:g} g, "
        "up and down. The damping is that of single tones at each frequency's own amplitude. "
    )
    if not jumps:
        return f"{text}Both directions give the same motion."
    return f"{text}Up and down differ with {', '.join(jumps)}: several motions are possible there."


def _peak_table(peaks: pd.DataFrame, names: Names) -> Table:
    """Return the peaks of the sweeps, up and down in one cell where they differ."""
    up, down = (records(peaks[peaks["direction"] == way]) for way in ("up", "down"))

    def both(column: str) -> Any:
        def text(pair: Mapping[str, Any]) -> str:
            texts = dict.fromkeys(number(row[column]) for row in (pair["up"], pair["down"]))
            return " / ".join(texts)

        return text

    return table_of(
        [{"up": row, "down": other} for row, other in zip(up, down, strict=True)],
        "Sine sweep: peaks at the points and of the interface force; up / down where they differ.",
        {
            "scenario": lambda pair: names[pair["up"]["scenario"]],
            "damping model": lambda pair: READINGS[pair["up"]["reading"]],
            "point": lambda pair: pair["up"]["point"],
            "peak, g": both("peak_acceleration_g"),
            "peak force, N": both("peak_force_n"),
            "at, Hz": both("peak_frequency_hz"),
            "transmissibility": both("peak_transmissibility"),
            "displacement, mm": both("peak_relative_displacement_mm"),
        },
        folded=True,
        title="Peaks of the sine sweep",
    )


def _sine_pictures(sine: xr.Dataset, names: Names, points: Sequence[str]) -> list[Block]:
    f, reading = sine["frequency"].to_numpy(), str(sine["reading"].to_numpy()[0])
    shown, jumps = sine.sel(reading=reading), [names[label] for label in _with_jumps(sine)]

    def chart(title: str, unit: str, values: xr.DataArray) -> Chart:
        """Return the sweeps up, and those down that differ."""
        up, down = (_curves(values.sel(direction=way), names) for way in ("up", "down"))
        differing = [curve for curve in down if curve.label in jumps]
        dotted = [replace(c, label=f"{c.label}, down", line="dotted") for c in differing]
        return Chart(title, f, unit, [*up, *dotted])

    charts = [
        chart(f"point {p}", "amplitude, g", shown["acceleration"].sel(point=p) / STANDARD_GRAVITY)
        for p in points
    ]
    charts.append(chart("interface force", "amplitude, N", shown["interface_force"]))
    caption = f"Sine sweep: amplitudes of absolute accelerations and force; {READINGS[reading]}."
    first, *others = [
        Picture(f"base_sine_{start}", style.png(charts_figure(pair)), caption, pair)
        for start in range(0, len(charts), 2)
        for pair in [charts[start : start + 2]]
    ]
    return [first, Fold("Further points and the interface force", others)] if others else [first]


def _mode_table(modes: pd.DataFrame) -> Table:
    """Return the modes with the largest effective masses."""
    heaviest = modes.nlargest(MODES_SHOWN, "effective_mass_kg").sort_values("frequency_hz")
    total = modes["cumulative_share"].iloc[-1]
    return table_of(
        records(heaviest),
        f"Effective masses of the bare panel along the normal: the {len(heaviest)} largest of "
        f"{len(modes)} modes, which have {percent(total, 1)} of the mass together. The rest is in "
        "higher modes and at the supports.",
        {
            "mode": lambda row: f"{row['mode']:.0f}",
            "frequency, Hz": lambda row: number(row["frequency_hz"], 4),
            "modal mass, kg": lambda row: number(row["modal_mass_kg"]),
            "effective mass, kg": lambda row: number(row["effective_mass_kg"]),
            "share": lambda row: percent(row["effective_mass_share"], 1),
            "sum to here": lambda row: percent(row["cumulative_share"], 1),
        },
    )
