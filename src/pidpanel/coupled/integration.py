"""Panel and particles step by step, without delay, with the balance of their energies.

At every step n the spheres' contacts give the force F_k of the walls on the spheres of each
station k. The panel takes −F_k (a_k/A_k) Δt as an impulse, with A_k the area of the cells that
were simulated and a_k the area for which they stand, and moves freely to step n + 1. The spheres
are seen from their cells: they lose the velocity (w_{n+1} − 2 w_n + w_{n−1})/Δt that their cells
gain. Both sides thus move by the leapfrog rule of one and the same force.

Energy: what the sound gives is what the modes lose, what the walls give to the spheres, and what
the panel holds more. Each is computed on its own: ∫ f q̇ dt, ∫ c q̇² dt, Σ F_k (w_{n+1} −
w_{n−1})/2 with the motion that the spheres see, and the energies at both ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Protocol

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupled.panel_motion import energy, free_motion


class Particles(Protocol):
    """The particles of some stations, seen from their cells."""

    def wall_force(self) -> Array:
        """Return the force of the walls on the particles of each station along z [N]."""
        ...

    def step(self, kick: Array) -> None:
        """Give the particles of each station a velocity along z [m/s]; go one step."""
        ...


@dataclass(frozen=True)
class PanelShapes:
    """The panel as the integration needs it.

    Attributes
    ----------
    angular_frequency, damping_ratio, modal_mass
        (n,) of each shape [rad/s], [1], [kg].
    at_stations
        (k, n) the shapes at the stations [1].
    at_points
        (p, n) at the points that are recorded [1].
    """

    angular_frequency: Array
    damping_ratio: Array
    modal_mass: Array
    at_stations: Array
    at_points: Array


@dataclass(frozen=True)
class Balance:
    """Energies of a window of a run [J].

    Attributes
    ----------
    sound
        Given by the sound.
    modes
        Lost by the damping of the bare panel.
    particles
        Given by the walls to the particles.
    gain
        That the panel holds more at the end.
    """

    sound: float
    modes: float
    particles: float
    gain: float

    @property
    def error(self) -> float:
        """What is missing over what the sound gives [1]."""
        return (self.sound - self.modes - self.particles - self.gain) / self.sound


@dataclass(frozen=True)
class Record:
    """What a run leaves.

    Attributes
    ----------
    interval
        Between the rows [s].
    at_stations, at_points
        (m, k) and (m, p) displacement w [m].
    impulse
        (m, k) impulse of the walls on the particles of each station so far, per area of the
        cells that were simulated [N s/m²].
    balance
        From the row ``settled`` to the end.
    """

    interval: float
    at_stations: Array
    at_points: Array
    impulse: Array
    balance: Balance


@dataclass(frozen=True)
class Rows:
    """What a piece of a run leaves.

    Attributes
    ----------
    at_stations, at_points, impulse
        As of `Record`; the impulse is the sum of the forces [N].
    """

    at_stations: Array
    at_points: Array
    impulse: Array

    @staticmethod
    def joined(pieces: Sequence[Rows]) -> Rows:
        """Return pieces that follow each other as one."""
        return Rows(
            *(
                np.concatenate([getattr(one, field.name) for one in pieces])
                for field in fields(Rows)
            )
        )


@dataclass(frozen=True)
class State:
    """The panel and the balance at a row: with the particles, all that what follows rests on.

    Attributes
    ----------
    row
        Number of the row.
    shapes
        (2, n) q [m] and q̇ [m/s].
    here, before
        (k,) displacement of the stations now and a step ago [m].
    impulse
        (k,) sum of the forces of the walls so far [N].
    energies
        (4,) of the balance so far: work on the particles twice [J], of the sound a step of a row
        [J], lost over the duration of a row [W], and held where it began [J].
    """

    row: int
    shapes: Array
    here: Array
    before: Array
    impulse: Array
    energies: Array


@dataclass(frozen=True)
class Integration:
    """A panel with its particles under given modal forces, to be integrated piece by piece.

    Attributes
    ----------
    panel
        Its shapes.
    stands_for, cell_area
        (k,) a_k and A_k of each station [m²].
    force
        (m + 1, n) modal forces at the rows, joined linearly between them [N].
    time_step
        Δt [s].
    steps_per_row
        Of the record; an even number.
    settled
        Row from which the energies are balanced.

    Raises
    ------
    ValueError
        If a row has an odd number of steps.
    """

    panel: PanelShapes
    stands_for: Array
    cell_area: Array
    force: Array
    time_step: float
    steps_per_row: int
    settled: int

    def __post_init__(self) -> None:
        if self.steps_per_row % 2:
            raise ValueError(f"{self.steps_per_row} steps a row: an even number is needed")

    @property
    def rows(self) -> int:
        """Rows of the record."""
        return len(self.force) - 1

    def begin(self, start: Array) -> State:
        """Return the state at row 0 of q [m] and q̇ [m/s], (2, n)."""
        shapes = np.array(start, dtype=np.float64)
        here, speed = shapes @ self.panel.at_stations.T
        nothing = np.zeros(len(here))
        return State(0, shapes, here, here - self.time_step * speed, nothing, np.zeros(4))

    def advance(
        self,
        particles: Sequence[Particles],
        state: State,
        until: int,
        progress: Callable[[int], None] = lambda _: None,
    ) -> tuple[Rows, State]:
        """Integrate from a state to a row.

        Parameters
        ----------
        particles
            Of the patches; their stations follow each other in the order of those of the panel.
        state, until
            From its row to this one.
        progress
            Is told every row.

        Raises
        ------
        ValueError
            If the particles have other stations than the panel.
        """
        panel, time_step, steps_per_row = self.panel, self.time_step, self.steps_per_row
        mass, omega = panel.modal_mass, panel.angular_frequency
        own, other = free_motion(omega, panel.damping_ratio, time_step)
        damping = 2 * panel.damping_ratio * omega * mass
        shape = np.ascontiguousarray(panel.at_stations.T)  # (n, k)
        weight = self.stands_for / self.cell_area
        impulse_of = np.ascontiguousarray(shape * (weight * time_step) / mass[:, None])
        # Simpson's rule in every row: a tone of a tenth of the rate of rows to 3e-5
        share = {0: 1 / 3, steps_per_row // 2: 2 / 3}
        count, stations = until - state.row, shape.shape[1]
        at_stations, impulse = np.empty((count, stations)), np.empty((count, stations))
        at_points = np.empty((count, len(panel.at_points)))
        bounds = _bounds(particles, stations)
        shapes = state.shapes.copy()
        q, speed = shapes
        w, before, total = state.here.copy(), state.before.copy(), state.impulse.copy()
        work, sound, lost, held = state.energies.tolist()
        wall = np.zeros(stations)
        push = time_step / mass
        for index, row in enumerate(range(state.row, until)):
            if row == self.settled:
                work = sound = lost = 0.0
                held = energy(mass, omega, shapes)
            at_points[index] = panel.at_points @ q
            at_stations[index] = w
            given = self.force[row] * push
            more = (self.force[row + 1] - self.force[row]) * (push / steps_per_row)
            for step in range(steps_per_row):
                for one, part in zip(particles, bounds, strict=True):
                    wall[part] = one.wall_force()
                if step == 0:
                    impulse[index] = total + 0.5 * wall
                total += wall
                if step in share:
                    old = speed.copy()
                speed += given
                speed -= impulse_of @ wall
                if step in share:
                    old = (old + speed) / 2
                    sound += share[step] * float((mass * given) @ old)
                    lost += share[step] * float(damping @ old**2)
                swapped = other * shapes[::-1]
                shapes *= own
                shapes += swapped
                given += more
                after = q @ shape
                work += float((wall * weight) @ (after - before))
                kick = (2 * w - before - after) / time_step
                for one, part in zip(particles, bounds, strict=True):
                    one.step(kick[part])
                before, w = w, after
            progress(row)
        energies = np.array([work, sound, lost, held])
        return (
            Rows(at_stations, at_points, impulse),
            State(until, shapes, w, before, total, energies),
        )

    def record(self, rows: Rows, state: State) -> Record:
        """Return the record of all rows, and of the state at the last of them."""
        interval = self.steps_per_row * self.time_step
        work, sound, lost, held = state.energies.tolist()
        panel = self.panel
        return Record(
            interval=interval,
            at_stations=rows.at_stations,
            at_points=rows.at_points,
            impulse=rows.impulse * (self.time_step / self.cell_area),
            balance=Balance(
                sound=sound * self.steps_per_row,
                modes=lost * interval,
                particles=0.5 * work,
                gain=energy(panel.modal_mass, panel.angular_frequency, state.shapes) - held,
            ),
        )


def _bounds(particles: Sequence[Particles], stations: int) -> list[slice]:
    """Return the stations of each of the particles."""
    ends = np.cumsum([0] + [len(one.wall_force()) for one in particles]).tolist()
    if ends[-1] != stations:
        raise ValueError(f"the particles have {ends[-1]} stations, the panel has {stations}")
    return [slice(first, last) for first, last in pairwise(ends)]
