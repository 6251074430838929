"""What measurements that could be made would show, from the runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.margin.next_test import Observable

FEW_MODES, OCTAVE = 3, 3  # modes of an impact test, thirds


def measurements_of(
    results: Mapping[str, Array],
    errors: Any,
    edges: Array,
    spectrum: Sequence[slice] = (),
    test_db: float = -12.0,
) -> dict[str, Observable]:
    """Return the measurements that could be made, with what the runs show of independent.

    ``results`` has what the runs show, ``edges`` (n_bands, 2) the bands of levels [Hz], and
    ``spectrum`` the scores of the launch spectrum; ``test_db`` is the level of acoustic tests over
    that of the study.
    """
    # those above the bands are residual vectors
    count = int(np.sum(results["frequency"].mean(axis=0) <= edges.max()))
    lowest, modal = min(FEW_MODES, count), [errors.frequency, errors.damping_ratio]
    level = octave_levels(10 ** (results["level"] / 10), edges)
    spread = {}
    for name, modes, factor in (
        (("modal survey", count, 1), ("impact test", lowest, 2)) if count else ()
    ):
        columns = [np.log(results[kind][:, :modes]) for kind in ("frequency", "ratio")]
        spread[name] = Observable(np.hstack(columns), factor * np.repeat(modal, modes))
    decibels, common = errors.level_db, errors.common_db
    if np.ptp(level) > 0:
        independent = np.full(level.shape[1], decibels)
        spread["microphones"] = Observable(level, independent, common, "microphones")
    for name in ("bare", "damped"):
        # of the sound that the test had
        thirds = results[f"{name}_bands"] ** 2
        thirds = thirds / 10 ** (results["level"][: len(thirds)] / 10)[:, None]
        values = octave_levels(thirds, edges).reshape(len(thirds), -1)
        independent = np.full(values.shape[1], decibels)
        label = f"acoustic test at {test_db:g} dB, {name}"
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


def octave_levels(thirds: Array, edges: Array) -> Array:
    """Return levels [dB] of octaves of powers in thirds (…, n_bands); the last may have fewer."""
    power = np.add.reduceat(thirds, np.arange(0, len(edges), OCTAVE), axis=-1)
    return np.asarray(10 * np.log10(np.maximum(power, 1e-30)))
