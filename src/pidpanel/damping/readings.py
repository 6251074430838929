"""One question, several answers: C_e and m_a at these frequencies, this fill and this motion.

A reading of the damping is a callable that answers it: the surface of simulated cases or of a
table (`surface`, `tables`), the paper's law (`laws`). `from_study` makes the readings that a study
names.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from pidpanel.arrays import Array, Flags


class DampingError(ValueError):
    """A question that a law or table of damping has no answer to."""


@dataclass(frozen=True)
class DampingValues:
    """C_e, its error and m_a at the frequencies asked.

    Attributes
    ----------
    equivalent_damping, equivalent_damping_error
        (n,) C_e and its standard error [N s/m³].
    apparent_mass
        (n,) m_a [kg/m²].
    inside
        (n,) False where the value is extrapolated beyond the simulated range.
    """

    equivalent_damping: Array
    equivalent_damping_error: Array
    apparent_mass: Array
    inside: Flags


class DampingReading(Protocol):
    """An answer to the question."""

    depends_on_acceleration: bool
    """Whether C_e or m_a changes with Γ."""

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
        ...

    def without_mass(self) -> DampingReading:
        """Return the same damping with m_a = 0: a dashpot."""
        ...
