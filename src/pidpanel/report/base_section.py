"""Base motion on the page: transmissibility, PSDs, effective masses, notches, the sine sweep."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import html, style
from pidpanel.report.base_figures import charts_figure
from pidpanel.report.inputs import BaseResults
from pidpanel.report.text import READINGS, common_decimals, number, percent, records, value_text
from pidpanel.solve.mesh_error import decibels

MODES_SHOWN = 12  # modes with the largest effective masses in the table

# Effective mass over that of the panel below which a mode does not move with the supports.
LEAST_SHARE = 1e-6

# Relative difference of amplitudes of the two sweeps from which there are several motions.
SAME_MOTION = 0.01

Names = Mapping[str, str]  # names of the scenarios by label, without a sound level

# First columns of the tables.
SCENARIO: Mapping[str, html.Cell] = {
    "scenario": lambda row: row["name"],
    "damping model": lambda row: READINGS[row["reading"]],
}


def base_section(
    base: BaseResults, names: Names, points: Sequence[str], thickness_mm: float
) -> html.PageSection:
    """Return the section of base motion on a panel of a thickness [mm]."""
    blocks: list[html.Block] = []
    for table, column in (
        (base.summary, "relative_displacement_rms_mm"),
        (base.peaks, "peak_relative_displacement_mm"),
    ):
        largest = 0.0 if table is None else float(table[column].max())
        if largest > thickness_mm / 10:
            motion = "random motion" if table is base.summary else "the sine sweep"
            text = f"Caution: displacements reach {number(largest)} mm in {motion}. Linear plate "
            text += (
                f"theory holds to about {number(thickness_mm / 10)} mm, a tenth of the thickness."
            )
            blocks.append(html.Paragraph(text))
    if base.summary is not None and base.psd is not None:
        good = base.summary[base.summary["status"] == "ok"]
        blocks += [html.Paragraph(_of_random(base, good)), _summary_table(good, names, points)]
        blocks += _folded(_random_pictures(base.psd, names, points))
    if base.notched is not None:
        blocks.append(_notch_table(base.notched, names))
    if base.sine is not None and base.peaks is not None:
        blocks += [html.Paragraph(_of_sine(base.sine, names)), _peak_table(base.peaks, names)]
        blocks += _folded(_sine_pictures(base.sine, names, points))
    return html.PageSection("base", "Base motion", [*blocks, _mode_table(base.modes)])


def base_facts(base: BaseResults) -> list[tuple[str, str]]:
    """Return the motions, and how good the basis is under them."""
    facts = []
    if base.psd is not None and base.summary is not None:
        f, level = base.psd["frequency"], base.summary["input_rms_g"].max()
        says = f"random, {level:.3g} g rms, {f[0]:g} to {f[-1]:g} Hz, {f.size} lines"
        facts.append(("Base motion", says))
    if base.sine is not None:
        f, level = base.sine["frequency"], base.sine.attrs["acceleration_g"]
        says = f"sine sweep, {level:g} g, {f[0]:g} to {f[-1]:g} Hz, {f.size} lines, up and down"
        facts.append(("Base motion", says))
    rows = base.summary if base.summary is not None else base.peaks
    if rows is not None:
        says = "its shift of resonances changes a PSD by at most "
        says += f"{number(decibels(rows['mesh_error'].max()), 2)} dB at any line"
        facts.append(("Mesh on the shaker", says))
    curves = base.psd if base.psd is not None else base.sine
    if curves is not None:
        error = percent(float(curves.attrs["basis_error"]), 2)
        says = f"at most {error} of the largest PSD of a point is missing under base motion, at "
        facts.append(("Basis on the shaker", f"{says}lines that were also solved on all elements"))
    return facts


def _of_random(base: BaseResults, good: pd.DataFrame) -> str:
    level = good["input_rms_g"].max()
    text = (
        f"All supports move along the normal with {level:.3g} g rms, the panel in vacuum. "
        "Accelerations are absolute, displacements relative to the supports."
    )
    if base.notched is not None:
        text += (
            " The notched input keeps all limits at the motion it leads to. Each scenario has its "
            "own, line by line in base/notched.csv."
        )
    return text


def _summary_table(good: pd.DataFrame, names: Names, points: Sequence[str]) -> html.Table:
    """Return g rms, displacement and force of each scenario, by input."""
    decimals = common_decimals(good["acceleration_rms_error_g"])
    force_decimals = common_decimals(good["interface_force_rms_error_n"])

    def acceleration(point: str) -> html.Cell:
        value, error = "acceleration_rms_g", "acceleration_rms_error_g"
        return lambda row: value_text(row[point][value], row[point][error], decimals)

    rows = []
    for (reading, scenario, level), group in good.groupby(
        ["reading", "scenario", "input"], sort=False
    ):
        by_point: dict[str, Any] = {row["point"]: row for row in records(group)}
        first = by_point[points[0]]
        beyond = " ‡" * bool(first["outside_run_points_share"] > 0)
        about = {"name": names[str(scenario)] + beyond, "reading": reading, "input": level}
        displacement = group["relative_displacement_rms_mm"].max()
        rows.append({**first, **by_point, **about, "displacement": displacement})
    return html.table_of(
        rows,
        "Random base motion: rms of the absolute acceleration at the points, the largest of their "
        "relative displacements, and the force of all supports. ±: one standard error from the "
        "damping. ‡ partly outside the range of the damping's data.",
        {
            **SCENARIO,
            "input, g rms": lambda row: f"{row['input']}, {row['input_rms_g']:.2f}",
            **{f"{point}: g rms": acceleration(point) for point in points},
            "displacement, mm rms": lambda row: number(row["displacement"]),
            "interface force, N rms": lambda row: value_text(
                row["interface_force_rms_n"], row["interface_force_rms_error_n"], force_decimals
            ),
        },
    )


def _curves(
    values: xr.DataArray, names: Names, error: xr.DataArray | None = None
) -> list[html.PageCurve]:
    """Return a curve (n_lines,) per scenario: the bare panel black, others in colours."""
    curves = []
    for index, label in enumerate(values["scenario"].to_numpy().tolist()):
        curve = values.sel(scenario=label).to_numpy()
        if not np.isfinite(curve).all():  # C_e is negative
            continue
        colour = style.PLACES[(index - 1) % len(style.PLACES)] if index else style.BARE
        drawn = html.PageCurve(names[label], curve, colour)
        if error is not None and bool(error.sel(scenario=label).notnull().all()):
            drawn = replace(drawn, log_error=error.sel(scenario=label).to_numpy())
        curves.append(drawn)
    return curves


def _picture(name: str, caption: str, charts: Sequence[html.Chart]) -> html.Picture:
    return html.Picture(f"base_{name}", style.Drawing(charts_figure, charts), caption, charts)


def _folded(pictures: Iterator[html.Picture]) -> list[html.Block]:
    """Return the first picture, and the others behind a title."""
    first, *others = pictures
    return [first, html.Fold("Further points and the interface", others)]


def _random_pictures(
    psd: xr.Dataset, names: Names, points: Sequence[str]
) -> Iterator[html.Picture]:
    """Yield transmissibility and PSD by point, then interface force and input."""
    f, reading = psd["frequency"].to_numpy(), str(psd["reading"].to_numpy()[0])
    shown = psd.sel(reading=reading)
    stated, square_g = shown.sel(input="stated"), STANDARD_GRAVITY**2
    for point in points:
        response = stated["absolute_acceleration_psd"].sel(point=point)
        error = stated["log_error"].sel(point=point)
        gain = _curves((response / stated["input_psd"]) ** 0.5, names)
        densities = _curves(response / square_g, names, error)
        charts = [
            html.Chart("transmissibility", f, "acceleration over that of the supports", gain),
            html.Chart("absolute acceleration", f, "acceleration PSD, g²/Hz", densities),
        ]
        caption = f"Random base motion at point {point}, stated input; {READINGS[reading]}."
        yield _picture(point, caption, charts)
    inputs = _curves(shown["input_psd"].sel(input="notched") / square_g, names)
    level = _curves(stated["input_psd"] / square_g, names)[0]
    inputs.append(replace(level, label="stated input", colour="#777777", line="dashed"))
    charts = [
        html.Chart(
            "force",
            f,
            "force PSD, N²/Hz",
            _curves(stated["interface_force_psd"], names, stated["force_log_error"]),
        ),
        html.Chart("input", f, "acceleration PSD, g²/Hz", inputs),
    ]
    caption = f"Force of all supports under the stated input, and inputs; {READINGS[reading]}."
    yield _picture("interface", caption, charts)


def _notch_table(notched: pd.DataFrame, names: Names) -> html.Table:
    """Return the bands in which one limit lowers the input."""
    lowered = notched[notched["reason"] != ""]
    place = lowered[["reading", "scenario", "reason"]]
    start = place.ne(place.shift()).any(axis=1) | (lowered.index.to_series().diff() != 1)
    rows = []
    for _, band in lowered.groupby(start.cumsum()):
        deepest = max(records(band), key=lambda row: row["notch_db"])
        lower, *_, upper = band["frequency_hz"].tolist() * 2
        rows.append({**deepest, "lower": lower, "upper": upper, "name": names[deepest["scenario"]]})
    return html.table_of(
        rows,
        "Notches: bands in which a limit lowers the input, the deepest line of each, and the "
        "limit. A limit of an overall value caps the highest peaks of the PSD there.",
        {
            **SCENARIO,
            "from, Hz": lambda row: number(row["lower"]),
            "to, Hz": lambda row: number(row["upper"]),
            "deepest at, Hz": lambda row: number(row["frequency_hz"]),
            "depth, dB": lambda row: f"{row['notch_db']:.1f}",
            "limit": lambda row: row["reason"],
        },
        folded=True,
        title=f"Notches ({len(rows)})",
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


def _peak_table(peaks: pd.DataFrame, names: Names) -> html.Table:
    """Return the peaks of the sweeps, up and down in one cell where they differ."""
    up, down = (records(peaks[peaks["direction"] == way]) for way in ("up", "down"))

    def both(column: str, error: str = "") -> html.Cell:
        return lambda row: " / ".join(
            dict.fromkeys(
                value_text(sweep[column], sweep.get(error, math.nan))
                for sweep in (row, row["down"])
            )
        )

    rows = [
        {**row, "down": returned, "name": names[row["scenario"]]}
        for row, returned in zip(up, down, strict=True)
    ]
    return html.table_of(
        rows,
        "Sine sweep: peaks at the points and of the interface force; up / down where they differ. "
        "±: one standard error from the damping.",
        {
            **SCENARIO,
            "point": lambda row: row["point"],
            "peak, g": both("peak_acceleration_g", "peak_acceleration_error_g"),
            "at, Hz": both("peak_frequency_hz"),
            "transmissibility": both("peak_transmissibility"),
            "displacement, mm": both("peak_relative_displacement_mm"),
            "interface force, N": both("peak_interface_force_n", "peak_interface_force_error_n"),
        },
        folded=True,
        title="Peaks of the sine sweep",
    )


def _sine_pictures(sine: xr.Dataset, names: Names, points: Sequence[str]) -> Iterator[html.Picture]:
    """Yield amplitudes at the points and of the interface force, two at a time."""
    f, reading = sine["frequency"].to_numpy(), str(sine["reading"].to_numpy()[0])
    shown, jumps = sine.sel(reading=reading), [names[label] for label in _with_jumps(sine)]
    values = {
        f"point {p}": (
            shown["acceleration"].sel(point=p) / STANDARD_GRAVITY,
            shown["acceleration_log_error"].sel(point=p),
        )
        for p in points
    }
    force = shown["interface_force"], shown["interface_force_log_error"]
    charts = []
    for title, (amplitude, error) in {**values, "interface force": force}.items():
        up, down = (
            _curves(amplitude.sel(direction=way), names, error.sel(direction=way))
            for way in ("up", "down")
        )
        differing = [curve for curve in down if curve.label in jumps]
        dotted = [replace(c, label=f"{c.label}, down", line="dotted") for c in differing]
        unit = f"amplitude, {'g' if title in values else 'N'}"
        charts.append(html.Chart(title, f, unit, [*up, *dotted]))
    caption = (
        f"Sine sweep: amplitudes of absolute accelerations and force; {READINGS[reading]}. Bands: "
        "one standard error from the damping."
    )
    for start in range(0, len(charts), 2):
        yield _picture(f"sine_{start}", caption, charts[start : start + 2])


def _mode_table(modes: pd.DataFrame) -> html.Table:
    """Return the modes with the largest effective masses."""
    moved = modes[modes["effective_mass_share"] > LEAST_SHARE]
    heaviest = moved.nlargest(MODES_SHOWN, "effective_mass_kg").sort_values("frequency_hz")
    total = modes["cumulative_share"].iloc[-1]
    return html.table_of(
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
