"""Damping ratio of the bare panel: one of all modes, over frequency, or mode by mode."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import Allowed, numbers, read_rows
from pidpanel.tabular.cells import HERTZ, Label

COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False, label=HERTZ),
    "damping_ratio": Allowed(
        0.0, low_itself=False, high=0.5, hint="in %?",
        label=Label.named("1", "zeta ζ ratio", "damping critical modal"),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class DampingRatio:
    """ζ of the modes of the bare panel."""

    # (n,) positive [1]; of the elastic modes in turn where there is no frequency, the last of all
    # that follow
    ratio: tuple[float, ...]
    # (n,) rising [Hz]. Between them ζ is linear in ln f, beyond them constant.
    frequency: tuple[float, ...] = ()

    def ratio_at(self, frequency: float) -> float:
        """Return ζ far above the modes that are listed, or at a frequency [Hz].

        Examples
        --------
        >>> round(DampingRatio((0.01, 0.02), (50.0, 200.0)).ratio_at(100.0), 6)
        0.015
        >>> DampingRatio((0.01, 0.02)).ratio_at(100.0)
        0.02
        """
        if not self.frequency:
            return self.ratio[-1]
        return float(self._interpolated(np.array([frequency]))[0])

    def of_modes(self, natural_frequency: Array) -> Array:
        """Return ζ of modes (n,) whose frequencies ascend [Hz]; one of 0 Hz moves rigidly.

        Examples
        --------
        >>> DampingRatio((0.01, 0.02)).of_modes(np.array([0.0, 30.0, 50.0, 70.0])).tolist()
        [0.01, 0.01, 0.02, 0.02]
        """
        if self.frequency:
            return self._interpolated(natural_frequency)
        number = np.cumsum(natural_frequency > 0) - 1
        return np.array(self.ratio)[np.clip(number, 0, len(self.ratio) - 1)]

    def times(self, factor: float) -> DampingRatio:
        """Return the same, multiplied by a factor."""
        return replace(self, ratio=tuple(factor * ratio for ratio in self.ratio))

    def smallest(self, low: float, high: float) -> float:
        """Return the smallest ζ of modes between two frequencies [Hz]."""
        if not self.frequency:
            return min(self.ratio)
        inside = [z for f, z in zip(self.frequency, self.ratio, strict=True) if low < f < high]
        return min(self.ratio_at(low), self.ratio_at(high), *inside)

    def _interpolated(self, frequency: Array) -> Array:
        log_f = np.log(self.frequency)
        return np.interp(np.log(np.maximum(frequency, self.frequency[0])), log_f, self.ratio)


def read_damping_ratio(path: Path) -> DampingRatio:
    """Read a CSV table with the columns ``frequency_hz`` and ``damping_ratio``.

    Raises
    ------
    ColumnsError
        If the file has faults; all are listed.
    """
    table = numbers(read_rows(path, COLUMNS), COLUMNS)
    table.refuse(fewest=1, too_few="no rows; at least one is needed")
    falls = np.diff(table["frequency_hz"], prepend=-np.inf) <= 0
    table.note(falls, "frequency_hz = {frequency_hz:g} must be above that of the row before")
    table.refuse()
    return DampingRatio(
        *(tuple(table[name].tolist()) for name in ("damping_ratio", "frequency_hz"))
    )
