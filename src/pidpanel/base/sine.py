"""Sine sweep of the supports, where single tones are exact: damping at each frequency's amplitude.

The Γ of each patch follows the sweep from line to line. Where several motions reproduce themselves,
a sweep up and a sweep down stay on different ones until theirs ends.

For standard errors the sweep is repeated with ln C_e and with m_a of each source of damping changed
by their errors, up and down. Half the differences of ln of the amplitudes add up by the correlation
of C_e and m_a, and in square over the sources, which err independently. The motion of the patches
follows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags
from pidpanel.damping.models import FilledDamper
from pidpanel.solve.layout import AttachedDamper
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.moved_panel import MovedPanel
from pidpanel.solve.receptances import Receptances, patch_stiffness, traces, weighted_sum
from pidpanel.solve.search import Map, NotConverged, approach, find_motions, iterate

CUTOFF = 1e-8  # eigenvalues of D below this share of the largest are dropped


@dataclass(frozen=True)
class Transfer:
    """Motions per acceleration of the supports, on some lines."""

    frequency: Array  # (nf,) [Hz]
    weight: Array  # Δ of the motions u that the patches feel, see `model.PatchCoordinates`
    area: Array  # (n_patches,) [m²]
    receptances: Receptances  # of u and of the observed motions w
    # (nf, r) and (nf, nw) the same motions without dampers, per acceleration of the supports [s²]
    felt: Complexes
    observed: Complexes

    @classmethod
    def of_panel(
        cls, frequency: Array, basis: ModalBasis, patches: Patches, force: Array, observed: Array
    ) -> Transfer:
        """Return the transfer of a basis with the translation.

        Parameters
        ----------
        patches
            Patches with dampers.
        force
            (n + 1,) force of `BaseExcitation`.
        observed
            (nw, n + 1) rows of the observed motions.
        """
        coordinates = patches.coordinates(CUTOFF)
        panel = MovedPanel(frequency, basis, None, [coordinates.columns, observed.T])
        receptances = Receptances(*panel.receptances(0, [0, 1]))
        moved = force / basis.dynamic_stiffness(frequency)
        felt = moved @ coordinates.columns
        free = felt, moved @ observed.T
        return cls(frequency, coordinates.weight, patches.area, receptances, *free)

    def motions(self, stiffness: Complexes) -> Complexes:
        """Return w (nf, nw) per acceleration [s²] with dampers s (n_patches, nf) [N/m³]."""
        pull = weighted_sum(stiffness, self.weight)
        return self.receptances.motions(pull, self.felt, self.observed)

    def patch_acceleration(self, lines: slice, stiffness: Complexes) -> Array:
        """Return the rms over each patch of |acceleration| (nf, n_patches) over that of the base.

        With dampers s (n_patches, nf) on some lines.
        """
        pull = weighted_sum(stiffness, self.weight)
        u = self.receptances.on_lines(lines).solution(pull)(self.felt[lines, :, None])
        square = traces(self.weight, (u @ u.conj().swapaxes(1, 2)).real).T / self.area
        return np.asarray((2 * np.pi * self.frequency[lines, None]) ** 2 * np.sqrt(square))


GRID = 60  # Γ at which the damping of a load is taken; linear in ln Γ between them

# Largest Γ over the amplitude of the supports: dampers limit the highest motion
RANGE = (1e-2, 1e3)

TOLERANCE = 1e-6  # of ln Γ

# Steps of ln Γ in the search for another motion when that of the line before has ended
JUMPS = np.linspace(-2.5, 2.5, 11)


@dataclass(frozen=True)
class SineSweep:
    """Motions per acceleration of the supports in one direction of a sweep."""

    motion: Complexes  # (nf, nw) complex, of the observed motions [s²]
    stiffness: Complexes  # (n_loads, nf) s of each damper [N/m³]
    acceleration_g: Array  # (n_loads, nf) Γ of each patch
    residual: Array  # (nf,) largest |ln(Γ_out/Γ)|


def _stiffness_of(
    dampers: Sequence[AttachedDamper],
    frequency: Array,
    amplitude_g: float,
    stated_g: float | None,
) -> Callable[[int, Array], Complexes]:
    """Return s (n_loads, 1) of all loads as a function of a line of a sweep and of ln Γ."""
    log_grid = np.log(amplitude_g * np.geomspace(*RANGE, GRID))
    table = np.empty((len(dampers), GRID, frequency.size), np.complex128)
    for damper, values in zip(dampers, table, strict=True):
        follows = damper.depends_on_acceleration and stated_g is None
        gammas = np.exp(log_grid) if follows else [stated_g or np.nan]
        for index, gamma in enumerate(gammas):
            damping, mass, _ = damper.damping(frequency, float(gamma))
            values[index:] = patch_stiffness(frequency, damping[None], mass[None])

    def stiffness(line: int, log_gamma: Array) -> Complexes:
        place = np.interp(log_gamma, log_grid, np.arange(GRID))
        low = np.minimum(place.astype(int), GRID - 2)
        part = (place - low)[:, None]
        number = np.arange(len(log_gamma))
        lower, upper = table[number, low, line], table[number, low + 1, line]
        return (1 - part) * lower[:, None] + part * upper[:, None]

    return stiffness


def sweep(
    transfer: Transfer,
    dampers: Sequence[AttachedDamper],
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
    count, size = len(dampers), transfer.frequency.size
    gamma, residual = np.full((count, size), np.nan), np.zeros(size)
    stiffness = np.zeros((count, size), np.complex128)
    if count:
        stiffness_at = _stiffness_of(dampers, transfer.frequency, amplitude_g, stated_g)
        x = np.full(count, np.log(amplitude_g))
        lines = range(size - 1, -1, -1) if down else range(size)
        for number, line in enumerate(lines):

            def outcome(log_gamma: Array, line: int = line) -> Array:
                """Return the ln Γ that a ln Γ leads to."""
                line_stiffness = stiffness_at(line, log_gamma)
                (ratio,) = transfer.patch_acceleration(slice(line, line + 1), line_stiffness)
                return np.log(amplitude_g * ratio)

            start = approach(outcome, x) if number == 0 else x
            followed, residual[line] = iterate(outcome, start, TOLERANCE)
            if residual[line] <= TOLERANCE:
                x = followed
            else:  # the motion that was followed has ended
                x, residual[line] = _other_motion(outcome, x)
            gamma[:, line], stiffness[:, line] = np.exp(x), stiffness_at(line, x)[:, 0]
    return SineSweep(transfer.motions(stiffness), stiffness, gamma, residual)


def _other_motion(outcome: Map, x: Array) -> tuple[Array, float]:
    """Return the stable ln Γ nearest to one that does not reproduce itself, and its residual."""
    try:
        solutions = find_motions([outcome], [x + step for step in JUMPS], TOLERANCE)
    except NotConverged:
        return iterate(outcome, x, TOLERANCE)
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
        (nf, m) of the interface, see `solve.base_motion.observed_motions`.
    patches
        (n_loads,) with s (n_loads, nf).
    """
    force = -((2 * np.pi * frequency) ** 2) * motion[:, 0]
    for patch, s in zip(patches, stiffness, strict=True):
        force = force + s * motion[:, 1 + patch]
    return force


