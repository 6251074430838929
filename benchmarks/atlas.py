"""Constants of the atlas, and how well it predicts cases that it does not have.

    python benchmarks/atlas.py [--write]

The packings of the design, a cell with its friction each, are in four parts. Cases of each part are
predicted from all others, in cells that the fit and its calibration have not seen. The table of
docs/theory/damping.md is printed, its figure is written to docs/, and with ``--write`` constants
of all cases to src/pidpanel/atlas/processes.json. Minutes on a core. Seconds with ``--drawn``: the
beds of atlas_drawn.csv, which are not in the atlas, are predicted from it as it is.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from atlas_fit import WIDTH, Predicted, fit_constants, packings_of, predict
from matplotlib.figure import Figure

from pidpanel.damping.atlas import REGIMES
from pidpanel.damping.atlas_files import atlas_data, by_state, read_rows, stored_sides
from pidpanel.paths import ATLAS_CASES, ATLAS_CONSTANTS

DESIGN, FOLDS = "Atlas of particle beds", 4  # source of the cases held out; parts of them
DRAWN = Path(__file__).with_name("atlas_drawn.csv")
NAMES = ("riding, W/L < 0.1", "between", "crossing, W/L > 0.5")
DOCS = Path(__file__).parents[1] / "docs"


def held_out(cases: pd.DataFrame) -> tuple[pd.DataFrame, Predicted, np.ndarray]:
    """Return the cases held out, their prediction, and the calibration (2, n) of its errors."""
    packing, is_design = packings_of(cases), (cases["source"] == DESIGN).to_numpy()
    part = np.where(is_design, packing % FOLDS, FOLDS)
    unknown, predicted, calibration = [], [], []
    for number in range(FOLDS):
        known, rest = cases[part != number], cases[part == number]
        constants = fit_constants(known)
        damping, mass = (stored_sides(constants[name]) for name in ("damping", "mass"))
        trend = np.array(constants["trend"])
        data = atlas_data(by_state(known), trend), atlas_data(rest, trend)
        predicted.append(predict(*data, damping, mass))
        regime = np.digitize(rest["stroke_per_gap"], REGIMES)
        calibration.append(np.array(constants["calibration"])[:, regime])
        unknown.append(rest)
    joined = Predicted(*(np.concatenate(values) for values in zip(*predicted, strict=True)))
    return pd.concat(unknown), joined, np.hstack(calibration)


def drawn() -> tuple[pd.DataFrame, Predicted, np.ndarray]:
    """Return the beds drawn at random, their prediction, and the calibration of its errors."""
    cases, stored = read_rows(DRAWN), json.loads(ATLAS_CONSTANTS.read_text(encoding="utf-8"))
    trend = np.array(stored["trend"])
    data = atlas_data(by_state(read_rows(ATLAS_CASES)), trend), atlas_data(cases, trend)
    sides = stored_sides(stored["damping"]), stored_sides(stored["mass"])
    regime = np.digitize(cases["stroke_per_gap"], REGIMES)
    return cases, predict(*data, *sides), np.array(stored["calibration"])[:, regime]


def rows(cases: pd.DataFrame, predicted: Predicted, calibration: np.ndarray) -> list[str]:
    """Return the rows of the table."""
    regime, lines = np.digitize(cases["stroke_per_gap"], REGIMES), []
    scores = np.abs(predicted.scores()) / calibration
    for number, name in enumerate(NAMES):
        part = regime == number
        away = np.abs(predicted.damping[part])
        within = 100 * (scores[:, part] < WIDTH).mean(axis=1)
        lines.append(
            f"| {name} | {part.sum()} | {np.exp(np.median(away)):.2f} | "
            f"{np.exp(np.sqrt(np.mean(away**2))):.2f} | {within[0]:.0f} % | "
            f"{np.median(np.abs(predicted.mass[part])):.2f} | {within[1]:.0f} % |"
        )
    return lines


def figure(cases: pd.DataFrame, predicted: Predicted, calibration: np.ndarray) -> Figure:
    """Draw predicted over simulated C_e of the cases held out, with 95 % intervals."""
    drawn = Figure(figsize=(6.5, 3.2), layout="constrained")
    axes = drawn.subplots()
    error = WIDTH * predicted.damping_error * calibration[0]
    values = np.exp(predicted.damping)
    low, high = values * (1 - np.exp(-error)), values * (np.exp(error) - 1)
    axes.errorbar(
        cases["stroke_per_gap"], values, [low, high], fmt="none", elinewidth=0.5, ecolor="#b8cbe0"
    )
    axes.plot(cases["stroke_per_gap"], values, "o", ms=2, mew=0, color="#1f4e79")
    axes.set(xscale="log", yscale="log", xlabel="W/L", ylabel="predicted over simulated $C_e$")
    axes.set_ylim(0.1, 10)
    axes.axhline(1, color="#999999", lw=0.6)
    axes.yaxis.set_major_formatter("{x:g}")
    for edge in REGIMES:
        axes.axvline(edge, color="#999999", lw=0.6, ls=":")
    return drawn


def main() -> None:
    """Print the table, and write the figure and the constants."""
    cases, is_drawn = read_rows(ATLAS_CASES), "--drawn" in sys.argv
    result = drawn() if is_drawn else held_out(cases)
    print(
        f"{len(result[0])} beds drawn" if is_drawn else f"{len(result[0])} of {len(cases)} held out"
    )
    print(
        "| W/L | cases | factor of C_e, median | rms | within 95 % | m_a/m″, median | within 95 % |"
    )
    print("|---|---|---|---|---|---|---|")
    print("\n".join(rows(*result)))
    if is_drawn:
        return
    figure(*result).savefig(DOCS / "atlas_held_out.png", dpi=130)
    if "--write" in sys.argv:
        constants = fit_constants(cases)
        ATLAS_CONSTANTS.write_text(json.dumps(constants, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
