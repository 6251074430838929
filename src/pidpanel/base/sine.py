"""Sine sweep of the supports, where single tones are exact: damping at each frequency's amplitude.

The Γ of each patch follows the sweep from line to line. Where several motions reproduce themselves,
a sweep up and a sweep down stay on different ones until theirs ends.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.base.transfer import Transfer
from pidpanel.solve.dampers import patch_stiffness
from pidpanel.solve.layout import Load
from pidpanel.solve.search import Map, NotConverged, approach, find_motions, iterate

GRID = 60  # Γ at which the damping of a load is taken; linear in ln Γ between them

# Largest Γ over the amplitude of the supports: dampers limit the highest motion
RANGE = (1e-2, 1e3)

TOLERANCE, STEPS = 1e-6, 60  # tolerance of ln Γ, and most steps on a line

# Steps of ln Γ in the search for another motion when that of the line before has ended
JUMPS = np.linspace(-2.5, 2.5, 11)


@dataclass(frozen=True)
class SineSweep:
    """Motions per acceleration of the supports in one direction of a sweep."""

    motion: Complexes  # (nf, nw) complex, of the observed motions [s²]
    stiffness: Complexes  # (n_loads, nf) s of each damper [N/m³]
    acceleration_g: Array  # (n_loads, nf) Γ of each patch
    residual: Array  # (nf,) largest |ln(Γ_out/Γ)|


class _Damping:
    """s of all loads over Γ, on the lines of a sweep."""

    def __init__(
        self, loads: Sequence[Load], frequency: Array, amplitude_g: float, stated_g: float | None
    ) -> None:
        self._log = np.log(amplitude_g * np.geomspace(*RANGE, GRID))
        self._values = np.empty((len(loads), GRID, frequency.size), np.complex128)
        for load, values in zip(loads, self._values, strict=True):
            follows = load.depends_on_acceleration and stated_g is None
            gammas = np.exp(self._log) if follows else [stated_g or np.nan]
            for index, gamma in enumerate(gammas):
                damping, mass, _ = load.damping(frequency, float(gamma))
                values[index:] = patch_stiffness(frequency, damping[None], mass[None])

    def at(self, line: int, log_gamma: Array) -> Complexes:
        """Return s (n_loads, 1) on a line."""
        place = np.interp(log_gamma, self._log, np.arange(GRID))
        low = np.minimum(place.astype(int), GRID - 2)
        part = (place - low)[:, None]
        loads = np.arange(len(log_gamma))
        lower, upper = self._values[loads, low, line], self._values[loads, low + 1, line]
        return (1 - part) * lower[:, None] + part * upper[:, None]


def sweep(
    transfer: Transfer,
    loads: Sequence[Load],
    amplitude_g: float,
    stated_g: float | None = None,
    *,
    down: bool = False,
) -> SineSweep:
    """Return the motions of a sweep with loads on all patches of a transfer.

    Parameters
    ----------
    amplitude_g
        Acceleration amplitude of the supports [g].
    stated_g
        Γ at which all damping is evaluated; None for that of each patch.
    down
        Whether the sweep starts at the highest frequency.
    """
    count, size = len(loads), transfer.frequency.size
    gamma, residual = np.full((count, size), np.nan), np.zeros(size)
    stiffness = np.zeros((count, size), np.complex128)
    if count:
        damping = _Damping(loads, transfer.frequency, amplitude_g, stated_g)
        x = np.full(count, np.log(amplitude_g))
        lines = range(size - 1, -1, -1) if down else range(size)
        for number, line in enumerate(lines):

            def outcome(log_gamma: Array, line: int = line) -> Array:
                """Return the ln Γ that a ln Γ leads to."""
                pull = damping.at(line, log_gamma)
                (ratio,) = transfer.patch_acceleration(slice(line, line + 1), pull)
                return np.log(amplitude_g * ratio)

            start = approach(outcome, x) if number == 0 else x
            followed, residual[line] = iterate(outcome, start, TOLERANCE, STEPS)
            if residual[line] <= TOLERANCE:
                x = followed
            else:  # the motion that was followed has ended
                x, residual[line] = _other_motion(outcome, x)
            gamma[:, line], stiffness[:, line] = np.exp(x), damping.at(line, x)[:, 0]
    motion = transfer.motions(slice(None), stiffness)
    looked_at = motion.shape[1] - transfer.width
    return SineSweep(motion[:, :looked_at], stiffness, gamma, residual)


def _other_motion(outcome: Map, x: Array) -> tuple[Array, float]:
    """Return the stable ln Γ nearest to one that does not reproduce itself, and its residual."""
    try:
        solutions = find_motions([outcome], [x + step for step in JUMPS], TOLERANCE)
    except NotConverged:
        return iterate(outcome, x, TOLERANCE, STEPS)
    stable = [solution for solution in solutions if solution.stable]
    nearest = min(
        stable or solutions, key=lambda solution: float(np.abs(solution.log_gamma - x).max())
    )
    return nearest.log_gamma, nearest.residual


def interface_force(
    frequency: Array, motion: Complexes, patches: Sequence[int], stiffness: Complexes
) -> Complexes:
    """Return the force of the supports per their acceleration (nf,) [kg].

    Parameters
    ----------
    motion
        (nf, m) of the interface, see `supports.observed_motions`.
    patches
        (n_loads,) with s (n_loads, nf).
    """
    force = -((2 * np.pi * frequency) ** 2) * motion[:, 0]
    for patch, s in zip(patches, stiffness, strict=True):
        force = force + s * motion[:, 1 + patch]
    return force
