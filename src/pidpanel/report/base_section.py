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
from pidpanel.report.answer_section import trust_text
from pidpanel.report.inputs import BaseResults
from pidpanel.report.response_figures import chart_picture, psd_unit
from pidpanel.report.text import common_decimals, records, value_text
from pidpanel.response.trust import doubts_in

MODES_SHOWN = 12  # modes with the largest effective masses in the table

# Effective mass over that of the panel below which a mode does not move with the supports.
LEAST_SHARE = 1e-6

# Relative difference of amplitudes of the two sweeps from which there are several motions.
SAME_MOTION = 0.01

# Value and error of each column of the peaks of a sweep.
PEAKS = {
    "acceleration": ("peak_acceleration_g", "peak_acceleration_error_g"),
    "frequency": ("peak_frequency_hz", ""),
    "transmissibility": ("peak_transmissibility", ""),
    "displacement": ("peak_relative_displacement_mm", ""),
    "force": ("peak_interface_force_n", "peak_interface_force_error_n"),
}

Names = Mapping[str, str]  # names of the scenarios by label, without a sound level


def base_section(
    base: BaseResults,
    names: Names,
    points: Sequence[str],
    thickness_mm: float,
    direction: str = "the normal",
) -> html.PageSection:
    """Return the section of base motion on a panel of a thickness [mm]."""
    random = sine = None
    pictures: list[html.Picture] = []
    sine_pictures: list[html.Picture] = []
    if base.summary is not None and base.psd is not None:
        random = _random_values(base.summary, names, points)
        pictures = list(_random_pictures(base.psd, names, points))
    if base.sine is not None and base.peaks is not None:
        sine = _sine_values(base.sine, base.peaks, names)
        sine_pictures = list(_sine_pictures(base.sine, names, points, has_svg=not pictures))
    first, *further = pictures or sine_pictures
    values = {
        "large": [(motion, mm) for motion, mm in _largest(base) if mm > thickness_mm / 10],
        "thickness": thickness_mm,
        "has_notches": base.notched is not None,
        "random": random,
        "sine": sine,
        "direction": direction,
    }
    moved = base.modes[base.modes["effective_mass_share"] > LEAST_SHARE]
    heaviest = moved.nlargest(MODES_SHOWN, "effective_mass_kg").sort_values("frequency_hz")
    rest = {
        "pictures": further,
        "direction": direction,
        "notches": None if base.notched is None else _notches(base.notched, names),
        "sine": sine if random else None,
        "sine_pictures": sine_pictures if random else [],
        "modes": records(heaviest),
        "mode_count": len(base.modes),
        "mode_share": base.modes["cumulative_share"].iloc[-1],
    }
    head, tail = html.Fragment("base.html", values), html.Fragment("base_more.html", rest)
    return html.PageSection("base", "Base motion", [head, first, tail])


def _largest(base: BaseResults) -> Iterator[tuple[str, float]]:
    """Yield the largest displacement [mm] of each motion."""
    if base.summary is not None:
        yield "random motion", base.summary["relative_displacement_rms_mm"].max()
    if base.peaks is not None:
        yield "the sine sweep", base.peaks["peak_relative_displacement_mm"].max()


def _random_values(summary: pd.DataFrame, names: Names, points: Sequence[str]) -> dict[str, Any]:
    """Return g rms, displacement and force of each scenario, by input."""
    good = summary[summary["status"] == "ok"]
    rows = []
    for (scenario, level), group in good.groupby(["scenario", "input"], sort=False):
        by_point = {row["point"]: row for row in records(group)}
        about: dict[str, Any] = {"name": names[str(scenario)], "input": level}
        about["trust"] = trust_text(doubts_in(records(group)[0]))
        about["displacement"] = group["relative_displacement_rms_mm"].max()
        about["by_point"] = {point: by_point[point] for point in points}
        rows.append({**by_point[points[0]], **about})
    return {
        "level": good["input_rms_g"].max(),
        "rows": rows,
        "decimals": common_decimals(good["acceleration_rms_error_g"]),
        "force_decimals": common_decimals(good["interface_force_rms_error_n"]),
    }


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


