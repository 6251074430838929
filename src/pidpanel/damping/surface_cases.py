"""Cases of a surface: their selection, and the processes trained on them."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Flags, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping import gaussian_process
from pidpanel.damping.gaussian_process import GaussianProcess
from pidpanel.damping.inelastic import LONGEST_GAP, slug
from pidpanel.damping.jump import LENGTHS, WHOLE, Jump, reach
from pidpanel.damping.models import DampingError
from pidpanel.damping.sides import Sides

AXES = ("fill_fraction", "frequency_hz", "acceleration_g")
VALUE, ERROR = "equivalent_damping_n_s_m3", "equivalent_damping_error_n_s_m3"
MASS, MASS_ERROR = "apparent_mass_kg_m2", "apparent_mass_error_kg_m2"
PARTICLE_MASS = "particle_mass_per_area_kg_m2"
CASE_COLUMNS = [*AXES, VALUE, ERROR, MASS, MASS_ERROR]  # columns of the cases used

# Status of the rows used; those that are not steady have enlarged errors.
COUNTED = ("ok", "NotSteady")

STROKE = 2  # column of `groups` with the stroke

# Height of a bed pressed onto a wall over that as poured: from W/L = 0.4 on beds that cross then
# dissipate what the inelastic body does within 12 % up to r = 0.7, and 12 % rms at 0.9 (19 cases of
# the paper's and launch studies; with 1 they are up to twice as lossy at 0.9).
PRESSED = 0.94

# Shares of the loss of the inelastic body below which beds next to the jump ride and above which
# they cross. Riding beds dissipate 0.07 to 0.2 of it, crossing ones 0.7 and more. The few between
# (0.44 and 0.49, of 40 near the jump) alternate; they locate the jump, but belong to neither side.
UNDECIDED = (0.3, 0.6)

# u of `jump.reach` below which beds ride, whatever they dissipate: that of the inelastic body
# that just meets both walls in every cycle, less a tenth, to which the gap is known.
LOWEST_REACH = np.log(0.9 / LONGEST_GAP)

# Scatter of ln C_e next to the jump, on either side, in addition to that of packings. Beds have
# several motions there (every second or third cycle differs from the last): 24 tones a few per
# cent apart in f, r or Γ scatter by 0.2 to 0.3 rms.
RESTLESS = 0.25

RIDING_RESTLESS = (0.06, 0.15)
# W/L at which beds are quiet, and from which on they are as restless as `RESTLESS`; linear in
# ln(W/L) between.
CROSSING_RESTLESS = (0.45, 0.33)

# Least standard deviation of ln C_e/(r f) and of m_a/(r m₁) of riding beds, used if the cases do
# not give a larger one (1.4 and 0.05 in the launch study).
LEAST_SPREAD, LEAST_MASS_SPREAD = 1.0, 0.05

# Unit of the priors for the difference of crossing beds from the inelastic body, in ln C_e and in
# m_a/m₁: 8 % if the gap above them is well known, up to a factor of two in nearly full cells.
UNIT = 0.2

# Refits of a process with less weight on outliers: largest number, and relative change of the
# constants at which they end.
REFITS, SETTLED = 20, 0.01

# Lengths, size and scatter (d + 2,) of the process of each side of a quantity.
Constants = tuple[Array, Array | None]


def onset(acceleration_g: ArrayLike, onset_g: ArrayLike) -> Array:
    """Return h = 1 − (Γ₀/Γ)² above the onset, 0 below.

    Examples
    --------
    >>> onset([0.5, 1.0, 2.0], 1.0)
    array([0.  , 0.  , 0.75])
    """
    ratio = np.divide(onset_g, acceleration_g)
    return np.asarray(np.maximum(1 - ratio**2, 0.0))


def clear_gap(fill_fraction: Array) -> Array:
    """Return the gap L above a bed over the depth of its cell, 1 − 0.94 r.

    Examples
    --------
    >>> clear_gap(np.array([0.0, 0.5, 1.0]))
    array([1.  , 0.53, 0.06])
    """
    return np.asarray(1 - PRESSED * fill_fraction)


def groups(fill_fraction: Array, frequency: Array, acceleration_g: Array) -> Array:
    """Return (n, 3) r, ln Γ and ln(W/L) up to a constant."""
    gamma, gap = np.log(acceleration_g), np.log(clear_gap(fill_fraction))
    return np.stack([fill_fraction, gamma, gamma - 2 * np.log(frequency) - gap], axis=1)


@dataclass(frozen=True)
class SurfaceBed:
    """Common properties of the cases of a surface: Γ₀, m₁ [kg/m²], depth [m]; NaN if unknown.

    Γ₀ and depth are arrays (n,) where cases of several beds make one surface (`atlas`).
    """

    onset_g: float | Array
    mass_per_fill: float
    depth: float | Array

    @property
    def jumps(self) -> bool:
        """Whether enough is known for the closed form of the bed that crosses."""
        return bool(np.isfinite(self.depth).all() and np.isfinite(self.mass_per_fill))

    def points(self, fill_fraction: Array, frequency: Array, acceleration_g: Array) -> Array:
        """Return coordinates (n, 3) of the processes, `groups`."""
        return groups(fill_fraction, frequency, acceleration_g)

    def log_stroke(self, points: Array) -> Array:
        """Return ln(W/L) (n,) of `groups` (n, 3), with L = depth `clear_gap`."""
        return np.asarray(points[:, 2] + np.log(STANDARD_GRAVITY / (4 * np.pi**2 * self.depth)))

    def reached(self, points: Array) -> Array:
        """Return u (n,) of `jump.reach` at `groups` (n, 3)."""
        return reach(self.log_stroke(points), points[:, 1], self.onset_g)

    def restless(self, points: Array) -> Array:
        """Return more scatter (2, n) of ln C_e of riding and crossing beds at `groups` (n, 3)."""
        result = np.zeros((2, len(points)))
        if self.jumps:
            stroke = self.log_stroke(points)
            for side, (quiet, next_to) in enumerate((RIDING_RESTLESS, CROSSING_RESTLESS)):
                share = (stroke - np.log(quiet)) / np.log(next_to / quiet)
                result[side] = RESTLESS * np.clip(share, 0.0, 1.0)
        return result

    @property
    def least_spread(self) -> float:
        """`LEAST_SPREAD` of ln C_e/(r f) about `riding`."""
        return LEAST_SPREAD

    def riding(self, points: Array) -> Array | float:
        """Return the trend of ln C_e/(r f h) of riding beds at `groups` (n, 3)."""
        return 0.0

    def inelastic(self, points: Array) -> tuple[Array, Array]:
        """Return ln 2m₁E and m₁μ (n,) at `groups` (n, 3), constant beyond the largest L/W.

        C_e = m₁ r ω E/π = 2 m₁ E r f.
        """
        energy, mass = slug(np.minimum(np.exp(-self.log_stroke(points)), LONGEST_GAP))
        return np.log(2 * self.mass_per_fill * energy), self.mass_per_fill * mass


@dataclass(frozen=True)
class TrainingData:
    """Training data from the cases: points, values and sides."""

    bed: SurfaceBed
    points: Array  # (n, 3) `groups` of the cases
    side: Array  # (n,) 1 of beds that cross, 0 of those that ride, 0.5 of those between
    # (n,) g_C and its error
    log_damping: Array
    log_error: Array
    # (2, n) their errors in the means of riding and of crossing beds
    side_error: Array
    # (n,) g_m and its error
    mass: Array
    mass_error: Array
    spread: Array | None = None  # (d,) that measures the lengths; None for that of the points
    # (n,) cases with less weight because others predict them badly; None for none
    outliers: Flags | None = None

    def jump(self, lengths: Array = LENGTHS) -> Jump | None:
        """Return the jump that separates the cases; None if there is none."""
        if not self.bed.jumps:
            return None
        points = np.delete(self.points, STROKE, axis=1)
        return Jump(points, self.bed.reached(self.points), self.side, lengths)

    def damping_sides(self, constants: Constants | None = None) -> Sides:
        """Return g_C, fitted or with the constants of a fit."""
        trend = self.bed.riding(self.points)
        expected = self.bed.inelastic(self.points)[0] - trend if self.bed.jumps else None
        values, spread = self.log_damping - trend, self.bed.least_spread
        return self._sides(values, self.side_error, expected, 1.0, spread, constants)

    def mass_sides(self, constants: Constants | None = None) -> Sides:
        """Return g_m, fitted or with the constants of a fit."""
        expected = self.bed.inelastic(self.points)[1] if self.bed.jumps else None
        unit = self.bed.mass_per_fill
        errors = np.stack([self.mass_error, self.mass_error])
        return self._sides(self.mass, errors, expected, unit, LEAST_MASS_SPREAD, constants)

    def _sides(
        self,
        values: Array,
        errors: Array,
        expected: Array | None,
        unit: float,
        smallest_spread: float,
        constants: Constants | None,
    ) -> Sides:
        """Return the processes of values whose ``expected`` is known where beds cross.

        Lengths are measured by the points of both sides, beds that ride by how their own values
        spread, but no less than ``smallest_spread``, in ``unit``; where there are none they are
        expected about those that cross.
        """
        axes = gaussian_process.spreads(self.points) if self.spread is None else self.spread

        def process(
            rows: Flags, values: Array, prior: tuple[float, float] | None, side: int
        ) -> GaussianProcess:
            points, known, error = self.points[rows], values[rows], errors[side][rows]
            centre, size = prior or (None, None)
            among = np.zeros(len(known), bool) if self.outliers is None else self.outliers[rows]

            def fitted(error: Array, near: GaussianProcess | None = None) -> GaussianProcess:
                return gaussian_process.fit(
                    points, known, error, axes=axes, centre=centre, unit=size, near=near
                )

            if constants is not None:
                *lengths, scale, scatter = np.asarray(constants[side])
                process = GaussianProcess(
                    points, known, error, np.array(lengths), float(scale), float(scatter), centre,
                    size,
                )  # fmt: skip
                return process.with_weaker_outliers(among)
            process = fitted(error)
            for _ in range(REFITS if among.any() else 0):
                last = process
                weaker = fitted(last.with_weaker_outliers(among).error, last)
                process = replace(weaker, error=error)
                if np.abs(np.log(process.constants / last.constants)).max() < SETTLED:
                    break
            return process.with_weaker_outliers(among)

        rides = self.side == 0
        if expected is None:
            return Sides(process(rides, values, None, 0))
        # few beds that ride may be alike by chance; C_e of others is up to a hundred times another
        size = max(float(np.std(values[rides])), smallest_spread * unit) if rides.any() else unit
        centre = float(np.mean(values[rides])) if rides.any() else float(expected.mean())
        return Sides(
            process(rides, values, (centre, size), 0),
            process(self.side == 1, values - expected, (0.0, UNIT * unit), 1),
        )


def training_data(cases: pd.DataFrame, bed: SurfaceBed) -> TrainingData:
    """Return what the rows of `counted` teach.

    C_e = r f h e^g, so δg = δC/C; m_a = r [h g + (1 − h) m₁], so δg = δm/(r h).
    """
    columns = cases[CASE_COLUMNS].to_numpy(float).T
    fill, frequency, gamma, value, error, mass, mass_error = columns
    points, h = bed.points(fill, frequency, gamma), onset(gamma, bed.onset_g)
    bed_mass = bed.mass_per_fill if np.isfinite(bed.mass_per_fill) else 0.0
    log_damping = np.log(value / (h * fill * frequency))
    side = np.zeros(len(cases))
    if bed.jumps:
        side = _side(np.exp(log_damping - bed.inelastic(points)[0]), bed.reached(points))
    return TrainingData(
        bed=bed,
        points=points,
        side=side,
        log_damping=log_damping,
        log_error=error / value,
        side_error=np.hypot(error / value, bed.restless(points)),
        mass=(mass / fill - (1 - h) * bed_mass) / h,
        mass_error=mass_error / (fill * h),
    )


def _side(share: Array, reached: Array) -> Array:
    """Return the side (n,) of cases by their share of the inelastic loss and u of `jump.reach`.

    Below the least stroke with which that body meets both walls in every cycle beds ride, whatever
    they dissipate, and from `jump.WHOLE` on there is no between.
    """
    low, high = UNDECIDED
    near = reached < np.log(WHOLE)
    side = np.where(share > np.where(near, high, low), 1.0, 0.0)
    side[near & (share > low) & (share <= high)] = 0.5
    return np.where(reached > LOWEST_REACH, side, 0.0)


def counted(frame: pd.DataFrame, onset_g: float) -> tuple[pd.DataFrame, float]:
    """Return the usable rows of a table, and m₁ [kg/m²], NaN if not known.

    Rows count whose status is one of `COUNTED`, whose C_e exceeds its own error (a value that does
    not has no logarithm to speak of) and whose Γ is above the onset; of very many those that are
    spread over all of them (`spread_out`). A `DampingError` says that a column is missing, a point
    is duplicated or no row counts.
    """
    for column in (*AXES, VALUE):
        if column not in frame:
            raise DampingError(f"column {column} is missing; there are {', '.join(frame.columns)}")
    frame = frame.assign(**{c: 0.0 for c in (ERROR, MASS, MASS_ERROR) if c not in frame})
    if frame.duplicated(list(AXES)).any():
        twice = frame[frame.duplicated(list(AXES))].iloc[0]
        raise DampingError(
            "duplicate rows at " + ", ".join(f"{axis} = {twice[axis]:g}" for axis in AXES)
        )
    good = frame[frame["status"].isin(COUNTED)] if "status" in frame else frame
    good = good[(good[VALUE] > good[ERROR]) & (good["acceleration_g"] > onset_g)]
    if not len(good):
        raise DampingError(
            f"{len(good)} of {len(frame)} rows count (status {' or '.join(COUNTED)}, C_e above "
            f"its error, acceleration_g above {onset_g:g}): at least 1 is needed"
        )
    mass_per_fill = np.nan
    if PARTICLE_MASS in good:
        mass_per_fill = float((good[PARTICLE_MASS] / good["fill_fraction"]).median())
    if len(good) > MOST_CASES:
        points = logarithmic(good[list(AXES)].to_numpy(float))
        good = good.iloc[spread_out(points / gaussian_process.spreads(points), MOST_CASES)]
    return good[CASE_COLUMNS].astype(float).reset_index(drop=True), mass_per_fill


def logarithmic(points: Array) -> Array:
    """Return (n, 3) r, f, Γ → r, ln f, ln Γ."""
    return np.column_stack([points[:, 0], np.log(points[:, 1:])])


MOST_CASES = 600  # cases of a surface at most: `paper.yaml` has 90 of them, `paper_full.yaml` 2955


def spread_out(points: Array, limit: int) -> Index:
    """Return the numbers, in order, of points that are spread over all of them.

    A Gaussian process takes memory with the square and time with the cube of its cases. Of more
    than `MOST_CASES` those enter that are farthest from the ones before (Gonzalez, *Theoretical
    Computer Science* 38, 293 (1985)): the ends of the sweep first, then ever finer, so that no case
    is farther from one that entered than twice what the best choice of as many could give. A case
    that enters is as it was run, with its own error; what a surface states as its error is at no
    point less than the scatter of cases, however many there are, so that those left out would
    narrow it little.

    Examples
    --------
    >>> spread_out(np.array([[0.0], [1.0], [2.1], [3.0], [4.0]]), 3)
    array([0, 2, 4])
    """
    if len(points) <= limit:
        return np.arange(len(points))
    # the farthest from the middle, the first of several: the same on every machine
    nearest = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    chosen = [int(np.argmax(nearest.round(9)))]
    nearest[:] = np.inf
    while len(chosen) < limit:
        nearest = np.minimum(nearest, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest.round(9))))
    return np.sort(np.array(chosen))
