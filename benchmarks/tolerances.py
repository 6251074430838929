"""How far g rms of the paper's panel follows restitution, friction and fill fraction.

    python benchmarks/tolerances.py

The panel is in a baffle without air, PID-1 half full of 2 mm acrylic (e = 0.8, μ = 0.3). Printed is
the change of g rms at point 326 for other particles, by the damping model `atlas`, and the ± that
their tolerances have by its derivatives. Writes docs/tolerances.png. Minutes.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import pidpanel
from pidpanel.paths import STUDIES
from pidpanel.study.writing import values_of

LEVELS = (136.7, 122.0)  # [dB]
USUAL = {"restitution": 0.8, "friction": 0.3, "fill_fraction": 0.5}
NAMES = {"restitution": "e", "friction": "μ", "fill_fraction": "r"}
ERRORS = {"restitution": 0.05, "friction": 0.05, "fill_fraction": 0.0215}
# Changes of g rms at 136.7 dB that an independent code finds, to about ± 1 [%]
INDEPENDENT = {
    ("restitution", 0.6): -1.5, ("friction", 0.1): 2.9, ("friction", 0.5): -3.5,
    ("fill_fraction", 0.4785): 1.0, ("fill_fraction", 0.5215): -0.4,
}  # fmt: skip


def response(level: float, **values: Any) -> pd.Series:
    """Return the row of ``summary.csv`` at point 326 with some other values."""
    launch, values = values_of(STUDIES / "launch.yaml"), USUAL | values
    fill = values.pop("fill_fraction")
    cell, particles = {"across_flats_mm": 6.35, "depth_mm": 25}, {"diameter_mm": 2, **values}
    study = {
        "panel": launch["panel"],
        "sound": {**launch["sound"], "surroundings": "baffle"},
        "dampers": {"acrylic": {"cell": cell, "particles": particles, "model": "atlas"}},
        "scenarios": {"half": {"patch": "PID-1", "fill_fraction": fill, "oaspl_db": level}},
        "response": {"frequency_hz": [30, 500], "maps": [], "radiation": "none"},
    }
    with tempfile.TemporaryDirectory() as folder:
        summary = pidpanel.Model(study, folder).summary()
    return summary[(summary["point"].astype(str) == "326") & (summary["patch"] != "none")].iloc[0]


def draw(rows: Sequence[tuple[Any, ...]]) -> None:
    """Draw the changes, a row each: name, at both levels, of the independent code [%]."""
    names, *columns = zip(*rows, strict=True)
    place = np.arange(len(names))
    _, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
    for offset, level, values in zip((0.19, -0.19), LEVELS, columns, strict=False):
        axes.barh(place + offset, values, 0.36, label=f"atlas, {level:g} dB")
    axes.plot(columns[2], place + 0.19, "kD", ms=5, label="independent code, 136.7 dB")
    axes.set(yticks=place, yticklabels=names, xlabel="change of g rms at point 326, %")
    axes.axvline(0, color="k", lw=0.8)
    axes.invert_yaxis()
    axes.legend(frameon=False, loc=(0.01, 0.5))
    plt.savefig(Path(__file__).parents[1] / "docs" / "tolerances.png", dpi=130)


def main() -> None:
    """Print the changes and draw them."""
    cases = {(key, round(USUAL[key] + sign * ERRORS[key], 4)) for key in USUAL for sign in (-1, 1)}
    order = sorted(cases | set(INDEPENDENT), key=lambda case: (list(USUAL).index(case[0]), case[1]))
    plain = {level: response(level)["acceleration_rms_g"] for level in LEVELS}
    rows = []
    for key, value in order:
        found = [response(level, **{key: value})["acceleration_rms_g"] for level in LEVELS]
        changes = [100 * (g / plain[level] - 1) for g, level in zip(found, LEVELS, strict=True)]
        rows.append(
            (f"{NAMES[key]} = {value:.3g}", *changes, INDEPENDENT.get((key, value), np.nan))
        )
        print(*rows[-1])
    for key, error in ERRORS.items():
        stated = {key: {"value": USUAL[key], "error": error}}
        parts = [response(level, **stated)["tolerance_error_db"] for level in LEVELS]
        print(f"{key} ± {error}:", *(f"{100 * np.log(10) / 20 * part:.2f} %" for part in parts))
    draw(rows)


if __name__ == "__main__":
    main()
