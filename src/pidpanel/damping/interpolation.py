"""Values of scattered rows between the rows: along lines first, then from line to line.

A row is a point of up to three axes: fill fraction, amplitude and frequency. Rows of one fill and
one amplitude are a line along frequency; along it values are interpolated piecewise, then between
the two lines of neighbouring amplitudes, then between the two neighbouring fills. No full grid is
needed: every line has frequencies of its own. Where rows share fewer frequencies than amplitudes
the lines run along the amplitude instead. On a full grid both are the multilinear interpolation.

``log`` means ln of frequency, amplitude and value (the fill as it is):

    v = v₁ (v₂/v₁)^w,  w = ln(x/x₁)/ln(x₂/x₁),

and v = v₁ + w (v₂ − v₁) where a value is not positive: between two rows of a line if one of the
two is not, between two lines or two fills if any value of theirs is not. The rule is the same all
along both, so that values have no jump. ``linear`` means linear in all of them.

Beyond the first or last row of an axis values are constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from pidpanel.arrays import Array, Flags, Index

Interpolation = Literal["log", "linear"]

# Tolerance over the step between two coordinates, for rounding beyond the last row or next to one.
TOLERANCE = 1e-9


class _Line:
    """Rows, or lines of rows, along one axis.

    Parameters
    ----------
    grid
        (m,) rising; logarithms, where that is how the axis is taken.
    values
        (m, k) of the rows; empty where there are lines.
    lines
        (m) lines; empty where there are rows.
    log
        Whether values may be interpolated by their logarithm, where they are above 0.
    """

    def __init__(
        self, axis: int, grid: Array, values: Array, lines: tuple[_Line, ...], log: bool
    ) -> None:
        self.axis, self.grid, self.values, self.lines = axis, grid, values, lines
        positive = np.stack([line.log.all(axis=0) for line in lines]) if lines else values > 0
        self.log: Flags = positive & log  # (m, k) of the values at each coordinate

    def __call__(self, coordinates: Sequence[Array]) -> tuple[Array, Flags]:
        """Return values (n, k) at coordinates, (n,) for each axis, and whether inside (n,)."""
        low, weight, inside = _bracket(self.grid, coordinates[self.axis])
        high = np.minimum(low + 1, len(self.grid) - 1)
        log = self.log[low] & self.log[high]
        if not self.lines:
            first, second = self.values[low], self.values[high]
            return _interpolate(first, second, weight[:, None], log), inside
        # values (n, k) of the two lines next to each point
        first, second = np.empty((2, len(weight), self.log.shape[1]))
        for number in np.unique(np.concatenate([low, high])):
            # a line without weight is not evaluated
            lower, upper = (low == number) & (weight < 1), (high == number) & (weight > 0)
            points = lower | upper
            values, line_inside = self.lines[number]([c[points] for c in coordinates])
            first[lower], second[upper] = values[lower[points]], values[upper[points]]
            inside[points] &= line_inside
        first[weight == 1] = second[weight == 1]
        second[weight == 0] = first[weight == 0]
        return _interpolate(first, second, weight[:, None], log), inside


def _bracket(grid: Array, x: Array) -> tuple[Index, Array, Flags]:
    """Return the index (n,) of the coordinate below each x, weight of the next one, and inside."""
    if len(grid) == 1:
        return np.zeros(x.shape, dtype=np.int64), np.zeros(x.shape), np.abs(x - grid) <= TOLERANCE
    low = np.clip(np.searchsorted(grid, x, "right") - 1, 0, len(grid) - 2)
    weight = (x - grid[low]) / (grid[low + 1] - grid[low])
    inside = (weight >= -TOLERANCE) & (weight <= 1 + TOLERANCE)
    weight[weight < TOLERANCE] = 0.0
    weight[weight > 1 - TOLERANCE] = 1.0
    return low, weight, inside


def _interpolate(first: Array, second: Array, weight: Array, log: Flags) -> Array:
    """Return values between two, exact at both and where both are equal."""
    if not weight.any():  # as at a fill of the table
        return first
    ratio = np.divide(second, first, out=np.ones_like(first), where=log)
    value = np.where(log, first * ratio**weight, first + weight * (second - first))
    return np.asarray(np.where(weight == 1, second, value))


class Interpolator:
    """Values of rows over fill fraction, amplitude and frequency.

    Parameters
    ----------
    fill_fraction, amplitude, frequency
        (n,) of the rows; no two rows have all three in common.
    values
        (n, k).

    Attributes
    ----------
    depends_on_amplitude
        Whether a fill has rows of more than one amplitude. Rows of one amplitude hold for all.

    Examples
    --------
    >>> one = np.ones(2)
    >>> rows = Interpolator(one, one, np.array([100.0, 400.0]), np.array([[2.0], [8.0]]), "log")
    >>> rows(one, one, np.array([200.0, 500.0]))
    (array([[4.],
           [8.]]), array([ True, False]))
    """

    def __init__(
        self,
        fill_fraction: Array,
        amplitude: Array,
        frequency: Array,
        values: Array,
        interpolation: Interpolation,
    ) -> None:
        self._log = interpolation == "log"
        inner = inner_axis(fill_fraction, amplitude, frequency)
        rows = np.stack([fill_fraction, amplitude, frequency], axis=1)
        self.depends_on_amplitude = any(
            np.ptp(amplitude[fill_fraction == fill]) > 0 for fill in np.unique(fill_fraction)
        )
        self._whole = self._line(rows, values, (0, 3 - inner, inner))

    def __call__(
        self, fill_fraction: Array, amplitude: Array, frequency: Array
    ) -> tuple[Array, Flags]:
        """Return values (n, k) at points (n,), and whether they lie within the rows (n,)."""
        if self._log:
            amplitude, frequency = np.log(amplitude), np.log(frequency)
        return self._whole((fill_fraction, amplitude, frequency))

    def _line(self, rows: Array, values: Array, axes: tuple[int, ...]) -> _Line:
        """Return rows (n, 3) with values (n, k) as lines along the last of the axes.

        Those of a fill with one amplitude are along the frequency.
        """
        if len(axes) == 2 and np.ptp(rows[:, 1]) == 0:
            axes = (2,)
        axis, *further = axes
        levels = np.unique(rows[:, axis])
        coordinate = np.log(levels) if self._log and axis > 0 else levels
        if not further:
            return _Line(axis, coordinate, values[np.argsort(rows[:, axis])], (), self._log)
        groups = [rows[:, axis] == level for level in levels]
        lines = tuple(self._line(rows[i], values[i], tuple(further)) for i in groups)
        return _Line(axis, coordinate, np.empty((0, 0)), lines, self._log)


def inner_axis(fill_fraction: Array, amplitude: Array, frequency: Array) -> int:
    """Return the axis along which lines run: 2, frequency, or 1, amplitude; the fewer lines."""
    along_frequency = len({*zip(fill_fraction, amplitude, strict=True)})
    along_amplitude = len({*zip(fill_fraction, frequency, strict=True)})
    return 2 if along_frequency <= along_amplitude else 1


def lone_rows(fill_fraction: Array, amplitude: Array, frequency: Array) -> Index:
    """Return the rows that are alone in their line, where others have more along its axis.

    Such a row has information at its own point only, not between it and other lines.

    Examples
    --------
    >>> lone_rows(np.ones(3), np.array([1.0, 2.0, 3.0]), np.array([50.0, 60.0, 70.0]))
    array([0, 1, 2])
    """
    inner = inner_axis(fill_fraction, amplitude, frequency)
    outer, along = (amplitude, frequency) if inner == 2 else (frequency, amplitude)
    _, line, count = np.unique(
        np.stack([fill_fraction, outer], axis=1), axis=0, return_inverse=True, return_counts=True
    )
    if len(np.unique(along)) == 1:
        return np.zeros(0, dtype=int)
    return np.flatnonzero(count[line.ravel()] == 1)
