"""How many cases of a coupon the atlas replaces as the prior of its surface.

    python benchmarks/atlas_prior.py

The 130 cases of the acrylic coupon of paper.yaml, level.yaml and benchmarks/single_tones.py are not
in the atlas here. Some of them, drawn at random eight times, make a surface with closed forms as
prior, or with the atlas (`prior`); the others are predicted. The table of
docs/atlas.md is printed. Errors are calibrated as those of
the atlas. A minute on a core.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from atlas_fit import constants_of, predict, trend_of
from atlas_panels import COUPONS, DENSITY

from pidpanel.damping.atlas import REGIMES
from pidpanel.damping.atlas_files import atlas_data, by_state, read_atlas, read_rows
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import training_data
from pidpanel.paths import ATLAS_CASES

NUMBERS, REPEATS = (0, 5, 10, 20, 40, 80), 8
AXES = ["fill_fraction", "frequency_hz", "acceleration_g"]


def closed_form(known: pd.DataFrame, unknown: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of ln C_e and standard errors (2, n) with the surface of the known cases."""
    surface = DampingSurface.from_frame(known, 1.0, 25e-3)
    data = training_data(unknown, surface.bed)
    mixture, _ = surface.mixtures(data.points)
    error = np.sqrt(surface.damping.variance(mixture) + data.log_error**2)
    return mixture.mean - data.log_damping, error


def main() -> None:
    """Print the table."""
    rows = read_rows(ATLAS_CASES)
    is_of_coupons = rows["source"].str.contains("|".join(COUPONS))
    rest = rows[~is_of_coupons]
    coupon = rows[is_of_coupons & (rows["density_kg_m3"] == DENSITY["acrylic"])]
    # cases of a study's own coupon are no outliers of the atlas
    coupon = coupon.assign(acceleration_g=coupon["gamma"], is_of_atlas=False).drop_duplicates(AXES)
    calibration = read_atlas().calibration[0]
    trend = trend_of(by_state(rest))
    data = atlas_data(by_state(rest), trend)
    damping, mass = (constants_of(sides) for sides in (data.damping_sides(), data.mass_sides()))
    rng = np.random.default_rng(1)
    print("| cases | atlas: factor, median | rms | stated | closed forms: median | rms | stated |")
    print("|---|---|---|---|---|---|---|")
    for number in NUMBERS:
        results: list[list[tuple[np.ndarray, np.ndarray]]] = [[], []]
        for _ in range(REPEATS if number else 1):
            order = rng.permutation(len(coupon))
            known, unknown = coupon.iloc[order[:number]], coupon.iloc[order[number:]]
            table = atlas_data(by_state(pd.concat([rest, known])), trend)
            predicted = predict(table, atlas_data(unknown, trend), damping, mass)
            factor = calibration[np.digitize(unknown["stroke_per_gap"], REGIMES)]
            results[0].append((predicted.damping, factor * predicted.damping_error))
            if number:
                results[1].append(closed_form(known, unknown))
        print(f"| {number} | " + " | ".join(_columns(result) for result in results) + " |")


def _columns(results: list[tuple[np.ndarray, np.ndarray]]) -> str:
    if not results:
        return " | | "
    away, stated = (np.concatenate(values) for values in zip(*results, strict=True))
    median, rms = np.exp(np.median(np.abs(away))), np.exp(np.sqrt(np.mean(away**2)))
    return f"{median:.2f} | {rms:.2f} | {np.exp(np.median(stated)):.2f}"


if __name__ == "__main__":
    main()
