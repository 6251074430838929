"""What coupled runs at some levels say of a level between them, or beyond.

Between two levels ln C_e, m_a and the ln of the own force are linear in the level in dB. That they
are not quite is an error of all bands together: a parabola between two points leaves its chord by
t (1 − t) times the change from one to the other, if its slope at one end is zero. Beyond all levels
the nearest one holds, and ln C_e errs as C_e ∝ 1/Γ has it, about as fast as it falls anywhere.

Where a bed begins to cross its gap its own force grows a thousandfold within some decibels, which
no line between two levels has: what is carried is carried from neighbours.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping.coupled import BAND_COLUMNS, BandDamping


def nearest(level: float, levels: Sequence[float], largest: float) -> tuple[int, ...]:
    """Return the indices of the levels from which another is carried: one, or one on each side.

    Examples
    --------
    >>> nearest(134.0, [138.0, 122.0, 132.0], 3.0), nearest(134.0, [142.0, 132.0], 3.0)
    ((2, 0), (1,))
    """
    offset = np.asarray(levels) - level
    if np.abs(offset).min() > largest:
        raise ValueError(f"{level:g} dB: no neighbour within {largest:g} dB")
    low = int(np.argmax(np.where(offset <= 0, offset, -np.inf)))
    high = int(np.argmin(np.where(offset > 0, offset, np.inf)))
    sides = [k for k, good in ((low, offset[low] <= 0), (high, offset[high] > 0)) if good]
    return tuple(k for k in sides if abs(offset[k]) <= 2 * largest)


def extrapolated(distance: float, bed: BandDamping) -> BandDamping:
    """Return a bed at another level, where nothing else is known."""
    common = float(np.hypot(bed.common_error, abs(distance) * np.log(10) / 20))
    return replace(bed, common_error=common)


def interpolated(share: float, low: BandDamping, high: BandDamping) -> BandDamping:
    """Return a bed between two levels."""

    def mean(first: Array, second: Array) -> Array:
        return (1 - share) * first + share * second

    def error(first: Array, second: Array) -> Array:
        return np.hypot((1 - share) * first, share * second)

    damping = np.exp(mean(low.log_damping, high.log_damping))
    relative = error(
        low.equivalent_damping_error / np.exp(low.log_damping),
        high.equivalent_damping_error / np.exp(high.log_damping),
    )
    floor = 1e-12 * max(float(low.own_psd.max()), float(high.own_psd.max()), 1e-300)
    own_psds = [np.log(np.maximum(bed.own_psd, floor)) for bed in (low, high)]
    change = high.log_damping - low.log_damping
    curved = share * (1 - share) * float(np.sqrt(np.mean(change**2)))
    return BandDamping(
        equivalent_damping=damping,
        equivalent_damping_error=damping * relative,
        apparent_mass=mean(low.apparent_mass, high.apparent_mass),
        apparent_mass_error=error(low.apparent_mass_error, high.apparent_mass_error),
        own_psd=np.exp(mean(*own_psds)),
        own_coherence=mean(low.own_coherence, high.own_coherence),
        common_error=float(
            np.hypot(curved, mean(np.array(low.common_error), np.array(high.common_error)))
        ),
    )


def carried_impedances(
    scenario: str, source: str, level: float, near: Sequence[tuple[float, pd.DataFrame]]
) -> pd.DataFrame:
    """Return the rows of `impedances` of a scenario that was not run, from one or two levels."""

    def bed(rows: pd.DataFrame) -> BandDamping:
        bands = {name: rows[column].to_numpy() for name, column in BAND_COLUMNS.items()}
        return BandDamping(**bands, common_error=float(rows["common_error"].iloc[0]))

    parts = []
    for patch, rows in near[0][1].groupby("patch", sort=False):
        beds = [bed(table[table["patch"] == patch]) for _, table in near]
        if len(near) == 1:
            carried = extrapolated(level - near[0][0], *beds)
        else:
            low, high = near[0][0], near[1][0]
            carried = interpolated((level - low) / (high - low), *beds)
        values = {column: getattr(carried, name) for name, column in BAND_COLUMNS.items()}
        parts.append(
            rows.assign(
                scenario=scenario, **values, common_error=carried.common_error, carried_from=source
            )
        )
    return pd.concat(parts)
