"""One scenario: a layout of dampers, their damping as a function of motion, one level of the sound.

The Γ at which C_e(r, f, Γ) of a load is read is either stated or its own patch's: those of all
loads that reproduce themselves together (`linearisation`, `search`). Whether the answer is within
the simulated range is carried along.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.solve.dampers import check_stable
from pidpanel.solve.linearisation import DampingOfMotion, LinearisationError, find_motions
from pidpanel.solve.model import Response, UnstableDamping
from pidpanel.solve.motions import Motions
from pidpanel.solve.search import find_together, starts_between
from pidpanel.solve.solvers import Answer, DiagonalSolver, PanelSolver, Request

FEW_LINES = (120,)
"""Lines on which several Γ are searched before all lines of the search are looked at."""


@dataclass(frozen=True)
class Load:
    """A damper on a patch.

    Parameters
    ----------
    patch
        Its index.
    damping
        C_e and m_a of the filled patch as a function of frequency and Γ.
    depends_on_acceleration
        Whether `damping` depends on Γ at all.
    """

    patch: int
    damping: DampingOfMotion
    depends_on_acceleration: bool = True


@dataclass(frozen=True)
class Layout:
    """Dampers that are on the panel together, and how loud it is.

    Parameters
    ----------
    loads
        The dampers; none for the bare panel.
    pressure_factor
        S_p over that of the solver.
    stated_acceleration_g
        Γ at which the damping of every load is read; left out, that of its patch's own motion.
    with_slope
        Whether `ScenarioResponse.slope` is wanted, for `uncertainty`.
    with_motion
        Whether the motions of the patches that come out are wanted; they are NaN otherwise.
    source
        PSD (nf, n, n) [N²/Hz] of modal forces beside those of the sound, at frequencies (nf,)
        [Hz]; the solver has to be one in that field. None for none.
    """

    loads: Sequence[Load]
    pressure_factor: float = 1.0
    stated_acceleration_g: float | None = None
    with_slope: bool = False
    with_motion: bool = True
    source: Callable[[Array], Array] | None = None

    @property
    def patches(self) -> tuple[int, ...]:
        """Indices of the loaded patches."""
        return tuple(load.patch for load in self.loads)

    @property
    def own(self) -> Hashable:
        """What the search for Γ depends on."""
        return tuple(self.loads), self.pressure_factor, self.stated_acceleration_g

    @property
    def own_acceleration(self) -> Flags:
        """(n_loads,) whether Γ of a load is that of its patch's own motion."""
        stated = self.stated_acceleration_g is not None
        return np.array([load.depends_on_acceleration and not stated for load in self.loads], bool)


@dataclass(frozen=True)
class ScenarioResponse:
    """A response and the damping it was computed with.

    Parameters
    ----------
    response
        PSDs at the points.
    loads
        (n_loads,) indices of the loaded patches; none on the bare panel.
    acceleration_g
        (n_loads,) Γ at which the damping was read; NaN for a law without Γ.
    patch_acceleration_g
        (n_loads,) Γ of the sine with the rms acceleration that the patch ends up with.
    cell_acceleration_g
        (n_loads, 2) lowest and highest such Γ of a cell of the patch; NaN without cells.
    bare_patch_acceleration_g
        (n_patches,) Γ of every patch of the solver on the bare panel under the same sound.
    equivalent_damping, apparent_mass
        (n_loads, nf) C_e [N s/m³] and m_a [kg/m²].
    inside
        (n_loads, nf) whether the damping is within the simulated range.
    fixed_points
        Number of distinct sets of Γ found that reproduce themselves; 0 on the bare panel.
    residual
        Largest |ln(Γ_out/Γ)| at the one taken; 0 where no Γ is searched.
    starts, converged
        Number of starts of the search, and of those that led to a solution.
    slope
        (n_loads, nf, n_points) t of `dampers.acceleration_slope`; None unless asked for.
    """

    response: Response
    loads: Index
    acceleration_g: Array
    patch_acceleration_g: Array
    cell_acceleration_g: Array
    bare_patch_acceleration_g: Array
    equivalent_damping: Array
    apparent_mass: Array
    inside: Flags
    fixed_points: int
    residual: float = 0.0
    starts: int = 0
    converged: int = 0
    slope: Complexes | None = None


@dataclass(frozen=True)
class _Found:
    """Γ of all loads, rms accelerations of the patches where known [m/s²], and how it was found."""

    gamma: Array
    rms: Array | None = None
    fixed_points: int = 1
    residual: float = 0.0
    starts: int = 0
    converged: int = 0


