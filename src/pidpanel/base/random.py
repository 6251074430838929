"""Random motion of the supports: responses of all scenarios, notched to meet limits."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.base.sine import Transfer, interface_force
from pidpanel.damping.broadband import BroadbandError
from pidpanel.response.cases import ResponseScenario, SolvedCase, plan_cases, steady
from pidpanel.response.model_error import (
    broadband_error_of,
    log_error,
    model_error_of,
    with_model_error,
)
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.results import error_parts
from pidpanel.solve.base_motion import BaseExcitation
from pidpanel.solve.layout import LayoutResponse, solve_with
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.receptances import patch_stiffness
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.uncertainty import FurtherPsd, StandardErrors

ROUNDS = 12  # most rounds of notching: damping changes with the motion

STEP = 1e-3  # of ln C_e, and of m_a [kg/m²], in the slopes of the force

SETTLED = 2e-3  # change of ln S of the notched input between rounds at which notching ends

HALVINGS = 80  # bisections for a cap on a PSD: it is then exact to rounding

CAP_ROUNDS = 50  # most rounds over limits of overall values, which depend on each other


@dataclass(frozen=True)
class Limit:
    """A limit of a PSD or of an overall value, in units of one location."""

    location: int  # index of the location among the given gains
    reason: str  # the limit in words, such as "point 326: 0.5 g²/Hz"
    value: float  # largest PSD, or largest rms value
    is_rms: bool = False  # whether the limit is on the overall value


@dataclass(frozen=True)
class NotchedInput:
    """A notched random input and the reasons for its notches."""

    psd: Array  # (nf,) PSD of the input, at most that stated
    reason: Index  # (nf,) index of the limit that applies; −1 where there is no notch


def notch_input(frequency: Array, psd: Array, gain: Array, limits: Sequence[Limit]) -> NotchedInput:
    """Return the input reduced until all limits are met.

    A limit c of a PSD allows an input of c/|H|². A limit of an overall value becomes the highest
    cap on the PSD at that location with which it is met, given all other limits: the highest peaks
    are lowered.

    Parameters
    ----------
    frequency, psd
        (nf,) frequencies [Hz] and stated input.
    gain
        (n_locations, nf) |H|² of each location.
    limits
        Limits in the unit of each location.
    """
    caps = np.array([np.inf if limit.is_rms else limit.value for limit in limits])
    gains = gain[[limit.location for limit in limits]]
    for _ in range(CAP_ROUNDS):
        previous = caps.copy()
        for index in [index for index, limit in enumerate(limits) if limit.is_rms]:
            caps[index] = np.inf
            lowest = np.minimum(psd, (caps[:, None] / gains).min(axis=0))
            caps[index] = _cap(frequency, gains[index] * lowest, limits[index].value)
        if np.allclose(caps, previous, rtol=1e-9, atol=0.0):
            break
    allowed = caps[:, None] / gains
    lowest = np.minimum(psd, allowed.min(axis=0))
    return NotchedInput(lowest, np.where(lowest < psd, allowed.argmin(axis=0), -1))


def _cap(frequency: Array, psd: Array, rms: float) -> float:
    """Return the cap c with ∫ min(S, c) df = rms²; infinite if the rms value is met without."""
    if np.trapezoid(psd, frequency) <= rms**2:
        return np.inf
    low, high = 0.0, float(psd.max())
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if np.trapezoid(np.minimum(psd, middle), frequency) > rms**2:
            high = middle
        else:
            low = middle
    return low


@dataclass(frozen=True)
class RandomResponse:
    """A scenario under a random motion of the supports, SI throughout."""

    input: Array  # (nf,) PSD of the acceleration of the supports [(m/s²)²/Hz]
    # (nf, n_points) PSD of the absolute acceleration [(m/s²)²/Hz], and of the deflection relative
    # to the supports [m²/Hz]
    absolute: Array
    relative: Array
    force: Array  # (nf,) PSD of the force of all supports on panel and particles [N²/Hz]
    # Standard errors of the absolute accelerations at the points, then of the force; None if the
    # damping has none
    errors: StandardErrors | None
    outside_share: float  # share of the lines on which damping is extrapolated [1]


@dataclass(frozen=True)
class RandomCase:
    """A scenario under random motion."""

    scenario: ResponseScenario
    frequency: Array  # (nf,) [Hz]
    stated: RandomResponse | None  # under the stated input; None where C_e feeds the panel
    # Under the notched input; None without limits
    notched: RandomResponse | None = None
    notches: NotchedInput | None = None


def random_cases(
    panel: ResponsePanel,
    observed: Array,
    scenarios: Sequence[ResponseScenario],
    limits: Sequence[Limit],
    coupled_errors: Mapping[str, StandardErrors],
) -> list[RandomCase]:
    """Return the responses of every scenario.

    Parameters
    ----------
    panel
        Panel under a `BaseExcitation`, with the translation in its basis.
    observed
        (nw, n) rows of the motions of `solve.base_motion.observed_motions`.
    scenarios
        Layouts of dampers.
    limits
        Limits in SI by location: points, then the interface; none for no notching.
    coupled_errors
        Standard errors of the coupled runs, by label of the scenario.
    """
    solver = panel.solver().with_lines(panel.frequency, observed)
    cases = []
    for case in plan_cases(panel, scenarios).solve(solver):
        if isinstance(case.response, UnstableDamping):
            print(f"{case.scenario.label}: {case.response}", file=sys.stderr)
            cases.append(RandomCase(case.scenario, panel.frequency, None))
            continue
        stated = _response(case, case.response)
        if case.scenario.label in coupled_errors:
            errors = _of_points(coupled_errors[case.scenario.label])
            input_errors = error_parts(case, case.response)[1]  # the last point is the base
            stated = replace(stated, errors=with_model_error(errors, input_errors))
        random = RandomCase(case.scenario, panel.frequency, stated)
        cases.append(_with_notches(random, case, solver, limits) if limits else random)
    return cases


def _of_points(errors: StandardErrors) -> StandardErrors:
    """Return errors of points only, with an unknown error of the force."""
    return replace(
        errors,
        log_psd=np.pad(errors.log_psd, ((0, 0), (0, 1)), constant_values=np.nan),
        log_rms=np.append(errors.log_rms, np.nan),
    )


def _with_notches(
    random: RandomCase, case: SolvedCase, solver: PanelSolver, limits: Sequence[Limit]
) -> RandomCase:
    """Return the case with the input that meets all limits at its own motion."""
    frequency, response = random.frequency, random.stated
    if response is None:
        return random
    stated = response.input
    for _ in range(ROUNDS):
        outputs = np.column_stack([response.absolute, response.force]).T
        lowered = notch_input(frequency, stated, outputs / response.input, limits)
        change = np.abs(np.log(lowered.psd / response.input)).max()
        if change < SETTLED:
            break

        def level(f: Array, psd: Array = lowered.psd) -> Array:
            return np.interp(f, frequency, psd)

        base = cast(BaseExcitation, solver.excitation)
        notched_solver = solver.with_excitation(replace(base, level=level))
        (answer,) = solve_with(notched_solver, [case.layout])
        response = _response(replace(case, solver=notched_solver, response=answer), steady(answer))
    return replace(random, notched=response, notches=lowered)


def _response(case: SolvedCase, response: LayoutResponse) -> RandomResponse:
    frequency, cross = response.response.frequency, response.response.cross_psd
    points = cross[:, :-1]
    omega = 2 * np.pi * frequency
    force = interface_force_psd(response, cross[:, -1])
    if case.layout.force is not None:
        force = force + own_force_on_supports(case, response)
    inside = response.inside.all(axis=0).mean() if len(response.inside) else 1.0
    return RandomResponse(
        case.solver.excitation.spectrum(frequency),
        omega[:, None] ** 4 * points[:, :, 0, 0].real,
        np.asarray(points[:, :, 1, 1].real, dtype=np.float64),
        force,
        _errors(case, response, force),
        1 - float(inside),
    )  # fmt: skip


def own_force_on_supports(case: SolvedCase, response: LayoutResponse) -> Array:
    """Return what the own force of the particles changes in the PSD of the force (nf,) [N²/Hz].

    `interface_force_psd` has the motion that the own force N makes, but not N itself. The table has
    M_t z̈ = N − Σ s_p ∫_p u dA from it, so that −ω² 1ᵀM u + Σ s_p ∫_p u dA − N, what the supports
    feel, is −ω² (1ᵀM u − M_t z).
    """
    own_force, solver = case.layout.force, case.solver
    if own_force is None:
        raise ValueError("no own force")
    f, interface = response.response.frequency, solver.panel.points[-1]
    table = solver.panel.basis.modal_mass[-1] * np.eye(interface.shape[1])[-1]
    rows = np.vstack([interface, table])[None]
    force_solver = solver.with_lines(f, rows).with_excitation(own_force)
    layout = replace(case.layout, force=None, factor=1.0, with_slope=False, with_motion=False)
    (answer,) = solve_with(force_solver, [layout])
    cross = steady(answer).response.cross_psd[:, 0]
    motion = interface_force_psd(response, cross[:, :-1, :-1])
    relative = cross[:, 0, 0] - 2 * cross[:, 0, -1] + cross[:, -1, -1]
    return np.asarray((2 * np.pi * f) ** 4 * relative.real - motion)


def _errors(case: SolvedCase, response: LayoutResponse, force: Array) -> StandardErrors | None:
    """Return the errors of the points, then of the force, from those of the damping."""
    if case.scenario.is_coupled or not case.dampers:
        return None
    slopes = force_slopes(case.solver, response, force)
    stated = with_model_error(*error_parts(case, response, slopes))
    if stated is not None:  # before the force is 1ᵀM u, in the place of a point
        stated = replace(
            stated,
            log_psd=np.delete(stated.log_psd, -2, axis=1),
            log_rms=np.delete(stated.log_rms, -2),
        )
    model = model_error_of(case, response)
    if model is not None:
        f, without = response.response.frequency, case.dead_weight or case.bare
        undamped = interface_force_psd(without, without.response.cross_psd[:, -1])
        error = broadband_error_of(case)
        psd_error = log_error(BroadbandError(error.of_effect, 2 * error.of_rms), undamped, force)
        rms = np.sqrt([np.trapezoid(psd, f) for psd in (undamped, force)])
        model.log_psd[:, -1], model.log_rms[-1] = psd_error, log_error(error, rms[0], rms[1])
    return with_model_error(stated, model)


def force_slopes(solver: PanelSolver, response: LayoutResponse, force: Array) -> FurtherPsd:
    """Return how ln of the PSD of the force (nf,) follows C_e and m_a, by central differences."""
    panel, patches = solver.panel, response.patches.tolist()
    f, carriers = panel.frequency, panel.patches.subset(patches)
    base = cast(BaseExcitation, solver.excitation)
    transfer = Transfer.of_panel(f, panel.basis, carriers, base.force, panel.points[-1])

    def log_psd(damping: Array, mass: Array) -> Array:
        stiffness = patch_stiffness(f, damping, mass)
        motion = transfer.motions(stiffness)
        reaction = interface_force(f, motion, patches, stiffness)
        return np.asarray(2 * np.log(np.abs(reaction)))

    value, mass = response.equivalent_damping, response.apparent_mass
    damping_slope, mass_slope = np.empty((2, len(patches), f.size, 1))
    for index, unit in enumerate(np.eye(len(patches))[:, :, None]):
        step = STEP * unit
        change = log_psd(value * (1 + step), mass) - log_psd(value * (1 - step), mass)
        damping_slope[index, :, 0] = change / (2 * STEP)
        change = log_psd(value, mass + step) - log_psd(value, mass - step)
        mass_slope[index, :, 0] = change / (2 * STEP)
    return FurtherPsd(force[:, None], damping_slope, mass_slope)


def interface_force_psd(response: LayoutResponse, cross_psd: Complexes) -> Array:
    """Return the PSD (nf,) of the force of the supports [N²/Hz] with the dampers of a response.

    It is that of all momenta, −ω² 1ᵀM u + Σ_p s_p ∫_p u dA.

    Parameters
    ----------
    cross_psd
        (nf, m, m) of the motions of the interface, see `solve.base_motion.observed_motions`.
    """
    frequency = response.response.frequency
    share = np.zeros(cross_psd.shape[:2], dtype=np.complex128)
    share[:, 0] = -((2 * np.pi * frequency) ** 2)
    stiffness = patch_stiffness(frequency, response.equivalent_damping, response.apparent_mass)
    for patch, s in zip(response.patches.tolist(), stiffness, strict=True):
        share[:, 1 + patch] += s
    psd = np.einsum("fi,fij,fj->f", share, cross_psd, share.conj()).real
    return np.asarray(psd, dtype=np.float64)
