"""What measurements that could be made would show, from the runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pidpanel.arrays import Array
from pidpanel.margin.next_test import Measurement
from pidpanel.margin.spread_dampers import TEST_DB

if TYPE_CHECKING:
    from pidpanel.study.uncertain import Errors

MODES_SEEN, FEW_MODES = 6, 3  # of a modal survey, of an impact test


def measurements_of(
    found: Mapping[str, Array], errors: Errors, edges: Array
) -> dict[str, Measurement]:
    """Return the measurements that could be made, with what the runs show of each.

    ``found`` has what the runs show, ``edges`` (n_bands, 2) the bands of levels [Hz].
    """
    modal, relative = np.log(found["frequency"]), errors.frequency
    count = modal.shape[1]
    ratio, of_ratio = np.log(found["ratio"]), errors.damping_ratio
    few = min(FEW_MODES, count)
    level = np.log10(np.maximum(_octaves(10 ** (found["level"] / 10), edges), 1e-30)) * 10
    spread = {
        "modal survey": Measurement(
            np.hstack([modal, ratio]), np.repeat([relative, of_ratio], count)
        ),
        "impact test": Measurement(
            np.hstack([modal[:, :few], ratio[:, :few]]), 2 * np.repeat([relative, of_ratio], few)
        ),
    }
    decibels, common = errors.level_db, errors.common_db
    if np.ptp(level) > 0:
        each = np.full(level.shape[1], decibels)
        spread["microphones"] = Measurement(level, each, common, "microphones")
    for name in ("bare", "damped"):
        # of the sound that the test had
        thirds = found[f"{name}_bands"] ** 2 / 10 ** (found["level"] / 10)[:, None]
        power = _octaves(thirds, edges).reshape(len(thirds), -1)
        values = 10 * np.log10(np.maximum(power, 1e-30))
        each = np.full(values.shape[1], decibels)
        label = f"acoustic test at {TEST_DB:g} dB, {name}"
        spread[label.replace("-", "−")] = Measurement(
            values, each, common, "acoustic", errors.common_damping if name == "damped" else 1.0
        )
    coupon = found["coupon"]
    if np.ptp(coupon, axis=0).any():
        spread["coupon on a shaker"] = Measurement(coupon, np.full(coupon.shape[1], errors.coupon))
    return spread


def _octaves(thirds: Array, edges: Array) -> Array:
    """Return sums of three thirds (…, n_bands) each; the last may have fewer."""
    return np.add.reduceat(thirds, np.arange(0, len(edges), 3), axis=-1)
