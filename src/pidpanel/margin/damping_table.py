"""C_e and m_a of a damper over frequency and Γ, and how they follow inputs and errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.models import FilledDamper
from pidpanel.margin.runs import Damping

FREQUENCIES, ACCELERATIONS = 80, 17
LEAST = 1e-3  # C_e below which nothing is damped [N s/m³]
# Scores at which the dependence on an input is read besides 0: C_e bends where beds begin to cross.
ENDS = (-3.0, -1.5, 1.5, 3.0)


@dataclass(frozen=True)
class DampingTable:
    """ln C_e, then m_a [kg/m²] at nodes of ln f and ln Γ: (2, n_Γ, n_f)."""

    log_frequency: Array
    log_acceleration: Array
    values: Array

    @classmethod
    def tabulated(
        cls, damper: FilledDamper, frequency: Array, acceleration_g: Array
    ) -> DampingTable:
        """Return the table of a damper at frequencies [Hz] and Γ, which may be a single one."""
        read = [damper.damping(frequency, gamma)[:2] for gamma in acceleration_g.tolist()]
        values = np.array([[np.log(np.maximum(C, LEAST)) for C, _ in read], [m for _, m in read]])
        return cls(np.log(frequency), np.log(acceleration_g), values)

    def plus(self, change: Array) -> Damping:
        """Return the damping with a change (2, n_Γ, n_f) of the values."""
        values, place = self.values + change, np.arange(self.log_acceleration.size)

        def damping(frequency: Array, acceleration_g: float) -> tuple[Array, Array]:
            position = float(np.interp(np.log(acceleration_g), self.log_acceleration, place))
            lower = min(int(position), max(place.size - 2, 0))
            upper = min(lower + 1, place.size - 1)
            log_value, mass = values[:, lower] + (position - lower) * (
                values[:, upper] - values[:, lower]
            )
            x = np.log(frequency)
            damped = np.exp(np.interp(x, self.log_frequency, log_value))
            return damped, np.interp(x, self.log_frequency, mass)

        return damping


@dataclass(frozen=True)
class VariedDamping:
    """A table with its dependence on inputs and its errors."""

    table: DampingTable
    # Number of each input, and over its score the factor on C_e, then the change of m_a
    # (2, n_Γ, n_f). C_e itself is nearer to linear than ln C_e, which falls steeply near 0.
    inputs: Sequence[tuple[int, Callable[[float], Array]]]
    error: Array  # (2 n_f, r) of ln C_e, then m_a, over scores of the error

    def damping(self, inputs: Array | None, error: Array) -> Damping:
        """Return the damping at scores of the inputs (n_inputs,) and of the error (r,).

        None stands for the inputs of the study.
        """
        change = np.zeros_like(self.table.values)
        for number, change_at in self.inputs:
            if inputs is None:
                break
            factor, step = change_at(float(np.clip(inputs[number], ENDS[0], ENDS[-1])))
            change += [np.log(np.maximum(factor, LEAST)), step]
        return self.table.plus(change + (self.error @ error).reshape(2, 1, -1))
