"""One question, several answers: C_e and m_a at these frequencies, this fill and this motion.

A reading of the damping is a callable that answers it: the surface of simulated cases (`surface`),
a table (`tables`), constants and the paper's law (`laws`). `from_study` makes the
readings that a study names.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.damping.broadband import BroadbandError

NODE_STEP = 0.17  # of ln f, between the nodes of the covariance; a quarter octave


class DampingError(ValueError):
    """A question that a law or table of damping has no answer to."""


@dataclass(frozen=True)
class DampingValues:
    """C_e, its error and m_a at the frequencies asked."""

    # (n,) C_e and its standard error [N s/m³]
    equivalent_damping: Array
    equivalent_damping_error: Array
    apparent_mass: Array  # (n,) m_a [kg/m²]
    # (n,) False where the value is extrapolated beyond the range of the cases or rows
    inside: Flags


Point = tuple[float, float]  # fill fraction r and acceleration amplitude Γ at which a patch is read


class DampingReading(Protocol):
    """An answer to the question."""

    depends_on_acceleration: bool  # whether C_e or m_a changes with Γ

    @property
    def broadband_error(self) -> BroadbandError:
        """Error under broadband motion."""

    @property
    def nodes(self) -> Array | None:
        """(n,) rising [Hz], between which errors are linear in ln f; None where there are none."""

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
            Γ [1], amplitude of the acceleration of the patch over g, of a sine.

        Raises
        ------
        DampingError
            Where the reading has no answer.
        """

    def covariance(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, then of m_a [kg/m²], at (n,) [Hz].

        Zero where there are no errors.
        """
        point = (fill_fraction, acceleration_g)
        return self.cross_covariance(frequency, point, point)

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) between what is read at two points.

        Rows are ln C_e, then m_a [kg/m²], at the frequencies (n,) [Hz] and the first point;
        columns the same at the other. With both points the same it is `covariance`.
        """

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return what the damper weighs [kg/m²], whether or not m_a counts; NaN if not known."""

    def without_mass(self) -> DampingReading:
        """Return the same damping with m_a = 0, known exactly: a dashpot."""


def correlated_covariance(first: Array, second: Array) -> Array:
    """Return the covariance (2n, 2n) of fully correlated errors (2n,) of ln C_e, then of m_a.

    All those of ln C_e err together, as by a calibration, and all those of m_a, independently of
    each other: of all correlations the one with the largest error of an rms value to which every
    frequency contributes alike.

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