def _random_pictures(
    psd: xr.Dataset, names: Names, points: Sequence[str]
) -> Iterator[html.Picture]:
    """Yield transmissibility and PSD by point, then interface force and input."""
    f = psd["frequency"].to_numpy()
    stated, square_g = psd.sel(input="stated"), STANDARD_GRAVITY**2
    for point in points:
        at_point = stated.sel(point=point)
        response = at_point["absolute_acceleration_psd"]
        gain = _curves((response / stated["input_psd"]) ** 0.5, names)
        densities = _curves(response / square_g, names, at_point["log_error"])
        charts = [
            html.Chart("transmissibility", f, f"transmissibility to point {point}, –", gain),
            html.Chart("absolute acceleration", f, psd_unit(point), densities),
        ]
        caption = f"Random base motion at point {point}, stated input."
        first = point == points[0]
        yield chart_picture(f"base_{point}", charts, caption, has_svg=first, height=3.9)
    inputs = _curves(psd["input_psd"].sel(input="notched") / square_g, names)
    level = _curves(stated["input_psd"] / square_g, names)[0]
    inputs.append(replace(level, label="stated input", colour="#777777", line="dashed"))
    force = _curves(stated["interface_force_psd"], names, stated["force_log_error"])
    charts = [
        html.Chart("force", f, "force PSD, N²/Hz", force),
        html.Chart("input", f, "PSD of the supports, g²/Hz", inputs),
    ]
    caption = "Force of all supports under the stated input; stated and notched inputs."
    yield chart_picture("base_interface", charts, caption, height=3.9)


def _notches(notched: pd.DataFrame, names: Names) -> list[dict[str, Any]]:
    """Return the bands in which one limit lowers the input."""
    lowered = notched[notched["reason"] != ""]
    place = lowered[["scenario", "reason"]]
    start = place.ne(place.shift()).any(axis=1) | (lowered.index.to_series().diff() != 1)
    rows = []
    for _, band in lowered.groupby(start.cumsum()):
        deepest = max(records(band), key=lambda row: row["notch_db"])
        lower, *_, upper = band["frequency_hz"].tolist() * 2
        rows.append({**deepest, "lower": lower, "upper": upper, "name": names[deepest["scenario"]]})
    return rows


def _with_jumps(sine: xr.Dataset) -> list[str]:
    """Return the scenarios whose sweeps up and down differ."""
    up, down = (sine["acceleration"].sel(direction=way) for way in ("up", "down"))
    is_jump = abs(up / down - 1).max(("frequency", "point")) > SAME_MOTION
    return sine["scenario"].to_numpy()[is_jump.to_numpy()].tolist()


def _sine_values(sine: xr.Dataset, peaks: pd.DataFrame, names: Names) -> dict[str, Any]:
    """Return the sweep and its peaks, up and down in one text where they differ."""
    up, down = (records(peaks[peaks["direction"] == way]) for way in ("up", "down"))
    rows = []
    decimals = {error: common_decimals(peaks[error]) for _, error in PEAKS.values() if error}
    for sweeps in zip(up, down, strict=True):
        row = {**sweeps[0], "name": names[sweeps[0]["scenario"]]}
        row["trust"] = trust_text(doubts_in(max(sweeps, key=lambda s: len(doubts_in(s)))))
        for key, (value, error) in PEAKS.items():
            texts = [
                value_text(s[value], s.get(error, math.nan), decimals.get(error)) for s in sweeps
            ]
            row[key] = " / ".join(dict.fromkeys(texts))
        rows.append(row)
    frequency = sine["frequency"].to_numpy()
    return {
        "low": frequency[0],
        "high": frequency[-1],
        "level": sine.attrs["acceleration_g"],
        "jumps": [names[label] for label in _with_jumps(sine)],
        "peaks": rows,
    }


def _sine_pictures(
    sine: xr.Dataset, names: Names, points: Sequence[str], *, has_svg: bool
) -> Iterator[html.Picture]:
    """Yield amplitudes at the points and of the interface force, two at a time."""
    f, jumps = sine["frequency"].to_numpy(), [names[label] for label in _with_jumps(sine)]
    drawn = []
    for point in points:
        values = sine.sel(point=point)
        amplitude = values["acceleration"] / STANDARD_GRAVITY
        drawn.append((f"point {point}", "g", amplitude, values["acceleration_log_error"]))
    force = sine["interface_force"], sine["interface_force_log_error"]
    charts = []
    for title, unit, amplitude, error in [*drawn, ("interface force", "N", *force)]:
        up, down = (
            _curves(amplitude.sel(direction=way), names, error.sel(direction=way))
            for way in ("up", "down")
        )
        differing = [curve for curve in down if curve.label in jumps]
        dotted = [replace(c, label=f"{c.label}, down", line="dotted") for c in differing]
        charts.append(html.Chart(title, f, f"amplitude, {unit}", [*up, *dotted]))
    caption = (
        "Sine sweep: amplitudes of absolute accelerations and force. Bands: one standard error due "
        "to the damping."
    )
    for start in range(0, len(charts), 2):
        pair = charts[start : start + 2]
        yield chart_picture(
            f"base_sine_{start}", pair, caption, has_svg=has_svg and not start, height=3.9
        )
