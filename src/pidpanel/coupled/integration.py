"""Panel and particles in one time integration, with the balance of their energies.

The panel receives the force of the walls as impulses at times t_j, an interval Δ apart, and moves
freely between them. The cells move with the panel and the particles are seen from their cells, so
they lose the velocity (w_{j+1} − 2 w_j + w_{j−1})/Δ that their cells gain at t_j. Within an
interval LIGGGHTS takes ``substeps`` steps.

The impulse at t_j is that of the walls up to t_j + Δ/2 less what was applied before. The half
interval ahead is taken at the force of t_j, and what it turns out to be enters the next impulse,
so that no momentum is lost. With one step to an interval both sides obey the same leapfrog rule.

Energy: the work of the excitation equals the loss in the modes, the work of the walls on the
particles and the gain of the panel. Each is computed separately: ∫ f q̇ dt, ∫ c q̇² dt,
Σ P_j (w_{j+1} − w_{j−1})/2Δ with the motion that the particles see, and the energies at both ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg

from pidpanel.arrays import Array
from pidpanel.coupon.liggghts.library import Spheres
from pidpanel.solve.model import ModalBasis


def free_motion(
    angular_frequency: Array, damping_ratio: Array, time_step: float
) -> tuple[Array, Array]:
    """Return what the shapes do from step to step, exp(A Δt) with A = [[0, 1], [−ω², −2ζω]].

    Between impulses the shapes move exactly:

        q̈_i + 2 ζ_i ω_i q̇_i + ω_i² q_i = Σ_n P_n,i δ(t − nΔt) / m_i

    Every force acts as an impulse F Δt at a time step, on the panel and on the spheres alike, and
    both move freely in between: no force is needed before it is known, none acts late, and momentum
    is kept to rounding. Of a band-limited force the impulses are exact below half their rate.

    Examples
    --------
    >>> own, other = free_motion(np.array([0.0]), np.array([0.0]), 0.5)
    >>> own.ravel().tolist(), other.ravel().tolist()
    ([1.0, 1.0], [0.5, 0.0])
    """
    n = len(angular_frequency)
    matrix = np.zeros((n, 2, 2))
    matrix[:, 0, 1] = 1.0
    matrix[:, 1, 0] = -(angular_frequency**2)
    matrix[:, 1, 1] = -2 * damping_ratio * angular_frequency
    # units of a step: entries of one size
    scale = np.array([[1.0, 1 / time_step], [time_step, 1.0]])
    done = scipy.linalg.expm(matrix * scale * time_step) / scale
    return np.stack([done[:, 0, 0], done[:, 1, 1]]), np.stack([done[:, 0, 1], done[:, 1, 0]])


def drift_free_velocity(
    force: Array, mass: Array, interval: float, intervals_per_row: int
) -> Array:
    """Return the velocity (n,) [m/s] with which free shapes are back in their place after a period.

    Modal forces (m + 1, n) [N] are at the rows of a period, linear between them, the last like the
    first; the velocity is that before the first impulse, and ``interval`` [s] between impulses.
    """
    part = np.arange(intervals_per_row)[:, None] / intervals_per_row
    impulse = interval * (force[:-1, None] * (1 - part) + force[1:, None] * part)
    speed = np.cumsum(impulse.reshape(-1, force.shape[1]), axis=0) / mass
    drift: Array = speed.mean(axis=0)
    return -drift


def energy(modal_mass: Array, angular_frequency: Array, state: Array) -> float:
    """Return ½ Σ m (q̇² + ω² q²) of a state (2, n) of q [m] and q̇ [m/s], in J."""
    q, speed = state
    return float(0.5 * modal_mass @ (speed**2 + (angular_frequency * q) ** 2))


@dataclass(frozen=True)
class Balance:
    """Energies of a run after settling [J]."""

    excitation: float
    modes: float  # loss in the damping of the bare panel
    particles: float  # work of the walls on the particles
    gain: float

    @property
    def error(self) -> float:
        """Missing energy over the work of the excitation [1]."""
        return (self.excitation - self.modes - self.particles - self.gain) / self.excitation


class Rows(NamedTuple):
    """Rows of a piece of a run."""

    # (m, c) and (m, p) displacement [m]
    at_cells: Array
    at_points: Array
    impulse: Array  # (m, c) impulse of the walls on the particles since the start [N s]

    @staticmethod
    def joined(pieces: Sequence[Rows]) -> Rows:
        """Return consecutive pieces as one."""
        return Rows(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)))


class State(NamedTuple):
    """State of the panel at a row; with that of the particles it determines the rest of the run."""

    row: int
    shapes: Array  # (2, n) q [m] and q̇ [m/s]
    # (c,) displacement of the cells now and an interval ago [m]
    displacement: Array
    previous: Array
    # (c,) impulse of the walls on the particles since the start, and what of it the panel has
    # received [N s]
    impulse: Array
    applied: Array
    # (4,) sums of the balance: work on the particles twice [J], work of the excitation over an
    # interval of a row [J], loss over the duration of a row [W], energy at its start [J]
    energies: Array


@dataclass(frozen=True)
class Integration:
    """A panel with particles under given modal forces, integrated in pieces.

    Raises
    ------
    ValueError
        If a row has an odd number of intervals.
    """

    modal: ModalBasis  # modes and residual vectors of the panel
    at_cells: Array  # (c, n) the shapes at the cells [1]
    at_points: Array  # (p, n) the shapes at the response points [1]
    # (c,) area of the patch that each cell represents, and area of the cell [m²]
    patch_area: Array
    cell_area: Array
    force: Array  # (m + 1, n) modal forces at the rows, linear between them [N]
    # Step of LIGGGHTS [s], and steps to an interval Δ
    time_step: float
    substeps: int
    intervals_per_row: int
    settled: int  # row from which the energies are balanced

    def __post_init__(self) -> None:
        if self.intervals_per_row % 2:
            raise ValueError(f"{self.intervals_per_row} intervals a row: must be even")

    @property
    def rows(self) -> int:
        """Number of rows of the record."""
        return len(self.force) - 1

    @property
    def interval(self) -> float:
        """Δ [s]."""
        return self.substeps * self.time_step

    @property
    def row_interval(self) -> float:
        """Time between rows [s]."""
        return self.intervals_per_row * self.interval

    def begin(self, start: Array) -> State:
        """Return the state at row 0 for q [m] and q̇ [m/s], (2, n)."""
        shapes = np.array(start, dtype=np.float64)
        displacement, velocity = shapes @ self.at_cells.T
        zero = np.zeros(len(displacement))
        previous = displacement - self.interval * velocity
        return State(0, shapes, displacement, previous, zero, zero.copy(), np.zeros(4))

    def advance(
        self,
        particles: Sequence[Spheres],
        state: State,
        end: int,
        progress: Callable[[int], None] = lambda _: None,
    ) -> tuple[Rows, State]:
        """Integrate from a state to a row."""
        modal, interval, per_row = self.modal, self.interval, self.intervals_per_row
        mass, omega = modal.modal_mass, modal.angular_frequency
        direct, cross = free_motion(omega, modal.damping_ratio, interval)
        damping = 2 * modal.damping_ratio * omega * mass
        shape, ratio = np.ascontiguousarray(self.at_cells.T), self.patch_area / self.cell_area
        velocity_per_impulse = np.ascontiguousarray(shape * ratio / mass[:, None])
        # Simpson's rule in every row: a tone of a tenth of the rate of rows to 3e-5
        simpson = {0: 1 / 3, per_row // 2: 2 / 3}
        widths = (len(ratio), len(self.at_points), len(ratio))
        rows = Rows(*(np.empty((end - state.row, width)) for width in widths))
        parts = _slices(particles, len(ratio))
        shapes = state.shapes.copy()
        q, velocity = shapes
        w, previous = state.displacement.copy(), state.previous.copy()
        total, applied = state.impulse.copy(), state.applied.copy()
        work, supplied, lost, start_energy = state.energies.tolist()
        ahead, velocity_per_force = np.empty(len(ratio)), interval / mass
        for index, row in enumerate(range(state.row, end)):
            if row == self.settled:
                work = supplied = lost = 0.0
                start_energy = energy(mass, omega, shapes)
            rows.at_points[index] = self.at_points @ q
            rows.at_cells[index] = w
            rows.impulse[index] = total
            push = self.force[row] * velocity_per_force
            change = (self.force[row + 1] - self.force[row]) * (velocity_per_force / per_row)
            for step in range(per_row):
                for patch, part in zip(particles, parts, strict=True):
                    ahead[part] = patch.wall_force()
                ahead *= interval / 2
                due = total + ahead - applied
                applied += due
                if step in simpson:
                    mean_velocity = velocity.copy()
                velocity += push
                velocity -= velocity_per_impulse @ due
                if step in simpson:
                    mean_velocity = (mean_velocity + velocity) / 2
                    supplied += simpson[step] * float((mass * push) @ mean_velocity)
                    lost += simpson[step] * float(damping @ mean_velocity**2)
                swapped = cross * shapes[::-1]
                shapes *= direct
                shapes += swapped
                push += change
                following = q @ shape
                work += float((due * ratio) @ (following - previous)) / interval
                kick = (2 * w - previous - following) / interval
                for patch, part in zip(particles, parts, strict=True):
                    total[part] += patch.advance(kick[part], self.substeps)
                previous, w = w, following
            progress(row)
        sums = np.array([work, supplied, lost, start_energy])
        return rows, State(end, shapes, w, previous, total, applied, sums)

    def balance(self, state: State) -> Balance:
        """Return the balance of the energies from the row ``settled`` to a state."""
        work, supplied, lost, start_energy = state.energies.tolist()
        modal = self.modal
        return Balance(
            excitation=supplied * self.intervals_per_row,
            modes=lost * self.row_interval,
            particles=0.5 * work,
            gain=energy(modal.modal_mass, modal.angular_frequency, state.shapes) - start_energy,
        )


def _slices(particles: Sequence[Spheres], cells: int) -> list[slice]:
    """Return the cells of each patch."""
    ends = np.cumsum([0] + [len(patch.wall_force()) for patch in particles]).tolist()
    if ends[-1] != cells:
        raise ValueError(f"the particles have {ends[-1]} cells, the panel has {cells}")
    return [slice(first, last) for first, last in pairwise(ends)]
