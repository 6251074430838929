"""Dampers, and what fills a patch.

The damping models are subclasses of `Damper`: coupled runs (`coupled`), the atlas (`atlas`), the
surface of simulated cases (`surface`), a table (`tables`), constants and the paper's law (`laws`).
`from_study` makes those of a study.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.damping.broadband import EXACT, BroadbandError

if TYPE_CHECKING:
    from pidpanel.damping.coupled import CoupledDamping

NODE_STEP = 0.17  # of ln f, between the nodes of the covariance; a quarter octave


class DampingError(ValueError):
    """No damping is available for this request."""


@dataclass(frozen=True)
class DampingValues:
    """C_e, its error and m_a at the requested frequencies."""

    # (n,) C_e and its standard error [N s/m³]
    equivalent_damping: Array
    equivalent_damping_error: Array
    apparent_mass: Array  # (n,) m_a [kg/m²]
    # (n,) False where the value is extrapolated beyond the range of the cases or rows
    inside: Flags


Point = tuple[float, float]  # fill fraction r and acceleration amplitude Γ of a patch


class Damper(ABC):
    """What fills a patch: C_e and m_a with their covariance, mass, own force."""

    depends_on_acceleration: bool = False  # whether C_e or m_a changes with Γ

    @property
    def broadband_error(self) -> BroadbandError:
        """Error under broadband motion."""
        return EXACT

    @property
    def nodes(self) -> Array | None:
        """(n,) rising [Hz], between which errors are linear in ln f; None without errors."""
        return None

    @property
    def coupled(self) -> CoupledDamping | None:
        """Coupled runs with an own force of the particles; None for none."""
        return None

    @abstractmethod
    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a of a patch.

        Parameters
        ----------
        frequency
            (n,) f [Hz].
        fill_fraction
            r [1].
        acceleration_g
            Γ [1], acceleration amplitude of the patch over g, for a sine.

        Raises
        ------
        DampingError
            If there is no damping there.
        """

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) between the values at two points.

        Rows are ln C_e, then m_a [kg/m²], at the frequencies (n,) [Hz] and the first point;
        columns the same at the other. With both points the same it is `covariance`. It is zero
        without errors.
        """
        return np.zeros((2 * len(frequency), 2 * len(frequency)))

    def covariance(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, then of m_a [kg/m²], at (n,) [Hz]."""
        point = (fill_fraction, acceleration_g)
        return self.cross_covariance(frequency, point, point)

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the damper [kg/m²], with or without m_a; NaN if not known."""
        return np.nan

    def is_hard(self, frequency: Array, acceleration_g: float) -> Flags:
        """Return whether the particles are as hard (n,) as the data assume."""
        return np.ones(len(frequency), np.bool_)

    def is_near_jump(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Flags:
        """Return where beds may ride or cross their gap, (n,)."""
        return np.zeros(len(frequency), np.bool_)

    def without_mass(self) -> Damper:
        """Return the same damping with m_a = 0, known exactly: a dashpot."""
        return Dashpot(self)


class Dashpot(Damper):
    """A damper whose m_a is zero, known exactly; it weighs as much as before."""

    broadband_error: BroadbandError = EXACT
    nodes: Array | None = None
    coupled: CoupledDamping | None = None

    def __init__(self, damper: Damper) -> None:
        self._damper = damper
        self.depends_on_acceleration = damper.depends_on_acceleration
        self.broadband_error, self.coupled = damper.broadband_error, damper.coupled
        if damper.nodes is not None:
            errors = damper(damper.nodes, 0.5, 1.0).equivalent_damping_error
            self.nodes = damper.nodes if errors.any() else None

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e, and m_a = 0; see `Damper`."""
        values = self._damper(frequency, fill_fraction, acceleration_g)
        return replace(values, apparent_mass=np.zeros_like(values.apparent_mass))

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) with zeros for m_a."""
        covariance, n = self._damper.cross_covariance(frequency, first, second), len(frequency)
        covariance[n:] = covariance[:, n:] = 0.0
        return covariance

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return what the damper weighs [kg/m²]."""
        return self._damper.mass_per_area(fill_fraction)

    def is_hard(self, frequency: Array, acceleration_g: float) -> Flags:
        """Return whether the particles are hard (n,)."""
        return self._damper.is_hard(frequency, acceleration_g)

    def is_near_jump(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Flags:
        """Return where beds may ride or cross their gap, (n,)."""
        return self._damper.is_near_jump(frequency, fill_fraction, acceleration_g)


class Tolerance(NamedTuple):
    """An input of a bed with its standard error: one unknown number for all frequencies."""

    source: str  # name of the input; loads of one source change together
    value: float
    error: float
    allowed: tuple[float, float]  # range of the atlas
    model_at: Callable[[float], tuple[Damper, float]]  # value → atlas and r

    def change(self, frequency: Array, acceleration_g: float) -> Array:
        """Return the change (2n,) of ln C_e, then of m_a [kg/m²], by one standard error at Γ.

        It is a central difference of the atlas, whatever the damping model of the bed.
        """
        ends = np.clip(self.value + np.array([-1, 1]) * self.error, *self.allowed)
        low, high = (
            model(frequency, fill, acceleration_g)
            for model, fill in map(self.model_at, ends.tolist())
        )
        # no change where neither dissipates
        logs = (np.log(np.maximum(end.equivalent_damping, 1e-3)) for end in (low, high))
        step = np.concatenate([-np.subtract(*logs), high.apparent_mass - low.apparent_mass])
        return np.asarray(step * self.error / (ends[1] - ends[0]))


# Γ at which the mass of a damper is taken before its motion is known.
MOTIONS_G = (1.0, 10.0, 100.0, 1000.0)


@dataclass(frozen=True, eq=False)
class FilledDamper:
    """A damper at the fill fraction of its patch."""

    name: str  # dampers of one name share their damping, and its errors
    model: Damper
    fill_fraction: float | None = None  # r; None where the damper has none
    # Γ at which it is evaluated whatever the motion; None for that of the motion
    stated_acceleration_g: float | None = None
    tolerances: tuple[Tolerance, ...] = ()  # errors of its particles and fill

    @property
    def fill(self) -> float:
        """Fill fraction; a full cell for dampers without one, which do not depend on it."""
        return 1.0 if self.fill_fraction is None else self.fill_fraction

    @property
    def depends_on_acceleration(self) -> bool:
        """Whether its damping follows the motion."""
        return self.model.depends_on_acceleration and self.stated_acceleration_g is None

    @property
    def mass_per_area(self) -> float:
        """Mass of the particles [kg/m²]; NaN where it is not known."""
        return self.model.mass_per_area(self.fill)

    def damping(self, frequency: Array, acceleration_g: float) -> tuple[Array, Array, Flags]:
        """Return C_e [N s/m³], m_a [kg/m²] and whether they are inside, (n,) each, at a Γ."""
        gamma = self.stated_acceleration_g or acceleration_g
        values = self.model(frequency, self.fill, gamma)
        return values.equivalent_damping, values.apparent_mass, values.inside

    def largest_mass(self, frequency: Array) -> float:
        """Return the largest of its mass and its apparent mass over frequency [kg/m²]."""
        motions = MOTIONS_G if self.model.depends_on_acceleration else MOTIONS_G[:1]
        apparent = [self.damping(frequency, gamma)[1].max() for gamma in motions]
        return float(np.nanmax([self.mass_per_area, *apparent]))


def correlated_covariance(first: Array, second: Array) -> Array:
    """Return the covariance (2n, 2n) of fully correlated errors (2n,) of ln C_e, then of m_a.

    Errors of ln C_e are common to all frequencies, as by a calibration. So are those of m_a, which
    are independent of them. No other correlation gives a larger error of an rms value to which all
    frequencies contribute equally.

    Examples
    --------
    >>> correlated_covariance(np.array([0.1, 2.0]), np.array([0.2, 3.0]))
    array([[0.02, 0.  ],
           [0.  , 6.  ]])
    """
    n = len(first) // 2
    covariance = np.zeros((len(first), len(first)))
    for half in (slice(None, n), slice(n, None)):
        covariance[half, half] = np.outer(first[half], second[half])
    return covariance