Solver = PanelSolver | DiagonalSolver


def solve_bare(solver: Solver, pressure_factor: float) -> ScenarioResponse:
    """Return the response without any damper."""
    return solve_layout(solver, (), pressure_factor)


def solve_layout(
    solver: Solver,
    loads: Sequence[Load],
    pressure_factor: float,
    *,
    stated_acceleration_g: float | None = None,
    with_slope: bool = False,
) -> ScenarioResponse:
    """Return the response with dampers whose C_e and m_a are read at their Γ.

    Parameters are those of `Layout`.

    Raises
    ------
    UnstableDamping
        Where C_e is negative, as the paper's law as printed.
    LinearisationError
        Where motion and damping agree nowhere.
    """
    layout = Layout(tuple(loads), pressure_factor, stated_acceleration_g, with_slope)
    (found,) = solve_layouts(solver, [layout])
    if isinstance(found, UnstableDamping):
        raise found
    return found


def solve_layouts(
    solver: Solver, layouts: Sequence[Layout]
) -> list[ScenarioResponse | UnstableDamping]:
    """Return the response of several layouts, with one run over the lines of the result.

    Parameters
    ----------
    solver
        The panel with its patches.
    layouts
        The layouts.

    Returns
    -------
    The error in the place of a response where C_e is negative.

    Raises
    ------
    LinearisationError
        Where motion and damping agree nowhere.
    """
    solver.prepare([layout.patches for layout in layouts])
    found: list[tuple[_Found, Request, Flags] | UnstableDamping] = []
    for layout in layouts:
        try:
            found.append(_dampers(solver, layout))
        except UnstableDamping as error:
            found.append(error)
    steady = [one for one in found if not isinstance(one, UnstableDamping)]
    answers = iter(solver.responses([request for _, request, _ in steady]))
    return [
        one if isinstance(one, UnstableDamping) else _scenario(solver, layout, *one, next(answers))
        for layout, one in zip(layouts, found, strict=True)
    ]


def sine_accelerations_g(acceleration_rms: Array) -> Array:
    """Return Γ = √2 a_rms/g of several rms accelerations [m/s²]."""
    return np.sqrt(2) * acceleration_rms / STANDARD_GRAVITY


def read_dampers(
    loads: Sequence[Load], frequency: Array, gamma: Array
) -> tuple[Array, Array, Flags]:
    """Return C_e, m_a and whether they are inside, each (n_loads, nf), at Γ (n_loads,)."""
    shape = (len(loads), frequency.size)
    value, mass, inside = np.empty(shape), np.empty(shape), np.empty(shape, dtype=np.bool_)
    for index, (load, own) in enumerate(zip(loads, gamma.tolist(), strict=True)):
        value[index], mass[index], inside[index] = load.damping(frequency, own)
    return value, mass, inside


def _dampers(solver: Solver, layout: Layout) -> tuple[_Found, Request, Flags]:
    """Return Γ and the dampers at it."""
    if layout.own not in solver.searched:
        solver.searched[layout.own] = _motion(solver, layout)
    found: _Found = solver.searched[layout.own]
    value, mass, inside = read_dampers(layout.loads, solver.frequency, found.gamma)
    if layout.loads:
        check_stable(value, solver.motions(layout.patches).damping_norm, False)
    return found, Request(layout.patches, value, mass, layout.with_slope), inside


def _scenario(
    solver: Solver, layout: Layout, found: _Found, request: Request, inside: Flags, answer: Answer
) -> ScenarioResponse:
    factor = layout.pressure_factor
    count = len(layout.loads)
    own, cells = np.full(count, np.nan), np.full((count, 2), np.nan)
    if layout.loads and layout.with_motion:
        key = ("moved", layout.own)
        if key not in solver.searched:
            solver.searched[key] = _final_motion(solver, layout, found)
        own, cells = solver.searched[key]
    root = np.sqrt(factor)
    return ScenarioResponse(
        response=answer.response.under(factor),
        loads=np.array(layout.patches, dtype=np.int64),
        acceleration_g=found.gamma,
        patch_acceleration_g=sine_accelerations_g(root * own),
        cell_acceleration_g=sine_accelerations_g(root * cells),
        bare_patch_acceleration_g=sine_accelerations_g(root * solver.bare_acceleration_rms),
        equivalent_damping=request.equivalent_damping,
        apparent_mass=request.apparent_mass,
        inside=inside,
        fixed_points=found.fixed_points,
        residual=found.residual,
        starts=found.starts,
        converged=found.converged,
        slope=None if answer.slope is None else factor * answer.slope,
    )


