"""A coupon in words: particles, cell, accuracy, and what came out in plain figures."""

from __future__ import annotations

import pandas as pd

from pidpanel.geometry.cells import SHAPES
from pidpanel.report.text import counted, number, percent, value_text
from pidpanel.study.coupon import Coupon
from pidpanel.study.particles import Binary, Mono, Normal

DIRECTIONS = {(0.0, 0.0, -1.0): "along −z (the motion is along z)"}


def coupon_text(coupon: Coupon, cases: pd.DataFrame) -> str:
    """Return material, e, μ, cell, gravity and accuracy of a coupon in a few sentences."""
    p = coupon.particles

    def label(key: str, text: str) -> str:
        if key not in coupon.vary:
            return text
        values = ", ".join(f"{value:g}" for value in coupon.vary[key])
        return f"{text.partition(' = ')[0]} = {values} (varied)"

    sizes = sorted(1e3 * d for d in coupon.diameters)
    size = (
        " and ".join(f"{d:g}" for d in sizes)
        if len(sizes) < 3
        else (f"{sizes[0]:g} to {sizes[-1]:g}")
    )
    parts = [
        f"Particles of {size} mm{_spread(coupon)}",
        label("particles.density_kg_m3", f"ρ = {p.density_kg_m3:g} kg/m³"),
        label("particles.youngs_modulus_mpa", f"E = {p.youngs_modulus_mpa:g} MPa"),
        label("particles.poissons_ratio", f"ν = {p.poissons_ratio:g}"),
        label("particles.restitution", f"e = {p.restitution:g}{_wall(coupon, 'restitution')}"),
        label("particles.friction", f"μ = {p.friction:g}{_wall(coupon, 'friction')}"),
    ]
    if p.rolling_friction or "particles.rolling_friction" in coupon.vary:
        parts.append(label("particles.rolling_friction", f"μ_r = {p.rolling_friction:g}"))
    if p.shell_mm is not None:
        parts.append(f"hollow, shell of {p.shell_mm:g} mm")
    cell = coupon.cell
    count = "a varied number of" if "cell.count" in coupon.vary else f"{cell.count}"
    across = "diameter" if cell.shape == "circle" else "wide"
    word = "" if "cell.shape" in coupon.vary else f"{SHAPES[cell.shape].word} "
    gravity = (
        "gravity varied"
        if {"gravity_g", "gravity_direction"} & set(coupon.vary)
        else (
            f"{coupon.gravity_g:g} g "
            + DIRECTIONS.get(coupon.gravity_direction, f"along {coupon.gravity_direction}")
        )
    )
    return (
        f"{', '.join(parts)}; {count} {word}cell{'' if count == '1' else 's'}, "
        f"{cell.across_flats_mm:g} mm {across}, {cell.depth_mm:g} mm deep; {gravity}. "
        f"{accuracy_text(coupon, cases)}"
    )


def accuracy_text(coupon: Coupon, cases: pd.DataFrame) -> str:
    """Return which accuracy was asked for, and which was reached."""
    good = cases[cases["status"] == "ok"]
    accuracy = coupon.accuracy
    text = (
        f"{counted(accuracy.seeds, 'packing')} per case, run until the standard error of C_e is "
        f"{percent(accuracy.relative_error)} or for {accuracy.max_cycles} cycles"
    )
    if not len(good):
        return f"{text}; no case is ok."
    relative = (good["equivalent_damping_error_n_s_m3"] / good["equivalent_damping_n_s_m3"]).abs()
    return (
        f"{text}. Reached: {percent(relative.median(), 1)} in the median, "
        f"{percent(relative.max(), 1)} at most, in {len(good)} of {counted(len(cases), 'case')}."
    )


def coupon_finding(cases: pd.DataFrame) -> str:
    """Return the range of C_e and where the particles dissipate most, with errors."""
    if not len(cases):
        return "No case is ok, so there is no result for this coupon."
    peak = cases.iloc[int(cases["loss_factor"].to_numpy().argmax())]
    low, high = cases["equivalent_damping_n_s_m3"].min(), cases["equivalent_damping_n_s_m3"].max()
    span = (
        f"{number(low)} to {number(high)} N s/m³"
        if len(cases) > 1
        else value_text(low, float(cases["equivalent_damping_error_n_s_m3"].iloc[0])) + " N s/m³"
    )
    return (
        f"C_e is {span}; the largest loss factor is "
        f"{value_text(peak['loss_factor'], peak['loss_factor_error'])} (the bound of an inelastic "
        f"bed is 1.27), at r = {peak['fill_fraction']:g}, {peak['frequency_hz']:g} Hz, "
        f"Γ = {peak['acceleration_g']:.4g}."
    )


def _wall(coupon: Coupon, key: str) -> str:
    """Return the constant of the walls where it differs."""
    if f"walls.{key}" in coupon.vary:
        return " (walls varied)"
    wall = getattr(coupon.walls, key)
    return "" if wall is None else f" (walls {wall:g})"


def _spread(coupon: Coupon) -> str:
    spread = coupon.particles.distribution
    if isinstance(spread, Mono):
        return ""
    if isinstance(spread, Normal):
        return f" ± {spread.deviation_mm:g} mm (normal)"
    if isinstance(spread, Binary):
        return f" and {spread.second_mm:g} mm ({percent(spread.second_share)} by number)"
    return f" ± {spread.half_width_mm:g} mm (uniform)"
