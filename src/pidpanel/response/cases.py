"""Every scenario: what is solved, and the responses."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.laws import ConstantDamper
from pidpanel.damping.models import FilledDamper
from pidpanel.response.panel import ResponsePanel
from pidpanel.solve.excitation import Excitation
from pidpanel.solve.layout import (
    AttachedDamper,
    DamperLayout,
    LayoutResponse,
    SearchResults,
    search_motions,
    solve_with,
)
from pidpanel.solve.lines import (
    LINES_AT_MOST,
    LINES_PER_BANDWIDTH,
    line_count,
    smallest_damping_ratio,
)
from pidpanel.solve.model import ResponseError, UnstableDamping
from pidpanel.solve.power import power_balance
from pidpanel.solve.sharpness import least_damping_ratio
from pidpanel.solve.solvers import PanelSolver

# To a bandwidth of what the masses of dampers make sharper; see `lines.frequency_grid`.
ENOUGH_LINES = 4.0

# The same where `LINES_AT_MOST` allow no more: a mean square is then within 2e-4.
FEWEST_LINES = 3.0

MASS_LINES = 12  # frequencies at which the mass of a damper is taken before its motion is known

# Fewest and most lines on which the power balance of each scenario is checked.
BALANCE_LINES = (2, 12)

BALANCE_WORK = 1e8  # shapes cubed times lines of a power balance, a dense solve each


@dataclass(frozen=True)
class ResponseScenario:
    """A scenario of a study."""

    # Its label, and that of the bare panel under the same sound
    label: str
    bare_label: str
    oaspl_db: float  # overall level [dB]
    factor: float  # PSD of the pressure over that of the study [1]
    dampers: Mapping[str, FilledDamper] = field(default_factory=dict)  # by patch
    source: str = "none"  # where its damping comes from
    is_coupled: bool = False  # whether it has coupled runs
    is_coarse: bool = False  # whether a sweep of its dampers is, see `Sweep.is_coarse`
    is_of_atlas: bool = False  # whether a damper is read from the atlas

    @property
    def patches(self) -> tuple[str, ...]:
        """Names of the patches with dampers."""
        return tuple(self.dampers)

    @property
    def is_bare(self) -> bool:
        """Whether there is no damper."""
        return not self.dampers

    @property
    def fill_fraction(self) -> float:
        """Fill of the only patch; 0 for the bare panel, NaN for several or for none."""
        fills = [damper.fill_fraction for damper in self.dampers.values()]
        if len(fills) == 1 and fills[0] is not None:
            return fills[0]
        return np.nan if fills else 0.0


@dataclass(frozen=True)
class SolvedCase:
    """A scenario and its response."""

    scenario: ResponseScenario
    # Its response; the error where the damping feeds the panel
    response: LayoutResponse | UnstableDamping
    bare: LayoutResponse
    solver: PanelSolver
    layout: DamperLayout
    dampers: Sequence[FilledDamper]  # in the order of the loads of the layout
    # The response with the same masses in the same places and no damping; None where a mass is not
    # known, and for the bare panel
    dead_weight: LayoutResponse | None

    def masses(self, area: Array) -> Array:
        """Return the mass [kg] of each damper on its area (n_loads,) [m²]; NaN where unknown."""
        per_area = [damper.mass_per_area for damper in self.dampers]
        return np.array(per_area, dtype=np.float64) * area


Loads = Sequence[tuple[int, FilledDamper]]  # dampers with their carriers in the solver


@dataclass(frozen=True)
class CasePlan:
    """Cases to be solved."""

    # Every scenario, its dampers with their carriers, and the keys of its own layout, of the bare
    # panel and of the dead weight
    rows: Sequence[tuple[ResponseScenario, Loads, Hashable, Hashable, Hashable]]
    layouts: Mapping[Hashable, DamperLayout]

    def response_alone(self) -> CasePlan:
        """Return the same without the motions of the patches and the slopes."""
        layouts = {
            key: replace(layout, with_motion=False, with_slope=False)
            for key, layout in self.layouts.items()
        }
        return replace(self, layouts=layouts)

    def search(self, solver: PanelSolver) -> SearchResults:
        """Return the motions of all layouts, for `solve`."""
        return search_motions(solver, list(self.layouts.values()))

    def solve(self, solver: PanelSolver, motions: SearchResults | None = None) -> list[SolvedCase]:
        """Return the responses, at motions that were searched or are now."""
        layouts = self.layouts
        together = solve_with(solver, list(layouts.values()), motions)
        answers = dict(zip(layouts, together, strict=True))
        return [
            SolvedCase(
                scenario=scenario,
                response=answers[key],
                bare=steady(answers[bare]),
                solver=solver,
                layout=layouts[key],
                dampers=[damper for _, damper in loads],
                dead_weight=None if dead is None else steady(answers[dead]),
            )
            for scenario, loads, key, bare, dead in self.rows
        ]


def plan_cases(
    panel: ResponsePanel,
    scenarios: Sequence[ResponseScenario],
    *,
    dead_weight: bool = True,
) -> CasePlan:
    """Return what is to be solved for every scenario.

    Parameters
    ----------
    dead_weight
        Whether to include the same masses without damping, once for each distinct set of
        patches, masses and level.
    """
    # the bare panel once a level, dead weight once for each set of masses and level
    rows: list[tuple[ResponseScenario, Loads, Hashable, Hashable, Hashable]] = []
    layouts: dict[Hashable, DamperLayout] = {}
    for scenario in scenarios:
        loads, bare = loads_of(panel, scenario), scenario.factor
        key: Hashable = bare
        dead: Hashable = None
        layouts.setdefault(bare, DamperLayout((), scenario.factor))
        if loads:
            key = scenario.label
            layouts[key] = _layout(panel, scenario, loads)
            masses = tuple((carrier, damper.mass_per_area) for carrier, damper in loads)
            if dead_weight and np.isfinite([mass for _, mass in masses]).all():
                dead = (masses, scenario.factor)
                undamped = [
                    (carrier, FilledDamper("", ConstantDamper(apparent_mass=mass)))
                    for carrier, mass in masses
                ]
                weight = DamperLayout(attached(undamped), scenario.factor, with_motion=False)
                layouts.setdefault(dead, weight)
        rows.append((scenario, loads, key, bare, dead))
    return CasePlan(rows, layouts)


def heaviest_dampers(panel: ResponsePanel, scenarios: Sequence[ResponseScenario]) -> Array:
    """Return the largest mass or apparent mass on each patch, (n_patches,) [kg/m²]."""
    mass = np.zeros(len(panel.patch_area))
    lines = np.geomspace(*panel.settings.frequency_range, MASS_LINES)
    dampers = [item for scenario in scenarios for item in scenario.dampers.items()]
    distinct = {(patch, damper.name, damper.fill_fraction): damper for patch, damper in dampers}
    for (name, *_), damper in distinct.items():
        patch = panel.basis.patch_names.index(name)
        mass[patch] = max(mass[patch], damper.largest_mass(lines))
    return mass


def resolve(panel: ResponsePanel, mass: Array) -> ResponsePanel:
    """Return the panel with lines for the resonances that the masses of its dampers make.

    A mass that is light relative to the panel does not change the lines: of their eight to a
    bandwidth `ENOUGH_LINES` do.
    """
    low, high = panel.settings.frequency_range
    damping_ratio = panel.settings.damping_ratio.smallest(low, high)
    lower = least_damping_ratio(panel.modal, panel.basis.patch_overlap, mass, (low, high))
    ratio = min(damping_ratio, lower * LINES_PER_BANDWIDTH / ENOUGH_LINES)
    smallest = smallest_damping_ratio(low, high)
    if ratio < min(smallest, damping_ratio) * FEWEST_LINES / ENOUGH_LINES:
        raise ResponseError(
            f"dampers of up to {mass.max():.3g} kg/m² leave resonances with a damping ratio of"
            f" {lower:.2g}, which takes {line_count(low, high, ratio)} frequency lines from {low:g}"
            f" to {high:g} Hz; allowed are {LINES_AT_MOST}: a larger panel.damping_ratio, or a"
            " narrower response.frequency_hz"
        )
    return replace(panel, least_damping_ratio=max(ratio, min(smallest, damping_ratio)))


def balance_of(panel: ResponsePanel) -> Callable[[LayoutResponse, float], float]:
    """Return a function for the largest error of the power balance of a response [1].

    Its arguments are the response, and the factor on the PSD of the excitation.
    """
    count = int(np.clip(BALANCE_WORK / len(panel.basis.modal_mass) ** 3, *BALANCE_LINES))
    step = max(1, len(panel.frequency) // count)
    lines = slice(step // 2, None, step)
    frequency = panel.frequency[lines]
    force, spectrum = panel.excitation(frequency), panel.excitation.spectrum(frequency)
    air = None if panel.air is None else panel.air(frequency)

    def error(response: LayoutResponse, factor: float) -> float:
        patches = panel.carrier_patches.subset(response.patches.tolist())
        damping, mass = response.equivalent_damping[:, lines], response.apparent_mass[:, lines]
        balance = power_balance(
            frequency, panel.modal, patches, factor * spectrum, force, damping, mass, air
        )
        return float(balance.error.max())

    return error


def loads_of(panel: ResponsePanel, scenario: ResponseScenario) -> Loads:
    """Return the dampers of a scenario with their carriers in the solver."""
    loads: list[tuple[int, FilledDamper]] = []
    for name, damper in scenario.dampers.items():
        patch = panel.basis.patch_names.index(name)
        loads += [(carrier, damper) for carrier in np.flatnonzero(panel.carriers == patch).tolist()]
    return loads


def attached(loads: Loads) -> tuple[AttachedDamper, ...]:
    """Return dampers as the solver takes them."""
    return tuple(
        AttachedDamper(carrier, damper.damping, damper.depends_on_acceleration)
        for carrier, damper in loads
    )


def own_force_of(panel: ResponsePanel, scenario: ResponseScenario) -> Excitation | None:
    """Return the own force of the particles of a scenario on the modes; None without any."""
    names = panel.basis.patch_names
    beds = {names.index(patch): d.model.coupled for patch, d in scenario.dampers.items()}
    known = {patch: bed for patch, bed in beds.items() if bed is not None}
    return panel.particle_force(known) if known else None


def _layout(panel: ResponsePanel, scenario: ResponseScenario, loads: Loads) -> DamperLayout:
    return DamperLayout(
        attached(loads),
        scenario.factor,
        panel.settings.stated_acceleration_g,
        with_slope=any(damper.model.nodes is not None for _, damper in loads),
        force=own_force_of(panel, scenario),
    )


def steady(response: LayoutResponse | UnstableDamping) -> LayoutResponse:
    """Return a response; where the damping feeds the panel, raise its error."""
    if isinstance(response, UnstableDamping):
        raise response
    return response