def _final_motion(solver: Solver, layout: Layout, found: _Found) -> tuple[Array, Array]:
    """Return the rms acceleration of the patches, and of their calmest and liveliest cells."""
    unseen = np.full((len(layout.loads), 2), np.nan)
    if found.rms is not None and solver.panel.cells is None:
        return found.rms, unseen
    value, mass, _ = read_dampers(layout.loads, solver.search_frequency, found.gamma)
    motions = solver.motions(layout.patches)
    if solver.panel.cells is None:
        return motions.acceleration_rms(value, mass), unseen
    covariance = motions.acceleration_covariance(value, mass)
    own = np.sum(motions.weight * covariance, axis=(1, 2)) / motions.area
    return np.sqrt(own), solver.cell_acceleration_rms(layout.patches, covariance)


def _motion(solver: Solver, layout: Layout) -> _Found:
    """Return Γ of all loads."""
    gamma = np.full(len(layout.loads), np.nan)
    if not layout.loads:
        return _Found(gamma, fixed_points=0)
    if layout.stated_acceleration_g is not None:
        return _Found(np.full(len(layout.loads), layout.stated_acceleration_g))
    searched = np.flatnonzero(layout.own_acceleration)
    if searched.size == 0:
        return _Found(gamma)
    # a passive damper can move a patch more than no damper only where its mass tunes a
    # resonance to a peak of the sound, and never to a hundredth
    own = np.array([layout.loads[index].patch for index in searched.tolist()])
    bare = sine_accelerations_g(np.sqrt(layout.pressure_factor) * solver.bare_acceleration_rms[own])
    if len(layout.loads) == 1:
        return _alone(solver, layout, float(bare[0]))
    motions = solver.motions(layout.patches)
    whole = _LogMotion(layout, motions, searched)
    steps = [step for few in FEW_LINES if (step := motions.frequency.size // few) > 1]
    search = find_together(
        [whole, *(_LogMotion(layout, motions.every(step), searched) for step in steps)],
        starts_between(np.log(bare / 100), np.log(3 * bare)),
    )
    taken = search.governing.log_gamma
    gamma[searched] = np.exp(taken)
    return _Found(
        gamma,
        whole.rms[taken.tobytes()],
        len(search.solutions),
        search.governing.residual,
        search.starts,
        search.converged,
    )


def _alone(solver: Solver, layout: Layout, bare: float) -> _Found:
    """Return Γ of one damper, every one in the range."""
    (load,), motions = layout.loads, solver.motions(layout.patches)

    def patch_rms(value: Array, mass: Array) -> float:
        (rms,) = motions.acceleration_rms(value[None], mass[None])
        return float(np.sqrt(layout.pressure_factor) * rms)

    search = find_motions(
        motions.frequency, load.damping, patch_rms, (bare / 100, 3 * bare), scan_count=13
    )
    taken, count = search.governing, len(search.fixed_points)
    return _Found(np.array([taken.gamma]), None, count, abs(taken.residual), 1, 1)


class _LogMotion:
    """ln Γ that the loads end up with over the ln Γ of those that are searched."""

    def __init__(self, layout: Layout, motions: Motions, searched: Index) -> None:
        self._layout, self._motions, self._searched = layout, motions, searched
        self._gamma = np.full(len(layout.loads), np.nan)
        self._value, self._mass = np.empty((2, len(layout.loads), motions.frequency.size))
        for index, load in enumerate(layout.loads):
            if index not in searched:  # is read once
                self._value[index], self._mass[index], _ = load.damping(motions.frequency, np.nan)
        self.rms: dict[bytes, Array] = {}

    def __call__(self, log_gamma: Array) -> Array:
        for index, own in zip(self._searched, np.exp(log_gamma).tolist(), strict=True):
            read = self._layout.loads[index].damping(self._motions.frequency, own)
            self._value[index], self._mass[index], _ = read
        every = self._motions.acceleration_rms(self._value, self._mass)
        self.rms[log_gamma.tobytes()] = every
        rms = np.sqrt(self._layout.pressure_factor) * every[self._searched]
        if not (np.all(np.isfinite(rms)) and np.all(rms > 0)):
            raise LinearisationError(
                f"patches move with rms accelerations of {rms.min()!r} to {rms.max()!r} m/s²: "
                "finite, positive motions are needed"
            )
        return np.log(sine_accelerations_g(rms))
