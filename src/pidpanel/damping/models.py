"""Interface of damping models.

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


class DampingModel(Protocol):
    """C_e and m_a of a patch, with their covariance."""

    depends_on_acceleration: bool  # whether C_e or m_a changes with Γ

    @property
    def broadband_error(self) -> BroadbandError:
        """Error under broadband motion."""

    @property
    def nodes(self) -> Array | None:
        """(n,) rising [Hz], between which errors are linear in ln f; None without errors."""

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
            If the model has no damping there.
        """

    def covariance(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, then of m_a [kg/m²], at (n,) [Hz].

        It is zero without errors.
        """
        point = (fill_fraction, acceleration_g)
        return self.cross_covariance(frequency, point, point)

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) between the values at two points.

        Rows are ln C_e, then m_a [kg/m²], at the frequencies (n,) [Hz] and the first point;
        columns the same at the other. With both points the same it is `covariance`.
        """

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the damper [kg/m²], with or without m_a; NaN if not known."""

    def without_mass(self) -> DampingModel:
        """Return the same damping with m_a = 0, known exactly: a dashpot."""


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
