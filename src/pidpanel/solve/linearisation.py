"""The motion at which the panel and its damper agree.

The panel sets the motion of a patch, and the motion sets the damping: C_e(f, Γ) peaks near
Γ = 2.5 and falls on both sides. Equivalent linearisation replaces the random motion of the patch
by the sine of the same rms,

    Γ = √2 a_rms / g,

where a_rms is the rms over time, over the patch and over the whole range of frequency, and asks
for a Γ that reproduces itself: Γ = Γ_out(C_e(Γ), m_a(Γ)).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY

DampingOfMotion = Callable[[Array, float], tuple[Array, Array, Flags]]
"""(frequency (nf,) [Hz], Γ) → C_e (nf,) [N s/m³], m_a (nf,) [kg/m²], within the simulated range
(nf,)."""

RmsOfDamping = Callable[[Array, Array], float]
"""(C_e (nf,), m_a (nf,)) → rms acceleration of the patch [m/s²]."""


class LinearisationError(RuntimeError):
    """No Γ was found at which motion and damping agree."""


class NoFixedPoint(LinearisationError):
    """Motion and damping agree nowhere in the range searched."""


class NotConverged(LinearisationError):
    """The search for Γ ended before its tolerance."""


@dataclass(frozen=True)
class FixedPoint:
    """One Γ at which the motion of the patch reproduces itself.

    Parameters
    ----------
    gamma
        Γ [1], amplitude of acceleration in g of the sine with the same rms.
    residual
        ln(Γ_out/Γ) there [1].
    stable
        Whether a small surplus of motion dies away: d ln Γ_out/d ln Γ < 1.
    within_domain
        Whether the damping data cover this Γ at all frequencies.
    equivalent_damping
        (nf,) C_e at this Γ [N s/m³].
    apparent_mass
        (nf,) m_a at this Γ [kg/m²].
    """

    gamma: float
    residual: float
    stable: bool
    within_domain: bool
    equivalent_damping: Array
    apparent_mass: Array


@dataclass(frozen=True)
class MotionSearch:
    """All Γ found, lowest first.

    Parameters
    ----------
    fixed_points
        At least one. Where C_e falls with Γ faster than the motion can follow there are three,
        and the middle one is unstable.
    iterations
        Number of responses computed.
    """

    fixed_points: tuple[FixedPoint, ...]
    iterations: int

    @property
    def governing(self) -> FixedPoint:
        """The highest: with several, history decides, and a design must bear the most motion."""
        return self.fixed_points[-1]


def sine_acceleration_g(acceleration_rms: float) -> float:
    """Return Γ = √2 a_rms/g from a_rms [m/s²].

    Examples
    --------
    >>> round(sine_acceleration_g(9.80665), 6)
    1.414214
    """
    return math.sqrt(2) * acceleration_rms / STANDARD_GRAVITY


def find_motions(
    frequency: ArrayLike,
    damping: DampingOfMotion,
    patch_acceleration_rms: RmsOfDamping,
    gamma_range: tuple[float, float] = (0.01, 1e4),
    scan_count: int = 31,
    tolerance: float = 1e-6,
) -> MotionSearch:
    """Return every Γ in a range at which the motion of one patch reproduces itself.

    h(x) = ln Γ_out(eˣ) − x is scanned at `scan_count` values even in x = ln Γ, and each change of
    sign is closed in by Brent's method: no damping factor to tune, and no root is lost for being
    repelling. Two roots between neighbouring scan values (a factor 1.58 by default) go unseen.

    Parameters
    ----------
    frequency
        (nf,) [Hz], handed to `damping`.
    damping
        C_e, m_a and the domain flag at a Γ.
    patch_acceleration_rms
        rms acceleration of the patch [m/s²] with that damping.
    gamma_range
        Lowest and highest Γ to search [1].
    scan_count
        Values of Γ in the scan, at least 2.
    tolerance
        Largest |ln(Γ_out/Γ)| accepted.

    Returns
    -------
    MotionSearch

    Raises
    ------
    NoFixedPoint
        Where Γ_out is above Γ, or below it, in the whole range.
    NotConverged
        Where a change of sign is a jump of Γ_out, not a root, or the search does not end.
    LinearisationError
        Where a response is not finite and positive.
    ValueError
        Where the range, the count or the tolerance make no search.
    """
    low, high = gamma_range
    if not (0 < low < high < math.inf and scan_count >= 2 and tolerance > 0):
        raise ValueError(
            f"gamma_range = {gamma_range!r}, scan_count = {scan_count!r}, "
            f"tolerance = {tolerance!r}: 0 < low < high, at least 2 and positive are needed"
        )
    lines = np.asarray(frequency, dtype=np.float64)
    iterations = 0

    def surplus(log_gamma: float) -> float:
        """h(x) = ln Γ_out − x."""
        nonlocal iterations
        iterations += 1
        gamma = math.exp(log_gamma)
        equivalent_damping, apparent_mass, _ = damping(lines, gamma)
        rms = patch_acceleration_rms(
            np.asarray(equivalent_damping, dtype=np.float64),
            np.asarray(apparent_mass, dtype=np.float64),
        )
        if not (math.isfinite(rms) and rms > 0):
            raise LinearisationError(
                f"the patch moves with an rms acceleration of {rms!r} m/s² at Γ = {gamma:g}: "
                "a finite, positive motion is needed"
            )
        return math.log(sine_acceleration_g(rms)) - log_gamma

    grid = np.linspace(math.log(low), math.log(high), scan_count).tolist()
    values = [surplus(x) for x in grid]
    points = [
        _close_in(surplus, (grid[i], grid[i + 1]), values[i] > 0, lines, damping, tolerance)
        for i in _sign_changes(values)
    ]
    if not points:
        side = "above" if values[0] > 0 else "below"
        raise NoFixedPoint(
            f"Γ_out is {side} Γ in the whole range {low:g} to {high:g}: from "
            f"{low * math.exp(values[0]):.3g} at Γ = {low:g} to "
            f"{high * math.exp(values[-1]):.3g} at Γ = {high:g}; widen gamma_range"
        )
    return MotionSearch(tuple(points), iterations)


def _sign_changes(values: Sequence[float]) -> list[int]:
    """Return each i where values[i] and values[i + 1] lie on different sides; 0 counts as below."""
    above = [value > 0 for value in values]
    return [i for i in range(len(above) - 1) if above[i] != above[i + 1]]


def _close_in(
    surplus: Callable[[float], float],
    bracket: tuple[float, float],
    falls: bool,
    lines: Array,
    damping: DampingOfMotion,
    tolerance: float,
) -> FixedPoint:
    """Return the root of h in a bracket; it is stable where h falls through zero."""
    root, report = brentq(
        surplus, *bracket, xtol=tolerance / 10, rtol=1e-14, full_output=True, disp=False
    )
    residual = surplus(root)
    gamma = math.exp(root)
    if not report.converged or abs(residual) > tolerance:
        raise NotConverged(
            f"near Γ = {gamma:g} ln(Γ_out/Γ) is {residual:.3g} after {report.iterations} steps, "
            f"more than {tolerance:g}: does C_e or m_a jump with Γ?"
        )
    equivalent_damping, apparent_mass, within = damping(lines, gamma)
    return FixedPoint(
        gamma=gamma,
        residual=residual,
        stable=falls,
        within_domain=bool(np.all(within)),
        equivalent_damping=np.asarray(equivalent_damping, dtype=np.float64),
        apparent_mass=np.asarray(apparent_mass, dtype=np.float64),
    )
