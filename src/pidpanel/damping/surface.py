"""C_e(r, f, Γ) and m_a(r, f, Γ) from cases with errors: smooth but for one jump, with errors.

With W the amplitude of the motion and L the clear gap above the bed, both are written in the
dimensionless groups of hard spheres in a box under gravity, r, Γ and W/L:

    C_e = r f h exp g_C(r, ln Γ, ln W/L),      m_a = r [h g_m(r, ln Γ, ln W/L) + (1 − h) m₁],
    h = 1 − (Γ₀/Γ)² above the onset Γ₀, 0 below,

where m₁ is the mass of the particles per area and fill fraction, and h is the share of its largest
kinetic energy ½ m (ωW)² with which a bed leaves the floor, at the phase sin ωt = Γ₀/Γ: below the
onset the bed rides along, with all its mass and without dissipation.

A bed that is thrown and caught by the floor dissipates up to ten times less than one that crosses
the gap as one body, and between the two there is a jump (`jump`). So g_C and g_m are Gaussian
processes for the beds that ride, and for those that cross the closed form of the perfectly
inelastic body (`inelastic.slug`) with E(L/W) its loss and μ(L/W) its apparent mass,

    g_C = ln 2m₁E + g′_C,   g_m = m₁μ + g′_m,

with Gaussian processes g′ for what the beds differ by from it. Where the side is not known, the
mean of both is used, and their distance belongs to the error (`sides`). The side of a case follows
from its loss over that of the inelastic body (`surface_cases.UNDECIDED`). Without the depth of the
cell or the mass of the particles there is no closed form, and one process for all.

C_e is cut at the bound 4 m₁ r ω/π of an inelastic bed, or at the share of it that the cases
themselves reach (a single elastic sphere can exceed it).

How well that predicts cases left out is counted in docs/theory/damping.md.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from pidpanel.arrays import Array, Flags
from pidpanel.damping.broadband import SINGLE_TONES
from pidpanel.damping.jump import WHOLE, Jump
from pidpanel.damping.models import NODE_STEP, Damper, DampingValues, Point
from pidpanel.damping.sides import Mixture, Sides, even_steps, joint_covariance
from pidpanel.damping.surface_cases import (
    AXES,
    MASS,
    STROKE,
    VALUE,
    SurfaceBed,
    counted,
    logarithmic,
    onset,
    training_data,
)


class SimulatedRange:
    """The convex hull of cases, (n, 3) of r, f [Hz] and Γ, and their extreme values (3,)."""

    def __init__(self, cases: Array) -> None:
        self.low, self.high = cases.min(axis=0), cases.max(axis=0)
        points = logarithmic(cases)
        # axes along which the cases spread
        self._spread: Flags = np.ptp(points, axis=0) > 1e-9
        spread = points[:, self._spread]
        dimensions = spread.shape[1]
        if dimensions < 2:  # the lowest and highest value are all there is to a hull
            self._normals, self._offsets = np.zeros((1, dimensions)), np.full(1, -1.0)
            return
        # joggled, so that cases in one plane have a hull (of no volume) and no error
        flat = np.linalg.matrix_rank(spread - spread[0], tol=1e-6) < dimensions
        hull = ConvexHull(spread, qhull_options="QJ" if flat else "")
        self._normals, self._offsets = hull.equations[:, :-1], hull.equations[:, -1]

    def in_bounds(self, points: Array) -> Flags:
        """Return (n,) whether points (n, 3) of r, f, Γ are between the extreme values."""
        above, below = points >= self.low * (1 - 1e-9), points <= self.high * (1 + 1e-9)
        return np.asarray((above & below).all(axis=1))

    def contains(self, points: Array) -> Flags:
        """Return (n,) whether points (n, 3) of r, f, Γ are in the hull."""
        in_bounds = self.in_bounds(points)
        distance = logarithmic(points)[:, self._spread] @ self._normals.T + self._offsets
        return in_bounds & (distance <= 1e-6).all(axis=1)


# Probability of crossing from which a bed is known by the closed form at fills and Γ at which cases
# cross, though outside the hull of all; and the largest W/L, three times that of cases.
CERTAIN, LARGEST_STROKE = 0.99, 25.0

FREQUENCY_STEP = 0.04
# Steps of ln f and ln Γ between the values that are computed, with linear interpolation between
# them: ln C_e within 3e-3 in the paper's study away from the jump, a tenth of its standard error.
ACCELERATION_STEP = 0.05


class DampingSurface(Damper):
    """C_e and m_a over fill fraction, frequency and acceleration amplitude.

    Parameters
    ----------
    cases
        Rows used, with the columns of `surface_cases.counted`.
    bed
        Common properties of the cases. Without m₁ there is no bound, and m_a is 0 below the onset.
    damping, mass
        g_C and g_m; None for g_m = 0 everywhere.
    jump
        Stroke at which beds begin to cross; None for never.
    """

    broadband_error = SINGLE_TONES

    def __init__(
        self,
        cases: pd.DataFrame,
        bed: SurfaceBed,
        damping: Sides,
        mass: Sides | None,
        jump: Jump | None = None,
    ) -> None:
        self.cases = cases
        self.bed = bed
        self.damping = damping
        self.mass = mass
        self.jump = jump
        self._rest_mass = bed.mass_per_fill if np.isfinite(bed.mass_per_fill) else 0.0
        axes = cases[list(AXES)].to_numpy(float)
        self.simulated = SimulatedRange(axes)
        self.low, self.high = self.simulated.low, self.simulated.high
        self.depends_on_acceleration = bool(self.high[2] > self.low[2])
        share = cases[VALUE].to_numpy() / (axes[:, 0] * axes[:, 1])
        self.bound = max(8 * bed.mass_per_fill, float(share.max()))  # 4 ω/π = 8 f
        if not np.isfinite(bed.mass_per_fill):
            self.bound = np.inf
        nodes = np.log(self.low[1:]), np.log(self.high[1:])
        self.log_frequency = even_steps(nodes[0][0], nodes[1][0], FREQUENCY_STEP)
        self.log_acceleration = even_steps(nodes[0][1], nodes[1][1], ACCELERATION_STEP)
        self._rows: dict[tuple[float, int], tuple[Array, Array, Array, Array]] = {}

    @property
    def onset_g(self) -> float:
        """Γ₀ over g, below which the bed does not leave the floor."""
        return float(self.bed.onset_g)

    def crossing(self, points: Array) -> Array:
        """Return the probability (n,) that beds cross, at `groups` (n, 3)."""
        if self.jump is None:
            return np.zeros(len(points))
        return self.jump.probability(np.delete(points, STROKE, axis=1), self.bed.reached(points))

    def mixtures(
        self, points: Array, crossing: Array | None = None
    ) -> tuple[Mixture, Mixture | None]:
        """Return what is known of g_C and g_m at `groups` (n, 3), with `crossing` (n,) there."""
        if crossing is None:
            crossing = self.crossing(points)
        log_damping = mass = np.zeros(len(points))
        if self.jump is not None:
            log_damping, mass = self.bed.inelastic(points)
        restless, trend = self.bed.restless(points), self.bed.riding(points)
        damping = self.damping.mixture(points, crossing, log_damping, restless, trend)
        if self.mass is None:
            return damping, None
        return damping, self.mass.mixture(points, crossing, mass, np.zeros((2, len(points))))

    def evaluate(
        self, fill_fraction: ArrayLike, frequency: ArrayLike, acceleration_g: ArrayLike
    ) -> DampingValues:
        """Return C_e and m_a at points (n,) of r, f [Hz] and Γ.

        Beyond the lowest and highest r, f and Γ of the cases g_C and g_m are constant; below the
        lowest Γ, h continues towards the onset. Inside is the convex hull of the cases in r, ln f
        and ln Γ, and where beds are known to cross (`CERTAIN`) all between their extreme values at
        fills and Γ at which some case crosses: the mean is the closed form, and its error that of
        the process about it.
        """
        query = _points(*(np.asarray(a, float) for a in (fill_fraction, frequency, acceleration_g)))
        clipped = np.clip(query, self.low, self.high)
        return self._values(query, *self._read(self.bed.points(*clipped.T)))

    def _inside(self, query: Array, certainty: Array) -> Flags:
        """Return whether points (n, 3) are known, with `_read`'s certainty of crossing."""
        inside = self.simulated.contains(query)
        crosses = (certainty >= CERTAIN) & self.simulated.in_bounds(query)
        if self._crossing is not None and (crosses & ~inside).any():
            inside |= crosses & self._crossing.contains(_points(query[:, 0], 1.0, query[:, 2]))
        return inside

    @cached_property
    def _crossing(self) -> SimulatedRange | None:
        """Range in r and Γ of the cases that cross, at whatever frequency; None without any."""
        crosses = training_data(self.cases, self.bed).side == 1
        fill, _, gamma = self.cases.loc[crosses, list(AXES)].to_numpy(float).T
        return SimulatedRange(_points(fill, 1.0, gamma)) if crosses.any() else None

    def _read(self, points: Array) -> tuple[Array, Array, Array, Array]:
        """Return g_C, its error, g_m and P(crosses as the closed form) at `groups` (n, 3)."""
        damping, mass = self.mixtures(points)
        share = np.zeros(len(points)) if mass is None else mass.mean
        certainty = np.zeros(len(points))
        if self.jump is not None:
            stroke = np.exp(self.bed.log_stroke(points))
            certainty = damping.crossing * ((stroke >= WHOLE) & (stroke <= LARGEST_STROKE))
        return damping.mean, np.sqrt(self.damping.variance(damping)), share, certainty

    def _values(
        self, query: Array, log_damping: Array, relative: Array, share: Array, certainty: Array
    ) -> DampingValues:
        """Return C_e and m_a at points (n, 3), from what `_read` returns."""
        fill, frequency, _ = np.clip(query, self.low, self.high).T
        h = onset(query[:, 2], self.onset_g)
        largest = self.bound * fill * frequency
        damping = np.minimum(h * fill * frequency * np.exp(log_damping), largest)
        mass = fill * (h * share + (1 - h) * self._rest_mass)
        return DampingValues(damping, damping * relative, mass, self._inside(query, certainty))

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the particles [kg/m²], m₁ r; NaN where m₁ is not known."""
        return self.bed.mass_per_fill * fill_fraction

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz] for one fill and one amplitude Γ.

        Read from values computed once for each fill and Γ of a grid (`ACCELERATION_STEP`), since
        the search for the motion asks thousands of times. A surface of cases of one Γ answers with
        that Γ.
        """
        frequency = np.asarray(frequency, float)
        gamma = float(acceleration_g) if self.depends_on_acceleration else float(self.low[2])
        last = len(self.log_acceleration) - 1
        place = np.interp(np.log(gamma), self.log_acceleration, np.arange(last + 1))
        row = min(int(place), last - 1)
        weight = place - row
        log_frequency = np.log(np.clip(frequency, self.low[1], self.high[1]))
        lower, upper = (self._row(float(fill_fraction), index) for index in (row, row + 1))
        read = (
            np.interp(log_frequency, self.log_frequency, (1 - weight) * a + weight * b)
            for a, b in zip(lower, upper, strict=True)
        )
        return self._values(_points(float(fill_fraction), frequency, gamma), *read)

    def _row(self, fill: float, index: int) -> tuple[Array, Array, Array, Array]:
        """Return what `_read` does over ln f at one fill and one Γ of the grid."""
        if (fill, index) not in self._rows:
            frequency = np.exp(self.log_frequency)
            fills = np.full(frequency.shape, np.clip(fill, self.low[0], self.high[0]))
            gamma = np.full(frequency.shape, np.exp(self.log_acceleration[index]))
            self._rows[fill, index] = self._read(self.bed.points(fills, frequency, gamma))
        return self._rows[fill, index]

    @property
    def nodes(self) -> Array:
        """(n,) nodes of the covariance [Hz], uniform in ln f; between them it is nearly linear."""
        return np.exp(even_steps(np.log(self.low[1]), np.log(self.high[1]), NODE_STEP))

    def cross_covariance(
        self, frequency: Array, first: Point, second: Point, there: Array | None = None
    ) -> Array:
        """Return the covariance (2n, 2n) between the values at two points of r and Γ.

        Two patches filled with the same particles err alike where their fills and motions are
        alike. Rows are ln C_e, then m_a [kg/m²], at the first point, columns at the other,
        at frequencies ``there`` (n,) [Hz] if they differ.
        """
        p, scale = self._clip(frequency, *first)
        q, scale_there = self._clip(frequency if there is None else there, *second)
        (damping, mass), (damping_there, mass_there) = self.mixtures(p), self.mixtures(q)
        n = len(frequency)
        if self.mass is not None and mass is not None and mass_there is not None:
            result = joint_covariance(
                (self.damping, self.mass), (damping, mass), (damping_there, mass_there)
            )
        else:
            result = np.zeros((2 * n, 2 * n))
            result[:n, :n] = self.damping.covariance(damping, damping_there)
        result[n:] *= scale
        result[:, n:] *= scale_there
        return result

    def _clip(self, frequency: Array, fill: float, gamma: float) -> tuple[Array, float]:
        """Return the groups of points limited to the cases, and m_a per g_m there."""
        if not self.depends_on_acceleration:
            gamma = float(self.low[2])
        query = _points(fill, frequency, gamma)
        clipped = np.clip(query, self.low, self.high)
        return self.bed.points(*clipped.T), float(clipped[0, 0] * onset(gamma, self.onset_g))

    def leave_one_out(self) -> pd.DataFrame:
        """Return the cases with the error of ln C_e predicted by the others, and its size.

        The side is predicted too.
        """
        data = training_data(self.cases, self.bed)
        crossing = None if self.jump is None else self.jump.leave_one_out()
        damping, _ = self.mixtures(data.points, crossing)
        error, size = self.damping.leave_one_out(
            data.log_damping, data.log_error, data.side, damping
        )
        return self.cases.assign(log_error=error, log_standard_error=size)

    @staticmethod
    def from_frame(
        frame: pd.DataFrame, onset_g: float = 1.0, depth: float = np.nan
    ) -> DampingSurface:
        """Make the surface of rows such as those of ``coupon/cases.csv``.

        Parameters
        ----------
        frame
            Columns ``fill_fraction``, ``frequency_hz``, ``acceleration_g``,
            ``equivalent_damping_n_s_m3``; optional ``equivalent_damping_error_n_s_m3``,
            ``apparent_mass_kg_m2`` with ``apparent_mass_error_kg_m2`` (0 if left out),
            ``particle_mass_per_area_kg_m2`` (for the bound and the jump) and ``status``.
        onset_g
            Γ₀: gravity at the coupon over g; 0 for none.
        depth
            Depth of the cells [m]; NaN if not known, then there is no jump.

        Raises
        ------
        DampingError
            If a column is missing, a point is duplicated or no row is usable.
        """
        cases, mass_per_fill = counted(frame, onset_g)
        bed = SurfaceBed(onset_g, mass_per_fill, depth)
        data = training_data(cases, bed)
        mass = data.mass_sides() if (cases[MASS] != 0).any() else None
        return DampingSurface(cases, bed, data.damping_sides(), mass, data.jump())


def _points(*axes: ArrayLike) -> Array:
    """Return (n, 3) r, f, Γ; each may be one value."""
    return np.stack(np.broadcast_arrays(*axes), axis=1)
