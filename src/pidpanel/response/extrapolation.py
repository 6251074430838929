"""Share of a scenario's change that depends on extrapolated damping, and distance to the data."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.damping.models import Damper, FilledDamper
from pidpanel.solve.layout import LayoutResponse

# Distance beyond the data, in ln Γ or ln f, at which a line is fully extrapolated.
FAR = math.log(2.0)

# Changes of ln Γ that are tried to reach the data.
STEPS = FAR * np.array([0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, *range(1, 11)])


@dataclass(frozen=True)
class Extrapolation:
    """Damping of a scenario beyond its data."""

    # (nf,) 0 within the data, 1 from a factor of two beyond them in Γ or f, linear in ln between
    weight: Array
    # Range that the data lack, such as ``"acrylic to 61 g"``; empty if they cover it
    missing: str

    def share_of_change(self, bare: Array, damped: Array, frequency: Array) -> Array:
        """Return ∫ w |S_bare − S| df over ∫ |S_bare − S| df, (n_points,).

        Parameters
        ----------
        bare, damped
            (nf, n_points) PSDs without and with dampers.
        frequency
            (nf,) [Hz].
        """
        change = np.abs(bare - damped)
        part = np.trapezoid(self.weight[:, None] * change, frequency, axis=0)
        total = np.trapezoid(change, frequency, axis=0)
        return np.divide(part, total, out=np.zeros_like(total), where=total > 0)


def extrapolation_of(
    dampers: Sequence[FilledDamper], response: LayoutResponse, frequency: Array
) -> Extrapolation:
    """Return where the damping of a response is extrapolated.

    Parameters
    ----------
    dampers
        Dampers in the order of the loads of ``response``.
    response
        The response.
    frequency
        (nf,) its lines [Hz].
    """
    weight, missing = np.zeros(len(frequency)), {}
    for damper, gamma, inside in zip(
        dampers, response.acceleration_g, response.inside, strict=True
    ):
        if inside.all():
            continue
        by_motion = _distance_in_motion(damper.model, frequency, damper.fill, gamma, inside)
        distance = np.minimum(by_motion, _distance_in_frequency(frequency, inside))
        unreached = frequency[~np.isfinite(by_motion)]
        weight = np.maximum(weight, np.minimum(distance / FAR, 1.0))
        reach = f" {float(f'{gamma:.3g}'):g} g" if np.isfinite(gamma) else ""
        if unreached.size:
            # of a damping without amplitudes the frequencies are all
            reach += f"{' at' if reach else ''} {unreached.min():.0f} to {unreached.max():.0f} Hz"
        if not np.isfinite(distance).any():
            reach += f" and r = {damper.fill:g}"
        missing[damper.name] = f"{damper.name} to{reach}"
        for f in frequency[~damper.model.is_hard(frequency, gamma)][:1].tolist():
            message = f"the atlas to particles as soft as {damper.name} from {f:.0f} Hz"
            missing[damper.name] = message
    return Extrapolation(weight, " and ".join(missing.values()))


def between_regimes(
    dampers: Sequence[FilledDamper], response: LayoutResponse, frequency: Array
) -> Extrapolation:
    """Return at which lines a bed of the atlas may ride or cross its gap; as `extrapolation_of`."""
    weight = np.zeros(len(frequency))
    for damper, gamma in zip(dampers, response.acceleration_g.tolist(), strict=True):
        weight[damper.model.is_near_jump(frequency, damper.fill, gamma)] = 1.0
    return Extrapolation(weight, "")


def _distance_in_motion(
    model: Damper, frequency: Array, fill: float, gamma: float, inside: Flags
) -> Array:
    """Return |Δ ln Γ| (nf,) to the data; inf where no Γ within a factor of 1000 reaches them."""
    distance = np.where(inside, 0.0, np.inf)
    if not model.depends_on_acceleration:
        return distance
    for step in STEPS:
        for sign in (-1, 1):
            reached = model(frequency, fill, float(gamma * np.exp(sign * step))).inside
            distance = np.where(reached, np.minimum(distance, step), distance)
    return distance


def _distance_in_frequency(frequency: Array, inside: Flags) -> Array:
    """Return |Δ ln f| (nf,) to the nearest line within the data; inf without any."""
    log_f = np.log(frequency)
    bounds = np.concatenate([[-np.inf], log_f[inside], [np.inf]])
    index = np.searchsorted(bounds, log_f)
    return np.minimum(log_f - bounds[index - 1], bounds[index] - log_f)
