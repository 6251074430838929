"""Layouts: dampers on patches, whose damping depends on the motion of their patch.

C_e(f, Γ) is evaluated at a Γ that is either stated or consistent: the motions of all patches with
dampers reproduce themselves together (`search`).
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from pidpanel.arrays import Array, Flags, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.progress import map_in_forks
from pidpanel.solve.dampers import check_stable
from pidpanel.solve.excitation import Excitation, Superposition
from pidpanel.solve.model import PanelResponse, UnstableDamping
from pidpanel.solve.motions import Motions
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.receptances import traces
from pidpanel.solve.search import LinearisationError, find_motions, governing, starts_between
from pidpanel.solve.solvers import PanelSolver, Request

# (frequency (nf,) [Hz], Γ) → C_e (nf,) [N s/m³], m_a (nf,) [kg/m²], within the range of its data
# (nf,).
DampingOfMotion = Callable[[Array, float], tuple[Array, Array, Flags]]

# Lines on which several Γ are searched before all lines of the search are used.
FEW_LINES = 120

# Tolerance of |ln(Γ_out/Γ)| for a single damper, where an evaluation costs little.
CLOSE = 1e-12


@dataclass(frozen=True)
class AttachedDamper:
    """A damper on a patch, as the solver takes it."""

    patch: int
    damping: DampingOfMotion  # C_e and m_a of the filled patch as a function of frequency and Γ
    depends_on_acceleration: bool = True  # whether `damping` depends on Γ at all


@dataclass(frozen=True)
class DamperLayout:
    """Dampers that are on the panel together, and how strongly it is excited."""

    dampers: Sequence[AttachedDamper]  # the dampers; none for the bare panel
    factor: float = 1.0  # factor on the PSD of the excitation
    # Γ at which damping is evaluated; None for the motion of each patch
    stated_acceleration_g: float | None = None
    with_slope: bool = False  # whether to compute the sensitivity to damping, for `uncertainty`
    # Whether to return the motion of the patches; NaN otherwise
    with_motion: bool = True
    # Additional independent force, such as that of the particles, not scaled by ``factor``; None
    # for none
    force: Excitation | None = None

    @property
    def patches(self) -> tuple[int, ...]:
        """Indices of the loaded patches."""
        return tuple(d.patch for d in self.dampers)

    @property
    def search_key(self) -> Hashable:
        """Key of all that the search for Γ depends on."""
        return tuple(self.dampers), self.factor, self.stated_acceleration_g

    @property
    def follows_motion(self) -> Flags:
        """(n_loads,) whether Γ of a load is that of the motion of its patch."""
        stated = self.stated_acceleration_g is not None
        return np.array([d.depends_on_acceleration and not stated for d in self.dampers], bool)


@dataclass(frozen=True)
class LayoutResponse:
    """A response and the damping it was computed with."""

    response: PanelResponse
    patches: Index  # (n_loads,) indices of the loaded patches; none on the bare panel
    acceleration_g: Array  # (n_loads,) Γ at which damping was evaluated; NaN for a law without Γ
    # (n_loads,) Γ of the sine with the resulting rms acceleration of the patch
    patch_acceleration_g: Array
    # (n_loads, 2) lowest and highest such Γ of a cell of the patch; NaN without cells
    cell_acceleration_g: Array
    # (n_patches,) Γ of every patch of the solver on the bare panel under the same excitation
    bare_patch_acceleration_g: Array
    # (n_loads, nf) C_e [N s/m³] and m_a [kg/m²]
    equivalent_damping: Array
    apparent_mass: Array
    inside: Flags  # (n_loads, nf) whether the damping is within the range of its data
    # Number of distinct sets of Γ found that reproduce themselves; 0 on the bare panel
    fixed_points: int
    residual: float = 0.0  # largest |ln(Γ_out/Γ)| at the one taken; 0 where no Γ is searched


@dataclass(frozen=True)
class ConsistentMotion:
    """Result of the search for a layout."""

    gamma: Array  # (n_loads,) Γ
    rms: Array | None = None  # (n_loads,) rms accelerations of the patches if known [m/s²]
    fixed_points: int = 1  # number of distinct sets of Γ that reproduce themselves
    residual: float = 0.0  # largest |ln(Γ_out/Γ)|


# Results of a search; the error where C_e is negative.
SearchResults = Sequence[ConsistentMotion | UnstableDamping]

T = TypeVar("T")
V = TypeVar("V")


def layouts(
    panel: ModalPanel, excitation: Excitation, layouts: Sequence[DamperLayout]
) -> list[LayoutResponse | UnstableDamping]:
    """Return the response of a panel with layouts of dampers at their consistent motion.

    Parameters
    ----------
    panel
        Modal panel with patches and points.
    excitation
        Random force on its modes.
    layouts
        Layouts of dampers, each solved on its own.

    Returns
    -------
    PSDs at the points and motions of the patches of each layout; an error instead of a response if
    C_e is negative.

    Raises
    ------
    LinearisationError
        If no consistent motion is found.
    ResponseError
        If shapes of arrays disagree or a value is not finite.

    See Also
    --------
    solve_with : the same with a solver that is used again.
    """
    return solve_with(PanelSolver(panel, excitation), layouts)


def solve_with(
    solver: PanelSolver, layouts: Sequence[DamperLayout], motions: SearchResults | None = None
) -> list[LayoutResponse | UnstableDamping]:
    """Return the same as `layouts`, in one run over the lines of the result; raise likewise.

    A layout with an additional force is solved on its own. ``motions`` of an earlier
    `search_motions` do not depend on the lines of the result; None searches.
    """
    motions = search_motions(solver, layouts) if motions is None else motions
    return by_force(solver, list(zip(layouts, motions, strict=True)), _solve_together)


def search_motions(solver: PanelSolver, layouts: Sequence[DamperLayout]) -> SearchResults:
    """Return the consistent motion of each layout; raise as `layouts`."""
    return by_force(solver, [(layout, None) for layout in layouts], _search)


def by_force(
    solver: PanelSolver,
    cases: Sequence[tuple[DamperLayout, T]],
    solve: Callable[[PanelSolver, Sequence[tuple[DamperLayout, T]]], Sequence[V]],
) -> list[V]:
    """Return what is solved together without an additional force, and apart with one."""
    plain = iter(solve(solver, [case for case in cases if case[0].force is None]))
    answers = []
    for case in cases:
        layout = case[0]
        if layout.force is None:
            answers.append(next(plain))
        else:
            excitation = Superposition(solver.excitation, layout.force, 1 / layout.factor)
            answers += solve(solver.with_excitation(excitation), [case])
    return answers


def _solve_together(
    solver: PanelSolver,
    cases: Sequence[tuple[DamperLayout, ConsistentMotion | UnstableDamping]],
) -> list[LayoutResponse | UnstableDamping]:
    dampers = [_dampers(solver, *case) for case in cases]
    steady = [case for case in dampers if not isinstance(case, UnstableDamping)]
    answers = iter(solver.responses([request for _, request, _ in steady]))
    return [
        case
        if isinstance(case, UnstableDamping)
        else _response(solver, layout, *case, next(answers))
        for (layout, _), case in zip(cases, dampers, strict=True)
    ]


def _search(solver: PanelSolver, cases: Sequence[tuple[DamperLayout, None]]) -> SearchResults:
    """Return the motion of each layout; equal ones are searched once."""
    solver.prepare([layout.patches for layout, _ in cases])
    searches = {layout.search_key: layout for layout, _ in cases}
    distinct = list(searches.values())
    for layout in distinct:
        if layout.follows_motion.any():
            solver.motions(layout.patches).prepare()
            _ = solver.bare_acceleration_rms

    def search(number: int) -> ConsistentMotion | UnstableDamping:
        try:
            return _consistent_motion(solver, distinct[number])
        except UnstableDamping as error:
            return error

    results = dict(zip(searches, map_in_forks(search, range(len(distinct))), strict=True))
    return [results[layout.search_key] for layout, _ in cases]


def sine_accelerations_g(acceleration_rms: Array) -> Array:
    """Return Γ = √2 a_rms/g of several rms accelerations [m/s²]."""
    return np.sqrt(2) * acceleration_rms / STANDARD_GRAVITY


def evaluate_dampers(
    dampers: Sequence[AttachedDamper], frequency: Array, gamma: Array
) -> tuple[Array, Array, Flags]:
    """Return C_e, m_a and whether they are inside, each (n_loads, nf), at Γ (n_loads,)."""
    shape = (len(dampers), frequency.size)
    value, mass, inside = np.empty(shape), np.empty(shape), np.empty(shape, dtype=np.bool_)
    for index, (damper, motion) in enumerate(zip(dampers, gamma.tolist(), strict=True)):
        value[index], mass[index], inside[index] = damper.damping(frequency, motion)
    return value, mass, inside


def _dampers(
    solver: PanelSolver, layout: DamperLayout, motion: ConsistentMotion | UnstableDamping
) -> tuple[ConsistentMotion, Request, Flags] | UnstableDamping:
    """Return Γ and the dampers at this Γ."""
    if isinstance(motion, UnstableDamping):
        return motion
    value, mass, inside = evaluate_dampers(layout.dampers, solver.panel.frequency, motion.gamma)
    try:
        check_stable(value)
    except UnstableDamping as error:
        return error
    return motion, Request(layout.patches, value, mass, layout.with_slope), inside


def _response(
    solver: PanelSolver,
    layout: DamperLayout,
    motion: ConsistentMotion,
    request: Request,
    inside: Flags,
    answer: PanelResponse,
) -> LayoutResponse:
    count, root = len(layout.dampers), np.sqrt(layout.factor)
    rms, cells = np.full(count, np.nan), np.full((count, 2), np.nan)
    if layout.dampers and layout.with_motion:
        rms, cells = _final_motion(solver, layout, motion)
    return LayoutResponse(
        response=answer.scaled(layout.factor),
        patches=np.array(layout.patches, dtype=np.int64),
        acceleration_g=motion.gamma,
        patch_acceleration_g=sine_accelerations_g(root * rms),
        cell_acceleration_g=sine_accelerations_g(root * cells),
        bare_patch_acceleration_g=sine_accelerations_g(root * solver.bare_acceleration_rms),
        equivalent_damping=request.equivalent_damping,
        apparent_mass=request.apparent_mass,
        inside=inside,
        fixed_points=motion.fixed_points,
        residual=motion.residual,
    )


def _final_motion(
    solver: PanelSolver, layout: DamperLayout, motion: ConsistentMotion
) -> tuple[Array, Array]:
    """Return the rms acceleration of the patches, and the range over their cells."""
    no_cells = np.full((len(layout.dampers), 2), np.nan)
    if motion.rms is not None and solver.panel.cells is None:
        return motion.rms, no_cells
    value, mass, _ = evaluate_dampers(layout.dampers, solver.panel.search_frequency, motion.gamma)
    motions = solver.motions(layout.patches)
    if solver.panel.cells is None:
        return motions.acceleration_rms(value, mass), no_cells
    covariance = motions.acceleration_covariance(value, mass)
    square = traces(motions.coordinates.weight, covariance[None])[:, 0] / motions.area
    return np.sqrt(square), solver.cell_acceleration_rms(layout.patches, covariance)


def _consistent_motion(solver: PanelSolver, layout: DamperLayout) -> ConsistentMotion:
    """Return Γ of all loads."""
    gamma = np.full(len(layout.dampers), np.nan)
    if not layout.dampers:
        return ConsistentMotion(gamma, fixed_points=0)
    if layout.stated_acceleration_g is not None:
        return ConsistentMotion(np.full(len(layout.dampers), layout.stated_acceleration_g))
    searched = np.flatnonzero(layout.follows_motion)
    if searched.size == 0:
        return ConsistentMotion(gamma)
    # a passive damper can move a patch more than no damper only where its mass tunes a
    # resonance to a peak of the excitation, and never to a hundredth
    patches = np.array([layout.dampers[index].patch for index in searched.tolist()])
    bare = sine_accelerations_g(np.sqrt(layout.factor) * solver.bare_acceleration_rms[patches])
    motions = solver.motions(layout.patches)
    full_map = _LogMotion(layout, motions, searched)
    maps, several = [full_map], len(layout.dampers) > 1
    if several and (step := motions.frequency.size // FEW_LINES) > 1:
        maps.append(_LogMotion(layout, motions.subsampled(step), searched))
    solutions = find_motions(
        maps, starts_between(np.log(bare / 100), np.log(3 * bare)), aim=None if several else CLOSE
    )
    chosen = governing(solutions)
    gamma[searched] = np.exp(chosen.log_gamma)
    rms = full_map.rms[chosen.log_gamma.tobytes()]
    return ConsistentMotion(gamma, rms, len(solutions), chosen.residual)


class _LogMotion:
    """ln Γ that the loads end up with over the ln Γ of those that are searched."""

    def __init__(self, layout: DamperLayout, motions: Motions, searched: Index) -> None:
        self._layout, self._motions, self._searched = layout, motions, searched
        self._value, self._mass = np.empty((2, len(layout.dampers), motions.frequency.size))
        for index, damper in enumerate(layout.dampers):
            if index not in searched:  # is read once
                self._value[index], self._mass[index], _ = damper.damping(motions.frequency, np.nan)
        self.rms: dict[bytes, Array] = {}

    def __call__(self, log_gamma: Array) -> Array:
        for index, gamma in zip(self._searched, np.exp(log_gamma).tolist(), strict=True):
            read = self._layout.dampers[index].damping(self._motions.frequency, gamma)
            self._value[index], self._mass[index], _ = read
        motion = self._motions.acceleration_rms(self._value, self._mass)
        self.rms[log_gamma.tobytes()] = motion
        rms = np.sqrt(self._layout.factor) * motion[self._searched]
        if not (np.all(np.isfinite(rms)) and np.all(rms > 0)):
            raise LinearisationError(
                f"patches move with rms accelerations of {rms.min()!r} to {rms.max()!r} m/s²: "
                "finite, positive motions are needed"
            )
        return np.log(sine_accelerations_g(rms))