Amplitudes = Mapping[str, Array]  # (nf, …) by name


class DampingErrors(NamedTuple):
    """(nf,) standard errors of ln C_e and of m_a [kg/m²], and their correlation."""

    log_damping: Array
    mass: Array
    correlation: Array


def damping_errors(damper: FilledDamper, frequency: Array, gamma: Array) -> DampingErrors | None:
    """Return the errors of a damper at the Γ (nf,) of each line; None without any."""
    nodes = damper.model.nodes
    if nodes is None:
        return None
    at_nodes = np.interp(nodes, frequency, gamma)
    covariance = np.array(
        [
            damper.model.covariance(np.array([node]), damper.fill, float(value))
            for node, value in zip(nodes, at_nodes, strict=True)
        ]
    )
    error = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    norm = error.prod(axis=1)
    correlation = np.divide(covariance[:, 0, 1], norm, out=np.zeros_like(norm), where=norm > 0)
    at_lines = (np.interp(frequency, nodes, row) for row in (*error.T, correlation))
    return DampingErrors(*at_lines)


def sweep_errors(
    dampers: Sequence[AttachedDamper],
    names: Sequence[str],
    errors: Sequence[DampingErrors | None],
    amplitudes: Callable[[Sequence[AttachedDamper]], Amplitudes],
) -> dict[str, Array]:
    """Return the standard errors of ln of the amplitudes of a sweep; none where none are known.

    Those of the dampers are on the lines of the sweep, and common to those of one name.
    """
    variance: dict[str, Array] = {}
    known = list(zip(names, errors, strict=True))
    for source in dict.fromkeys(name for name, error in known if error is not None):
        own = [error if name == source else None for name, error in known]
        source_errors = list(zip(dampers, own, strict=True))
        correlation = next(error.correlation for _, error in source_errors if error is not None)
        by_damping, by_mass = (
            [
                amplitudes([_changed(damper, error, *change) for damper, error in source_errors])
                for change in changes
            ]
            for changes in (((1, 0), (-1, 0)), ((0, 1), (0, -1)))
        )
        for name in by_damping[0]:
            a, b = (np.log(up[name] / down[name]) / 2 for up, down in (by_damping, by_mass))
            covariance = 2 * correlation.reshape(-1, *[1] * (a.ndim - 1)) * a * b
            variance[name] = variance.get(name, 0.0) + a**2 + b**2 + covariance
    return {name: np.sqrt(np.maximum(square, 0.0)) for name, square in variance.items()}


def _changed(
    damper: AttachedDamper, error: DampingErrors | None, damping: int, mass: int
) -> AttachedDamper:
    """Return a load with ln C_e and m_a changed by numbers of standard errors."""
    if error is None:
        return damper

    def values(frequency: Array, gamma: float) -> tuple[Array, Array, Flags]:
        stated, apparent_mass, inside = damper.damping(frequency, gamma)
        factor = np.exp(damping * error.log_damping)
        return factor * stated, apparent_mass + mass * error.mass, inside

    return replace(damper, damping=values)
