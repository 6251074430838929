"""What measurements that could be made would show, from the runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.margin.next_test import Observable
from pidpanel.margin.spread_dampers import TEST_DB

MODES_SEEN, FEW_MODES = 6, 3  # of a modal survey, of an impact test


def measurements_of(
    results: Mapping[str, Array], errors: Any, edges: Array, spectrum: Sequence[slice] = ()
) -> dict[str, Observable]:
    """Return the measurements that could be made, with what the runs show of independent.

    ``results`` has what the runs show, ``edges`` (n_bands, 2) the bands of levels [Hz], and
    ``spectrum`` the scores of the launch spectrum.
    """
    modal, relative = np.log(results["frequency"]), errors.frequency
    count = modal.shape[1]
    ratio, ratio_error = np.log(results["ratio"]), errors.damping_ratio
    lowest = min(FEW_MODES, count)
    level = np.log10(np.maximum(_octaves(10 ** (results["level"] / 10), edges), 1e-30)) * 10
    spread = {
        "modal survey": Observable(
            np.hstack([modal, ratio]), np.repeat([relative, ratio_error], count)
        ),
        "impact test": Observable(
            np.hstack([modal[:, :lowest], ratio[:, :lowest]]),
            2 * np.repeat([relative, ratio_error], lowest),
        ),
    }
    decibels, common = errors.level_db, errors.common_db
    if np.ptp(level) > 0:
        independent = np.full(level.shape[1], decibels)
        spread["microphones"] = Observable(level, independent, common, "microphones")
    for name in ("bare", "damped"):
        # of the sound that the test had
        thirds = results[f"{name}_bands"] ** 2
        thirds = thirds / 10 ** (results["level"][: len(thirds)] / 10)[:, None]
        power = _octaves(thirds, edges).reshape(len(thirds), -1)
        values = 10 * np.log10(np.maximum(power, 1e-30))
        independent = np.full(values.shape[1], decibels)
        label = f"acoustic test at {TEST_DB:g} dB, {name}"
        spread[label.replace("-", "−")] = Observable(
            values,
            independent,
            common,
            "acoustic",
            errors.common_damping if name == "damped" else 1.0,
            spectrum,
        )
    coupon = results["coupon"]
    if np.ptp(coupon, axis=0).any():
        spread["coupon on a shaker"] = Observable(coupon, np.full(coupon.shape[1], errors.coupon))
    return spread


def _octaves(thirds: Array, edges: Array) -> Array:
    """Return sums of three thirds (…, n_bands) independent; the last may have fewer."""
    return np.add.reduceat(thirds, np.arange(0, len(edges), 3), axis=-1)
