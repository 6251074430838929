"""Does the number of functions of the pressure at free edges change g rms of whole panels?

Ten outlines that are no rectangles; the bound on the resolution of the points was set on two of
them, the slender L and the triangle. Each is computed with the functions of the program and with
about 1.6 times as many, free in a room and in air, bare and with a damper, at three points.

    python benchmarks/outlines.py [highest frequency, 500 Hz] [names …]

Two to three CPU-minutes to 500 Hz.
"""

from __future__ import annotations

import sys
from unittest.mock import patch as patched

import numpy as np

from pidpanel import Model
from pidpanel.sound import from_study, outline
from pidpanel.sound.outline import OutlineJumps

FUNCTIONS = {"SPARE_DEGREES": 5, "MOST_FUNCTIONS": 160}
MORE = {"SPARE_DEGREES": 9, "MOST_FUNCTIONS": 360}
TURN = 2 * np.pi * (np.arange(24) + 0.5) / 24


def polygon(x, y) -> list[list[float]]:
    """Return corners as a study has them."""
    return [[round(float(a), 6), round(float(b), 6)] for a, b in zip(x, y, strict=True)]


def l_shape(length: float, height: float, arm: float, leg: float) -> list[list[float]]:
    """Return an L with an arm along x and a leg along y."""
    return [[0, 0], [length, 0], [length, arm], [leg, arm], [leg, height], [0, height]]


SIDES = [[0, 0], [1.2, 0], [1.2, 0.9], [0, 0.9]]
# corners, holes, centre of the damper, two more points
PANELS = {
    "L, broad": (l_shape(1.3, 1.1, 0.6, 0.7), {}, (0.3, 0.3), (0.9, 0.3), (0.35, 0.8)),
    "L, slender": (l_shape(1.6, 1.2, 0.35, 0.35), {}, (0.18, 0.18), (1.0, 0.2), (0.15, 0.8)),
    "U": (
        [[0, 0], [1.2, 0], [1.2, 0.9], [0.8, 0.9], [0.8, 0.4], [0.4, 0.4], [0.4, 0.9], [0, 0.9]],
        {}, (0.6, 0.2), (0.2, 0.6), (1.0, 0.5),
    ),
    "octagon": (polygon(0.6 + 0.6 * np.cos(TURN[1::3]), 0.6 + 0.6 * np.sin(TURN[1::3])),
                {}, (0.6, 0.6), (0.35, 0.5), (0.8, 0.8)),
    "triangle": ([[0, 0], [1.4, 0], [0.5, 1.1]], {}, (0.6, 0.35), (0.4, 0.2), (0.9, 0.2)),
    "trapezoid": ([[0, 0], [1.5, 0], [1.1, 0.8], [0.3, 0.8]], {}, (0.7, 0.4), (0.3, 0.2),
                  (1.0, 0.6)),
    "ellipse": (polygon(0.8 + 0.8 * np.cos(TURN), 0.5 + 0.5 * np.sin(TURN)), {}, (0.8, 0.5),
                (0.4, 0.4), (1.1, 0.7)),
    "round hole": (SIDES, {"a": {"centre_m": [0.8, 0.45], "diameter_m": 0.4}}, (0.3, 0.45),
                   (0.5, 0.2), (1.1, 0.7)),
    "two holes": (SIDES, {"a": {"centre_m": [0.35, 0.5], "size_m": [0.25, 0.3]},
                          "b": {"centre_m": [0.85, 0.4], "size_m": [0.2, 0.3]}}, (0.6, 0.45),
                  (0.6, 0.8), (1.05, 0.5)),
    "cross": (
        [[0.4, 0], [0.8, 0], [0.8, 0.4], [1.2, 0.4], [1.2, 0.8], [0.8, 0.8], [0.8, 1.2],
         [0.4, 1.2], [0.4, 0.8], [0, 0.8], [0, 0.4], [0.4, 0.4]],
        {}, (0.6, 0.6), (0.2, 0.6), (0.6, 1.0),
    ),
}  # fmt: skip


def g_rms(name: str, highest: float, functions: dict[str, int]) -> tuple[np.ndarray, int]:
    """Return g rms (scenarios, points) of a panel, and the number of functions."""
    corners, holes, centre, *points = PANELS[name]
    for key, value in functions.items():
        setattr(outline, key, value)
    from_study.tabulated_panel.cache_clear()
    counts, made = [], OutlineJumps.of_mesh

    def counted(*arguments):
        jumps = made(*arguments)
        counts.append(jumps.functions.shape.shape[1])
        return jumps

    patch = {"centre_m": list(centre), "diameter_m": 0.2}
    model = Model("l_panel.yaml").changed(
        {
            "panel.outline_m": corners,
            "panel.holes": holes,
            "panel.patches": {"damped": patch},
            "panel.points": dict(zip("ABC", map(list, (centre, *points)), strict=True)),
            "response.frequency_hz": [30, highest],
            "scenarios": {"half": {"title": "half", "patch": "damped", "fill_fraction": 0.5}},
        }
    )
    with patched.object(OutlineJumps, "of_mesh", counted):
        table = model.summary()
    return table["acceleration_rms_g"].to_numpy().reshape(-1, 3), counts[0]


def main(highest: float = 500.0, *names: str) -> int:
    """Print the largest changes of g rms."""
    print("outline | functions | change of g rms with about 1.6 times as many, %")
    for name in names or PANELS:
        (values, count), (other, more) = (g_rms(name, highest, f) for f in (FUNCTIONS, MORE))
        change = 100 * (other / values - 1)
        text = f"{name} | {count}, {more} | {change.min():+.3f} to {change.max():+.3f}"
        print(text, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*(float(a) for a in sys.argv[1:2]), *sys.argv[2:]))
