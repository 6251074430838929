"""Standard errors of sine sweeps from those of C_e and m_a.

The sweep is repeated with ln C_e and with m_a of each source of damping changed by their errors,
up and down. Half the differences of ln of the amplitudes add up by the correlation of C_e and m_a,
and in square over the sources, which err independently. The motion of the patches follows.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.response.dampers import PatchDamper
from pidpanel.solve.layout import Load

Amplitudes = Mapping[str, Array]  # (nf, …) by name


class DampingErrors(NamedTuple):
    """(nf,) standard errors of ln C_e and of m_a [kg/m²], and their correlation."""

    log_damping: Array
    mass: Array
    correlation: Array


def damping_errors(damper: PatchDamper, frequency: Array, gamma: Array) -> DampingErrors | None:
    """Return the errors of a damper at the Γ (nf,) of each line; None without any."""
    nodes = damper.model.nodes
    if nodes is None:
        return None
    at_nodes = np.interp(nodes, frequency, gamma)
    covariance = np.array(
        [
            damper.model.covariance(np.array([node]), damper.fill_fraction, float(value))
            for node, value in zip(nodes, at_nodes, strict=True)
        ]
    )
    error = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    both = error.prod(axis=1)
    correlation = np.divide(covariance[:, 0, 1], both, out=np.zeros_like(both), where=both > 0)
    at_lines = (np.interp(frequency, nodes, row) for row in (*error.T, correlation))
    return DampingErrors(*at_lines)


def sweep_errors(
    dampers: Sequence[PatchDamper],
    errors: Sequence[DampingErrors | None],
    amplitudes: Callable[[Sequence[Load]], Amplitudes],
) -> dict[str, Array]:
    """Return the standard errors of ln of the amplitudes of a sweep; none where none are known.

    Those of the dampers are on the lines of the sweep; ``amplitudes`` takes their loads.
    """
    variance: dict[str, Array] = {}
    pairs = list(zip(dampers, errors, strict=True))
    for source in dict.fromkeys(damper.source for damper, error in pairs if error is not None):
        of_source = [
            (damper, error if damper.source == source else None) for damper, error in pairs
        ]
        correlation = next(error.correlation for _, error in of_source if error is not None)
        by_damping, by_mass = (
            [
                amplitudes([_changed(damper.load, error, *change) for damper, error in of_source])
                for change in changes
            ]
            for changes in (((1, 0), (-1, 0)), ((0, 1), (0, -1)))
        )
        for name in by_damping[0]:
            a, b = (np.log(up[name] / down[name]) / 2 for up, down in (by_damping, by_mass))
            both = 2 * correlation.reshape(-1, *[1] * (a.ndim - 1)) * a * b
            variance[name] = variance.get(name, 0.0) + a**2 + b**2 + both
    return {name: np.sqrt(np.maximum(square, 0.0)) for name, square in variance.items()}


def _changed(load: Load, error: DampingErrors | None, damping: int, mass: int) -> Load:
    """Return a load with ln C_e and m_a changed by numbers of standard errors."""
    if error is None:
        return load

    def values(frequency: Array, gamma: float) -> tuple[Array, Array, Flags]:
        stated, apparent_mass, inside = load.damping(frequency, gamma)
        factor = np.exp(damping * error.log_damping)
        return factor * stated, apparent_mass + mass * error.mass, inside

    return replace(load, damping=values)
