"""C_e and m_a of any particles in any cell, from simulated beds in dimensionless groups.

The bed of a closed cell is described by

    r, Γ, W/L, e, μ, width/d, depth/d and the direction of gravity,

with Γ over gravity, L = depth `clear_gap` and the diameter d. Density and size drop out: in units
of the mass of the particles per area, C_e/(m₁ f) and m_a/m₁ are functions of these groups. They
are those of `surface`, with the same closed forms, processes and jump in more dimensions. Beds
without gravity are excluded: at small strokes they float off the walls. docs/atlas.md has the
accuracy for held-out cases and the calibration of the errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pandas as pd

from pidpanel.arrays import Array, Flags
from pidpanel.atlas.groups import ElasticSphere, is_hard
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping import broadband
from pidpanel.damping.inelastic import LONGEST_GAP, slug, thrown_height
from pidpanel.damping.jump import Jump
from pidpanel.damping.models import Damper, DampingValues, Point
from pidpanel.damping.sides import Sides
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import CASE_COLUMNS, STROKE, SurfaceBed, clear_gap


def riding_trend(constants: Array, points: Array) -> Array:
    """Return ln 2πη (n,) of beds that ride, at `AtlasBed.points` (n, 9).

    With x = W/L, N = r depth/d layers and Γ over gravity, η = C_e/(m″ω) is near to

        A N^p Γ^−q μ^k + B x^s (N(1 − e²))^t N^v e^(wr).

    The first term is the bed that the floor throws and catches, or that slides on it where gravity
    is across the motion, with constants A and k of its own there. The second is the gas between
    both ends, whose agitation depends on N(1 − e²) (Kumaran, *Phys. Rev. E* 57, 5660 (1998)); it
    goes over into the loss of the inelastic body that crosses. What cases differ by from it is left
    to a Gaussian process.

    Parameters
    ----------
    constants
        (11,) of ``benchmarks/atlas_fit.py``.
    """
    fill, gamma, throw, loss, friction, width, layers, upright, _ = points.T
    friction = friction + width - layers + np.log(fill)  # ln μ
    a, p, q, k, across, k_across, b, s, t, v, w = constants
    thrown = a + p * layers - q * gamma + k * friction + upright * (across + k_across * friction)
    stroke = throw - gamma  # ln(W/L)
    gas = b + s * stroke + t * loss + v * layers + w * fill
    body, _ = slug(np.minimum(np.exp(-stroke), LONGEST_GAP))
    gas = -np.logaddexp(-gas, -np.log(body / np.pi))
    return np.asarray(np.log(2 * np.pi) + np.logaddexp(thrown, gas))


# Direction of gravity: along the motion, across it, or sin² of the angle between both.
Direction = Literal["flat", "upright"] | float
SHARES: dict[Direction, float] = {"flat": 0.0, "upright": 1.0}

# W/L up to which beds ride, and from which they cross; the errors are calibrated in three parts.
REGIMES = (0.1, 0.5)

# Degrees of freedom ν of Student's t for the errors. For held-out riding cases the 50 % and 90 %
# quantiles of |error of C_e| are 0.28 and 0.81 of the 95 % quantile (benchmarks/atlas.py); ν = 5
# gives 0.28 and 0.78, a normal distribution 0.34 and 0.84. Crossing beds and m_a have longer tails.
DOF = 5.0

# Factor of the error of ln C_e of beds that cross in nearly full cells, over r: 2.1 is the rms z of
# four cases outside the atlas at r = 0.79 to 0.95. Three others then have 0.8 (docs/particles.md).
# Under sound the errors are those of `broadband`.
NEARLY_FULL = ([0.7, 0.8], [1.0, 2.1])

# Columns of loss, friction, width and depth of the bed among the coordinates.
LOSS, FRICTION, WIDTH, DEPTH = 3, 4, 5, 6

# Correlation lengths of the jump, over the coordinates without the stroke.
JUMP_LENGTHS = np.array([0.3, 3.0, 4.0, 4.0, 3.0, 3.0, 1.0, np.inf])

# Columns of a case in dimensionless form.
COLUMNS = (
    "fill_fraction", "gamma", "stroke_per_gap", "loss_factor", "loss_factor_error", "mass_ratio",
    "mass_ratio_error",
)  # fmt: skip


@dataclass(frozen=True)
class AtlasBed(SurfaceBed):
    """A bed in the groups of the atlas; with arrays (n,), a bed for each case."""

    gravity: float | Array  # over g
    # (n, 5) or (1, 5) ln(1 − e²), ln μ, ln(width/d), ln(depth/d), sin⁴ of gravity to the motion
    shape: Array
    trend: Array | None = None  # (11,) constants of `riding_trend`; None for none

    @property
    def least_spread(self) -> float:
        """Least standard deviation of ln C_e about the trend, due to groups outside the trend."""
        return super().least_spread if self.trend is None else 0.5

    @property
    def floor_load(self) -> float:
        """How much the floor bears a single bed [1]; see `broadband.floor_load`."""
        return broadband.floor_load(float(self.onset_g), float(self.gravity))

    def riding(self, points: Array) -> Array | float:
        """Return the trend of ln C_e/(r f h) of riding beds at `points` (n, 9)."""
        return 0.0 if self.trend is None else riding_trend(self.trend, points)

    def points(self, fill_fraction: Array, frequency: Array, acceleration_g: Array) -> Array:
        """Return coordinates (n, 9): r, ln Γ, ln(Γ W/L), the shape, ln Γ/(N(1 − e²)).

        Γ W/L is twice the height of a bed thrown at ωW over the gap. The depth of the cell is
        replaced by that of the bed, N = r depth/d, and 1 − e² by the loss of a pulse through it,
        N(1 − e²), on which the agitation of a bed depends (Kumaran, *Phys. Rev. E* 57, 5660
        (1998)). μ is replaced by the load that the walls carry, μ depth/width (Janssen).
        """
        points = super().points(fill_fraction, frequency, acceleration_g)
        points[:, 1] -= np.log(self.gravity)
        points[:, STROKE] += np.log(STANDARD_GRAVITY / (4 * np.pi**2 * self.depth))
        shape = np.broadcast_to(self.shape, (len(points), self.shape.shape[1]))
        points[:, STROKE] += points[:, 1]
        points = np.hstack([points, shape])
        points[:, FRICTION] += points[:, DEPTH] - points[:, WIDTH]
        points[:, DEPTH] += np.log(fill_fraction)
        points[:, LOSS] += points[:, DEPTH]
        return np.column_stack([points, points[:, 1] - points[:, LOSS]])

    def log_stroke(self, points: Array) -> Array:
        """Return ln(W/L) (n,) of `points` (n, 9)."""
        return np.asarray(points[:, STROKE] - points[:, 1])

    def reached(self, points: Array) -> Array:
        """Return ln(W/L) (n,) at `points` (n, 9), −∞ where a thrown body misses the lid."""
        log_stroke, along = self.log_stroke(points), np.divide(self.onset_g, self.gravity)
        gamma = np.maximum(np.exp(points[:, 1]) / np.where(along > 0, along, 1.0), 1.0)
        height = np.where(along > 0, thrown_height(gamma), np.inf)
        return np.where(height > np.exp(-log_stroke), log_stroke, -np.inf)


def atlas_bed(
    restitution: float | Array,
    friction: float | Array,
    width: float | Array,
    depth: float | Array,
    diameter: float | Array,
    direction: Sequence[Direction],
    gravity: float | Array = 1.0,
) -> AtlasBed:
    """Return the bed of a coupon, or one for each case, with m₁ = 1.

    Parameters
    ----------
    restitution, friction
        e and μ of particles and walls [1].
    width, depth, diameter
        Cell width across flats, cell depth, particle diameter [m].
    direction
        Direction of gravity for each case. Between flat and upright, sin⁴ of the angle is the
        coordinate (the best of sin² to sin⁶ for 22 cases, docs/particles.md), and Γ₀ is the
        component along the motion.
    gravity
        Gravity in units of g [1].
    """
    across = np.array([SHARES.get(name, name) for name in direction], float)
    shape = np.column_stack(
        np.broadcast_arrays(
            np.log1p(-np.square(restitution)), np.log(friction), np.log(np.divide(width, diameter)),
            np.log(np.divide(depth, diameter)), across**2,
        )
    ).astype(float)  # fmt: skip
    onset = gravity * np.sqrt(1 - across)
    if len(across) == 1:
        return AtlasBed(float(onset[0]), 1.0, depth, gravity, shape)
    return AtlasBed(onset, 1.0, depth, gravity, shape)


@dataclass(frozen=True)
class Atlas:
    """Simulated beds in dimensionless groups, and the processes between them."""

    cases: pd.DataFrame  # a row for each state of each case used
    damping: Sides  # ln C_e/(m₁ r f h)
    mass: Sides  # m_a/(m₁ r), less its value below the onset
    jump: Jump | None
    # Calibration of the standard errors of ln C_e and of m_a in the three parts of `REGIMES`
    calibration: Array  # (2, 3)
    # Scale of Student's t with `DOF` degrees of freedom over the calibrated errors
    student_scale: Array  # (2, 3)
    bulk: Array  # (3,) of `bulk_fraction`
    trend: Array  # (11,) of `riding_trend`
    version: str

    def bulk_fraction(self, width: float, depth: float) -> float:
        """Return the volume of poured particles over that of their cell [1].

        It is c₀ + c₁ d/width + c₂ d/depth, with width and depth over the diameter d.
        """
        return float(self.bulk @ [1.0, 1 / width, 1 / depth])

    def damping_of(self, bed: AtlasBed, mass_per_fill: float) -> AtlasDamping:
        """Return C_e and m_a of the particles in a cell.

        Parameters
        ----------
        bed
            Bed of the coupon.
        mass_per_fill
            m₁, mass of the particles per area and fill fraction [kg/m²].
        """
        cases, bed = dimensional(self.cases, bed.depth, bed.gravity), replace(bed, trend=self.trend)
        surface = DampingSurface(cases, bed, self.damping, self.mass, self.jump)
        return AtlasDamping(surface, bed, mass_per_fill, self.calibration)


def dimensional(
    cases: pd.DataFrame, depth: float | Array, gravity: float | Array = 1.0
) -> pd.DataFrame:
    """Return the cases for one cell, with m₁ = 1, in the columns of `surface_cases.counted`.

    Parameters
    ----------
    cases
        Columns ``fill_fraction``, ``gamma``, ``stroke_per_gap``, and ``loss_factor`` and
        ``mass_ratio`` with their errors.
    depth
        Cell depth [m], one or (n,).
    gravity
        Gravity in units of g [1].
    """
    fill, gamma, stroke, loss, loss_error, mass, mass_error = cases[list(COLUMNS)].to_numpy(float).T
    gamma = gamma * gravity
    frequency = np.sqrt(gamma * STANDARD_GRAVITY / (stroke * clear_gap(fill) * depth)) / (2 * np.pi)
    damping = 2 * np.pi * frequency * fill  # C_e of η = 1
    results = (damping * loss, damping * loss_error, fill * mass, fill * mass_error)
    return pd.DataFrame(dict(zip(CASE_COLUMNS, (fill, frequency, gamma, *results), strict=True)))


def dimensionless(
    cases: pd.DataFrame, depth: float | Array, gravity: float | Array, mass_per_fill: float
) -> pd.DataFrame:
    """Return cases of a cell in dimensionless form; the inverse of `dimensional` for m₁ = 1."""
    fill, frequency, gamma, *results = cases[CASE_COLUMNS].to_numpy(float).T
    omega = 2 * np.pi * frequency
    stroke = gamma * STANDARD_GRAVITY / (omega**2 * clear_gap(fill) * depth)
    mass = mass_per_fill * fill
    units = [mass * omega, mass * omega, mass, mass]
    values = [fill, gamma / gravity, stroke, *np.divide(results, units)]
    return pd.DataFrame(dict(zip(COLUMNS, values, strict=True)))


@dataclass(frozen=True)
class AtlasDamping(Damper):
    """C_e and m_a of one coupon; see `models.Damper`."""

    surface: DampingSurface  # with m₁ = 1
    bed: AtlasBed
    mass_per_fill: float  # m₁ [kg/m²]
    calibration: Array  # (2, 3) factors of standard errors
    is_broadband: bool = False  # whether C_e is for sound, not for a tone
    sphere: ElasticSphere | None = None  # a particle; None if softness is neglected
    depends_on_acceleration = True

    @property
    def broadband_error(self) -> broadband.BroadbandError:
        """Error under broadband motion."""
        return broadband.CORRECTED_TONES if self.is_broadband else broadband.SINGLE_TONES

    @property
    def nodes(self) -> Array:
        """(n,) nodes of the covariance [Hz]."""
        return self.surface.nodes

    def stroke_per_gap(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> Array:
        """Return W/L (n,) of the sine at frequencies (n,) [Hz]."""
        fill, gamma = (np.full(len(frequency), x) for x in (fill_fraction, acceleration_g))
        points = self.bed.points(fill, np.asarray(frequency, float), gamma)
        return np.exp(self.bed.log_stroke(points))

    def is_hard(self, frequency: Array, acceleration_g: float) -> Flags:
        """Return whether the particles are hard (n,) at frequencies (n,) [Hz]."""
        if self.sphere is None:
            return np.ones(len(frequency), bool)
        return is_hard(self.sphere, frequency, acceleration_g, float(self.bed.gravity))

    def is_near_jump(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Flags:
        """Return whether W/L is between `REGIMES`, where beds may ride or cross, (n,)."""
        _, stroke = self._tone(frequency, fill_fraction, acceleration_g)
        return np.asarray((stroke > REGIMES[0]) & (stroke < REGIMES[1]))

    def _tone(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> tuple[Array, Array]:
        """Return frequency [Hz] and W/L of the tones whose damping it has (n,)."""
        stroke = self.stroke_per_gap(frequency, fill_fraction, acceleration_g)
        if not self.is_broadband:
            return frequency, stroke
        shorter = broadband.broadband_stroke(stroke)
        return frequency * np.sqrt(stroke / shorter), shorter

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz]."""
        tone, stroke = self._tone(frequency, fill_fraction, acceleration_g)
        values = self.surface(tone, fill_fraction, acceleration_g)
        unit = np.full(stroke.shape, self.mass_per_fill)
        if self.is_broadband:
            unit *= broadband.broadband_share(stroke, fill_fraction, self.bed.floor_load)
        return DampingValues(
            unit * values.equivalent_damping,
            unit
            * np.hypot(
                self._factors(stroke, fill_fraction)[0] * values.equivalent_damping_error,
                self._share_error(stroke) * values.equivalent_damping,
            ),
            self.mass_per_fill * values.apparent_mass,
            values.inside & self.is_hard(frequency, acceleration_g),
        )

    def _factors(self, stroke: Array, fill_fraction: float) -> Array:
        """Return the calibration (2, n) of the standard errors of ln C_e and m_a at W/L (n,)."""
        factors = self.calibration[:, np.digitize(stroke, REGIMES)]
        if not self.is_broadband:
            factors[0, stroke > REGIMES[1]] *= np.interp(fill_fraction, *NEARLY_FULL)
        return np.asarray(factors)

    def _share_error(self, stroke: Array) -> Array:
        """Return the error of ln C_e (n,) that the share under sound has, at W/L (n,)."""
        return self.is_broadband * broadband.broadband_share_error(stroke, self.bed.floor_load)

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) between the values at two points of r and Γ."""
        scale = np.array([[1.0], [self.mass_per_fill]])
        (tone, stroke), (there, stroke_there) = (
            self._tone(frequency, *point) for point in (first, second)
        )
        rows = (scale * self._factors(stroke, first[0])).ravel()
        columns = (scale * self._factors(stroke_there, second[0])).ravel()
        covariance = self.surface.cross_covariance(tone, first, second, there)
        covariance *= np.outer(rows, columns)
        n = len(frequency)
        covariance[:n, :n] += np.outer(*map(self._share_error, (stroke, stroke_there)))
        return covariance

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the particles [kg/m²]."""
        return self.mass_per_fill * fill_fraction

    def under_sound(self) -> AtlasDamping:
        """Return the same with C_e and m_a under sound, see `broadband.broadband_stroke`."""
        return replace(self, is_broadband=True)
