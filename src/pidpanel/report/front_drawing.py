"""The front of mass and reduction as SVG, whose points lead to their layouts."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.ticker import MaxNLocator

from pidpanel.report import style
from pidpanel.report.templates import fill
from pidpanel.report.text import records

WIDTH, HEIGHT = 640, 340
LEFT, RIGHT, TOP, BOTTOM = 52, WIDTH - 12, 12, HEIGHT - 44  # edges of the axes [pixel]

# Name, colour and mark of what the same mass does otherwise, by the start of its column.
ALTERNATIVES = {
    "dead_weight": ("dead weight in the same cells", style.PLACES[1], "M-4-4 4 4M-4 4 4-4"),
    "face_sheets": ("thicker face sheets", style.PLACES[2], "M-4 4 0-4 4 4Z"),
    "damping_layer": ("damping layer", style.PLACES[3], "M-4-4H4V4H-4Z"),
}


def known_alternatives(front: pd.DataFrame) -> list[str]:
    """Return the `ALTERNATIVES` of which a front has reductions."""
    return [n for n in ALTERNATIVES if np.isfinite(front[f"{n}_reduction_db"]).any()]


def front_drawing(front: pd.DataFrame) -> Markup:
    """Return reduction over mass as SVG; layouts of the front link to ``#layout_<number>``."""
    rows = front[front["is_on_front"]].sort_values("mass_kg")
    names = known_alternatives(front)
    lowest = min(0.0, *(front[f"{n}_reduction_db"].min() for n in names))
    highest = (front["reduction_db"] + front["reduction_error_db"]).max()
    x, x_ticks = _scale(0.0, 1.08 * front["mass_kg"].max(), LEFT, RIGHT)
    y, y_ticks = _scale(lowest, 1.05 * highest, BOTTOM, TOP)
    across, reduction, error = x(rows["mass_kg"]), rows["reduction_db"], rows["reduction_error_db"]
    alternatives = []
    for name in names:
        known = np.isfinite(rows[f"{name}_reduction_db"])
        up = y(rows[f"{name}_reduction_db"])
        places = list(zip(across[known], up[known], strict=True))
        look = dict(zip(("name", "colour", "mark"), ALTERNATIVES[name], strict=True))
        alternatives.append({**look, "places": places})
    drawn = rows.assign(x=across, y=y(reduction), low=y(reduction - error),
                        high=y(reduction + error))  # fmt: skip
    values = {
        "width": WIDTH, "height": HEIGHT, "left": LEFT, "right": RIGHT, "top": TOP,
        "bottom": BOTTOM, "x_ticks": x_ticks, "y_ticks": y_ticks, "alternatives": alternatives,
        "colour": style.PLACES[0], "rows": records(drawn),
    }  # fmt: skip
    return fill("front.html", values)


def _scale(
    low: float, high: float, start: float, end: float
) -> tuple[Callable[[pd.Series], pd.Series], list[tuple[float, float]]]:
    """Return values → pixels of an axis, and its ticks, each with its pixel."""
    slope = (end - start) / (high - low)
    ticks = np.array(MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high))
    ticks = ticks[(ticks >= low - 1e-9) & (ticks <= high)]
    pixels = start + (ticks - low) * slope
    placed = list(zip(ticks.tolist(), pixels.tolist(), strict=True))
    return lambda values: start + (values - low) * slope, placed
