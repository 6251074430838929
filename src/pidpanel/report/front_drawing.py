"""The front of mass and reduction as SVG, whose points lead to their layouts."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from pidpanel.arrays import Array
from pidpanel.report import style
from pidpanel.report.text import number, records

WIDTH, HEIGHT = 640, 340
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 12, 44

# Name, colour and mark of what the same mass does otherwise, by the start of its column.
ALTERNATIVES = {
    "dead_weight": ("dead weight in the same cells", style.PLACES[1], "M-4-4 4 4M-4 4 4-4"),
    "face_sheets": ("thicker face sheets", style.PLACES[2], "M-4 4 0-4 4 4Z"),
    "damping_layer": ("damping layer", style.PLACES[3], "M-4-4H4V4H-4Z"),
}


def front_drawing(front: pd.DataFrame) -> str:
    """Return reduction over mass as SVG; layouts of the front link to ``#layout_<number>``."""
    rows = records(front[front["is_on_front"]].sort_values("mass_kg"))
    names = [n for n in ALTERNATIVES if np.isfinite(front[f"{n}_reduction_db"]).any()]
    lowest = min(0.0, *(front[f"{n}_reduction_db"].min() for n in names))
    highest = (front["reduction_db"] + front["reduction_error_db"]).max()
    x, x_ticks = _scale(0.0, 1.08 * front["mass_kg"].max(), LEFT, WIDTH - RIGHT)
    y, y_ticks = _scale(lowest, 1.05 * highest, HEIGHT - BOTTOM, TOP)
    parts = [f'<path d="M{x(t):.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#e3e3e3"/>' for t in x_ticks]
    parts += [f'<path d="M{LEFT} {y(t):.1f}H{WIDTH - RIGHT}" stroke="#e3e3e3"/>' for t in y_ticks]
    parts += [_text(x(t), HEIGHT - BOTTOM + 16, f"{t:g}") for t in x_ticks]
    parts += [_text(LEFT - 6, y(t) + 4, f"{t:g}".replace("-", "−"), "end") for t in y_ticks]
    parts.append(_text((LEFT + WIDTH) / 2, HEIGHT - 8, "mass of the dampers, kg"))
    parts.append(f'<g transform="translate(14 {HEIGHT / 2}) rotate(-90)">')
    parts.append(_text(0, 0, "reduction, dB") + "</g>")
    for index, name in enumerate(names):
        label, colour, mark = ALTERNATIVES[name]
        drawn = [(x(row["mass_kg"]), y(row[f"{name}_reduction_db"])) for row in rows]
        drawn.append((LEFT + 14, TOP + 14 + 18 * index))
        parts += [
            f'<path transform="translate({px:.1f} {py:.1f})" d="{mark}" fill="none" '
            f'stroke="{colour}" stroke-width="1.6"/>'
            for px, py in drawn
            if np.isfinite(py)
        ]
        parts.append(_text(LEFT + 26, TOP + 18 + 18 * index, label, "start"))
    line = " ".join(f"{x(row['mass_kg']):.1f},{y(row['reduction_db']):.1f}" for row in rows)
    colour = style.PLACES[0]
    parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.4"/>')
    for row in rows:
        px, py, error = x(row["mass_kg"]), row["reduction_db"], row["reduction_error_db"]
        face = colour if row["is_equivalent"] else "#ffffff"
        label = f"Layout {row['layout']}: {number(row['mass_kg'])} kg, {number(py)} dB"
        parts.append(
            f'<path d="M{px:.1f} {y(py - error):.1f}V{y(py + error):.1f}" stroke="{colour}"/>'
            f'<a href="#layout_{row["layout"]}" aria-label="{label}"><title>{label}</title>'
            f'<circle cx="{px:.1f}" cy="{y(py):.1f}" r="7" fill="{face}"/>'
            f"{_text(px - 11, y(py) - 9, str(row['layout']), 'end')}</a>"
        )
    frame = f'viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}"'
    return f'<svg {frame} role="group" fill="#1b1f24">{"".join(parts)}</svg>'


def _scale(
    low: float, high: float, start: float, end: float
) -> tuple[Callable[[float], float], Array]:
    """Return value → pixel of an axis, and its ticks."""
    ticks = np.array(MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high))
    ticks = ticks[(ticks >= low - 1e-9) & (ticks <= high)]
    return lambda value: start + (value - low) / (high - low) * (end - start), ticks


def _text(x: float, y: float, text: str, anchor: str = "middle") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'
