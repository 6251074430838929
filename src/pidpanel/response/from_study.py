"""The panel of a study in its sound, ready for any damper.

The only door of the stage for the study; behind it are functions of arrays. `results` writes the
files of the stage, `rounds` the rounds of tones.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags, Index
from pidpanel.damping.from_study import reading_of, reading_of_damper
from pidpanel.damping.readings import DampingReading
from pidpanel.panel.basis import PanelBasis, patch_areas
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.plate_files import StoredPlate
from pidpanel.paths import SECTION, of_damper
from pidpanel.plane_mesh import cell_areas
from pidpanel.response.basis_error import cutoff_frequency, damping_ratios, joined_shapes, refined
from pidpanel.response.coupled_damping import CoupledDamping, read_coupled
from pidpanel.response.linearisation import DampingOfMotion
from pidpanel.response.lines import (
    LINES_PER_BANDWIDTH,
    frequency_grid,
    smallest_damping_ratio,
)
from pidpanel.response.model import ModalBasis, Patches, UnstableDamping
from pidpanel.response.power import power_balance
from pidpanel.response.radiation import Air
from pidpanel.response.scenarios import Layout, Load, ScenarioResponse, Solver, solve_layouts
from pidpanel.response.sharpness import least_damping_ratio
from pidpanel.response.solvers import DiagonalSolver, PanelInField, PanelSolver
from pidpanel.response.source import between, elements_of_patch
from pidpanel.sound.field import wavenumber
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE, read_table
from pidpanel.sound.from_study import air_tables, modal_force_tables, spectrum_of
from pidpanel.sound.spectrum import BandSpectrum, pressure_psd
from pidpanel.sound.wavenumber_table import WavenumberTable
from pidpanel.study import Filling, Scenario, Study
from pidpanel.study.damping import COUPLED
from pidpanel.study.response import Radiation

COARSE_LINES_PER_BANDWIDTH = 3.0
"""Of the search for Γ: rms of the patch within 1e-3."""

ENOUGH_LINES = 4.0
"""To a bandwidth of what the masses of dampers make sharper; see `lines.frequency_grid`."""

MOTIONS_G, MASS_LINES = (1.0, 10.0, 100.0, 1000.0), 12
"""Γ, and how many lines, at which a damper's mass is looked up before its motion is known."""

BALANCE_LINES = (2, 12)
"""Fewest and most lines on which the power balance of each scenario is checked."""

BALANCE_WORK = 1e8
"""Shapes cubed times lines of a power balance, a dense solve each."""

OWN_FORCE_NODES = 25
"""Frequencies at which the modal load of the particles' own force is computed; linear in ln f
between them."""

HELD = 1e-6
"""Motion of a point over the largest of its shape below which it does not move [1]: rounding is
1e-16 of the shape, and no panel is known to a millionth."""

WETTED_SIDES = {"one_side": 1, "two_sides": 2}


class PanelFiles(NamedTuple):
    """Files of the stages upstream from which a response is computed."""

    modes: Path
    modal_force: Path
    air: Path | None


@dataclass(frozen=True)
class SolvedScenario:
    """A scenario in a reading of the damping, and what came of it.

    Attributes
    ----------
    scenario, reading
        Which.
    found
        Its response; the error where the damping feeds the panel.
    bare
        The bare panel under the same sound.
    pressure_factor
        S_p over that of the study.
    solver, layout
        What it was computed with.
    filled
        What each load is filled with, in the order of the loads.
    dead_weight
        The response with the same masses in the same places and no damping; None where a mass is
        not known, and for the bare panel.
    """

    scenario: Scenario
    reading: str
    found: ScenarioResponse | UnstableDamping
    bare: ScenarioResponse
    pressure_factor: float
    solver: Solver
    layout: Layout
    filled: Sequence[Filled]
    dead_weight: ScenarioResponse | None

    def masses(self, area: Array) -> Array:
        """Return the mass [kg] of each load on its area (n_loads,) [m²]; NaN where not known."""
        per_area = np.array([one.mass_per_area for one in self.filled], dtype=np.float64)
        return per_area * area


@dataclass(frozen=True)
class Filled:
    """What a load is filled with.

    Attributes
    ----------
    patch
        Index of its patch in the basis.
    carrier
        Index in the solver of what carries it: the patch, or one element of it.
    source
        Name of its damper, or of the law or table that holds for all patches: loads of the same
        source share their damping, and its errors.
    reading
        Its damping.
    fill_fraction
        Fill at which that is read.
    source_force
        Whose force that is not linear in the motion acts on the panel; None for none.
    """

    patch: int
    carrier: int
    source: str
    reading: DampingReading
    fill_fraction: float
    source_force: CoupledDamping | None = None

    @property
    def mass_per_area(self) -> float:
        """What it weighs [kg/m²]; NaN where that is not known."""
        return self.reading.mass_per_area(self.fill_fraction)

    def largest_mass(self, frequency: Array) -> float:
        """Return the largest of its weight and its apparent mass over frequency [kg/m²]."""
        motions = MOTIONS_G if self.reading.depends_on_acceleration else MOTIONS_G[:1]
        moved = [
            self.reading(frequency, self.fill_fraction, gamma).apparent_mass.max()
            for gamma in motions
        ]
        return float(np.nanmax([self.mass_per_area, *moved]))

    @property
    def load_damping(self) -> DampingOfMotion:
        """Its damping as a function of frequency [Hz] and Γ."""
        return damping_of_motion(self.reading, self.fill_fraction)


@dataclass(frozen=True)
class PatchElements:
    """The elements of all patches; one that lies in two patches counts for each.

    Attributes
    ----------
    parts
        D and area of each.
    patch
        (n_elements,) index of its patch.
    """

    parts: Patches
    patch: Index


def patch_elements(basis: PanelBasis, plate: StoredPlate, vectors: Array) -> PatchElements:
    """Return the elements of the patches in a basis of the shapes ``vectors`` (n_free, n)."""
    points = len(plate.quadrature_weight) // len(basis.cells)  # of an element, element by element
    patch, cell = np.nonzero(basis.cell_in_patch)
    index = (cell[:, None] * points + np.arange(points)).ravel()
    weight = plate.quadrature_weight[index]
    at_points = plate.at_quadrature[index]
    used = np.unique(at_points.indices)  # a patch is a small part of the panel
    seen = at_points[:, used] @ vectors[used].astype(np.float64)
    rows = np.sqrt(weight)[:, None] * np.asarray(seen)
    area = weight.reshape(-1, points).sum(axis=1)
    return PatchElements(
        Patches.of_rows(rows, np.repeat(np.arange(len(cell)), points), area), patch
    )


@dataclass(frozen=True)
class Asked:
    """What is to be solved.

    Attributes
    ----------
    rows
        Of every answer its scenario, reading, S_p over that of the study, and the fillings.
    keys
        Of every answer the keys of its own layout, of the bare panel and of the dead weight.
    layouts
        By key; equal ones are there once.
    """

    rows: Sequence[tuple[Scenario, str, float, tuple[Filled, ...]]]
    keys: Sequence[tuple[Hashable, Hashable, Hashable]]
    layouts: Mapping[Hashable, Layout]

    def response_alone(self) -> Asked:
        """Return the same for those who ask neither how the patches move nor for errors."""
        bare = {
            key: replace(one, with_motion=False, with_slope=False)
            for key, one in self.layouts.items()
        }
        return replace(self, layouts=bare)


class Readings:
    """The readings of a study: how every patch of a scenario is read in each.

    Parameters
    ----------
    of_all
        Readings that hold for every patch, by name.
    of_dampers
        What the reading ``stated`` takes for each damper, by the name of the damper.
    names
        Names of all readings of the study in order.
    coupled
        Found by coupled runs, by scenario and patch, for the reading ``coupled``; patches without
        are read as ``stated`` there.
    """

    def __init__(
        self,
        names: Sequence[str],
        of_all: Mapping[str, DampingReading],
        of_dampers: Mapping[str, DampingReading],
        coupled: Mapping[tuple[str, str], CoupledDamping] | None = None,
    ) -> None:
        self.names = tuple(names)
        self._coupled = coupled or {}
        self._of_all = of_all
        self._of_dampers = of_dampers

    def of(self, name: str, scenario: str, filling: Filling, patch: int, carrier: int) -> Filled:
        """Return how a filled patch of a scenario, or an element of it, is read."""
        # constants have no fill, and are asked at that of a full cell
        fill = 1.0 if filling.fill_fraction is None else filling.fill_fraction
        if name == COUPLED:
            found = self._coupled.get((scenario, filling.patch))
            if found is not None:
                # each patch has its own motion, and its own errors
                source = f"{filling.damper} on {filling.patch}"
                return Filled(patch, carrier, source, found, fill, found)
            name = "stated"
        if name == "stated":
            damper = str(filling.damper)
            return Filled(patch, carrier, damper, self._of_dampers[damper], fill)
        source = SECTION if name == "dem" else name
        return Filled(patch, carrier, source, self._of_all[name], fill)


def readings_of(study: Study, folder: Path | None, coupled: Path | None = None) -> Readings:
    """Return the readings of a study.

    Parameters
    ----------
    study
        The study.
    folder
        Of the surfaces, ``results/<study>/damping``; None for a study without any.
    coupled
        ``coupled/impedance.csv``; None for a study without coupled runs.

    Raises
    ------
    DampingError
        As `reading_of` and `reading_of_damper`.
    """
    together = {} if coupled is None else read_coupled(coupled)

    def surface(damper: str) -> Path | None:
        if folder is None or damper not in study.surfaces:
            return None
        return of_damper(folder, damper, "surface.nc")

    of_all: dict[str, DampingReading] = {
        name: reading_of(name, study, surface(SECTION))
        for name in study.damping.readings or ("dem",)
        if name in study.readings and name not in ("stated", COUPLED)
    }
    stated = {
        name: reading_of_damper(study.all_dampers[name], surface(name))
        for name in study.stated_dampers
    }
    if not study.response.damper_mass:
        stated = {name: reading.without_mass() for name, reading in stated.items()}
        together = {key: reading.without_mass() for key, reading in together.items()}
    return Readings(study.readings, of_all, stated, together)


def damping_of_motion(reading: DampingReading, fill_fraction: float) -> DampingOfMotion:
    """Return a reading at one fill as a function of frequency [Hz] and Γ."""

    def damping(frequency: Array, gamma: float) -> tuple[Array, Array, Flags]:
        values = reading(frequency, fill_fraction, gamma)
        return values.equivalent_damping, values.apparent_mass, values.inside

    return damping


@dataclass(frozen=True)
class ForceOfTable:
    """G of the sound over frequency; see `modal.FactoredForce`.

    Attributes
    ----------
    table
        Over wavenumber.
    speed
        Of sound [m/s].
    """

    table: WavenumberTable
    speed: float

    def __call__(self, frequency: Array) -> Array | Complexes:
        """Return G (nf, n, n) [m⁴] at the frequencies (nf,) [Hz]."""
        return self.table.at(wavenumber(frequency, self.speed))

    def factors(self, frequency: Array) -> Array | Complexes | None:
        """Return L (nf, n, r) [m²] with G = L Lᴴ; None where r is not small."""
        return self.table.factors_at(wavenumber(frequency, self.speed))


@dataclass(frozen=True)
class PanelInSound:
    """What the responses of a study are computed from.

    Attributes
    ----------
    study
        Scenarios, levels, damping ratio, loss of the air.
    basis
        Modes and residual vectors of the panel.
    spectrum
        Of the sound, at the level of the study.
    force_table
        G of the field over wavenumber.
    air
        The air that the panel moves; None where it is left out.
    elements
        Elements of the patches; None where they are not looked at.
    least_damping_ratio
        Of the resonances that the lines must resolve; None for that of the bare panel.
    """

    study: Study
    basis: PanelBasis
    spectrum: BandSpectrum
    force_table: WavenumberTable
    air: Air | None
    elements: PatchElements | None = None
    least_damping_ratio: float | None = None

    # ------------------------------------------------------------------ arrays

    @cached_property
    def modal(self) -> ModalBasis:
        """The shapes with the damping ratio of the bare panel."""
        basis = self.basis
        ratio = damping_ratios(basis, self.study.panel.damping_ratio, self.cutoff)
        return ModalBasis(basis.natural_frequency, basis.modal_mass, ratio)

    @property
    def cutoff(self) -> float:
        """f_c [Hz]: above it the damping of the bare panel is proportional to its stiffness."""
        return cutoff_frequency(self.study.response.frequency_hz[1])

    @cached_property
    def frequency(self) -> Array:
        """(nf,) lines of the result [Hz]."""
        modes = self.basis.natural_frequency[~self.basis.is_residual]
        edges = self.spectrum.edge_frequency
        return frequency_grid(*self.study.response.frequency_hz, self.resolved_ratio, modes, edges)

    @property
    def resolved_ratio(self) -> float:
        """ζ that the lines resolve."""
        return self.least_damping_ratio or self.study.panel.damping_ratio

    def resolving(self, readings: Readings) -> PanelInSound:
        """Return the panel with lines for the resonances that the masses of its dampers make.

        A mass that is light beside the panel leaves the lines as they are: of their eight to a
        bandwidth `ENOUGH_LINES` do.
        """
        extent = self.study.response.frequency_hz
        mass, lines = np.zeros(len(self.patch_area)), np.geomspace(*extent, MASS_LINES)
        found = {
            (one.patch, one.source, one.fill_fraction): one
            for *_, fillings in self.asked(readings, dead_weight=False).rows
            for one in fillings
        }
        for one in found.values():
            mass[one.patch] = max(mass[one.patch], one.largest_mass(lines))
        least = least_damping_ratio(self.modal, self.basis.patch_overlap, mass, extent)
        ratio = max(
            min(self.study.panel.damping_ratio, least * LINES_PER_BANDWIDTH / ENOUGH_LINES),
            smallest_damping_ratio(*extent),
        )
        return replace(self, least_damping_ratio=min(ratio, self.study.panel.damping_ratio))

    @cached_property
    def coarse_frequency(self) -> Array:
        """(nf,) fewer lines, for rms values within 1e-3 [Hz]."""
        return frequency_grid(
            *self.study.response.frequency_hz,
            self.resolved_ratio,
            lines_per_bandwidth=COARSE_LINES_PER_BANDWIDTH,
        )

    @cached_property
    def patch_area(self) -> Array:
        """(n_patches,) [m²]."""
        return patch_areas(self.basis)

    @cached_property
    def deflection_at_points(self) -> Array:
        """(n_points, 1, n): w alone, exactly none at a point that is held."""
        return np.where(self.held[:, None], 0.0, self.basis.shape_at_points)[:, None]

    @cached_property
    def motion_at_points(self) -> Array:
        """(n_points, 6, n): w, curvatures, shear angles."""
        basis = self.basis
        return np.concatenate(
            [self.deflection_at_points, basis.curvature_at_points, basis.shear_at_points], axis=1
        )

    @cached_property
    def force(self) -> ForceOfTable:
        """G over frequency."""
        return ForceOfTable(self.force_table, self.study.sound.speed_m_s)

    def psd(self, frequency: Array) -> Array:
        """Return S_p (nf,) [Pa²/Hz] on the panel at the frequencies (nf,) [Hz]."""
        sound = self.study.sound
        return pressure_psd(self.spectrum, frequency, sound.pressure_reference, sound.loaded_sides)

    @property
    def air_stiffness(self) -> Air | None:
        """iωR − ω²M_air over frequency; None where the air is left out."""
        return self.air

    @cached_property
    def patches(self) -> Patches:
        """All patches of the panel."""
        return Patches(self.basis.patch_overlap, self.patch_area)

    @cached_property
    def held(self) -> Flags:
        """(n_points,) points that no shape moves, such as those on a support."""
        at_points = np.abs(self.basis.shape_at_points)
        largest = np.abs(self.basis.shape_at_vertices).max(axis=0)
        moves = at_points > HELD * np.where(largest > 0, largest, 1.0)
        return np.asarray(~moves.any(axis=1))

    @cached_property
    def carriers(self) -> Index:
        """(n_carriers,) index of the patch of each carrier in the solver: patches, or elements."""
        if self.by_element and self.elements is not None:
            return self.elements.patch
        return np.arange(len(self.patch_area))

    @cached_property
    def field(self) -> PanelInField:
        """The panel in its sound, with its patches or their elements."""
        panel = (self.psd, self.force, self.air_stiffness)
        elements = self.elements
        if elements is None or not len(elements.patch):
            return PanelInField(self.modal, self.patches, *panel)
        if self.by_element:
            return PanelInField(self.modal, elements.parts, *panel)
        return PanelInField(self.modal, self.patches, *panel, elements.parts, elements.patch)

    @property
    def by_element(self) -> bool:
        """Whether each element of a patch is a load of its own."""
        return self.study.damping.level.by == "element" and self.elements is not None

    def load_area(self, one: ScenarioResponse) -> Array:
        """Return the areas (n_loads,) of the loads of a response [m²]."""
        return self.field.patches.area[one.loads]

    def bare_motion_g(self, bare: ScenarioResponse, patch: int) -> float:
        """Return Γ of a patch of the bare panel."""
        own = self.carriers == patch
        share = self.field.patches.area[own] / self.field.patches.area[own].sum()
        return float(np.sqrt(share @ bare.bare_patch_acceleration_g[own] ** 2))

    def pressure_factor(self, scenario: Scenario) -> float:
        """Return S_p of a scenario over that of the study."""
        if scenario.oaspl_db is None:
            return 1.0
        return self.spectrum.pressure_factor(scenario.oaspl_db)

    # --------------------------------------------------------------- solutions

    def solver(self, *, rms_only: bool = False) -> Solver:
        """Return a solver of the form that the study asks for.

        Parameters
        ----------
        rms_only
            Few lines and no strains, enough for rms accelerations within 1e-3.
        """
        if self.study.response.modal_damping == "full":
            return self.full_solver(rms_only=rms_only)
        return DiagonalSolver(*self._panel(rms_only=rms_only))

    def full_solver(self, *, rms_only: bool = False) -> PanelSolver:
        """Return a solver with the full modal damping matrix; see `solver`."""
        return PanelSolver(*self._panel(rms_only=rms_only))

    def _panel(self, *, rms_only: bool) -> tuple[PanelInField, Array, Array, Array]:
        lines = self.coarse_frequency if rms_only else self.frequency
        motion = self.deflection_at_points if rms_only else self.motion_at_points
        return self.field, lines, motion, self.coarse_frequency

    def responses(
        self,
        solver: Solver,
        readings: Readings,
        *,
        dead_weight: bool = True,
        only: Collection[str] | None = None,
    ) -> list[SolvedScenario]:
        """Return every scenario in every reading of the damping.

        Parameters
        ----------
        solver
            From `solver`.
        readings, dead_weight, only
            As of `asked`.
        """
        return self.solved(solver, self.asked(readings, dead_weight=dead_weight, only=only))

    def asked(
        self, readings: Readings, *, dead_weight: bool = True, only: Collection[str] | None = None
    ) -> Asked:
        """Return what is to be solved for every scenario in every reading.

        Parameters
        ----------
        readings
            Of the study.
        dead_weight
            Whether the same masses without damping are wanted too, once for each distinct set of
            patches, masses and level.
        only
            Labels of the scenarios that are wanted; None for all.
        """
        rows = [
            (scenario, name, self.pressure_factor(scenario), self._filled(scenario, readings, name))
            for scenario in self.study.all_scenarios()
            if only is None or scenario.label in only
            for name in readings.names
        ]
        # the bare panel once a level, dead weight once for each set of masses and level
        keys: list[tuple[Hashable, Hashable, Hashable]] = []
        layouts: dict[Hashable, Layout] = {}
        for scenario, name, factor, filled in rows:
            bare: Hashable = factor
            own, dead = bare, None
            layouts.setdefault(bare, Layout((), factor))
            if filled:
                own = (scenario.label, name)
                layouts[own] = self._layout(filled, factor)
                masses = _masses(filled) if dead_weight else None
                if masses is not None:
                    dead = (masses, factor)
                    layouts.setdefault(dead, _of_mass(masses, factor))
            keys.append((own, bare, dead))
        return Asked(rows, keys, layouts)

    def solved(self, solver: Solver, asked: Asked) -> list[SolvedScenario]:
        """Return the responses that are asked for."""
        layouts = asked.layouts
        plain = {key: one for key, one in layouts.items() if one.source is None}
        found = dict(zip(plain, solve_layouts(solver, list(plain.values())), strict=True))
        for key, one in layouts.items():
            if one.source is not None:
                (found[key],) = solve_layouts(self.with_source(solver, one), [one])
        return [
            SolvedScenario(
                scenario=scenario,
                reading=name,
                found=found[own],
                bare=_steady(found[bare]),
                pressure_factor=factor,
                solver=solver,
                layout=layouts[own],
                filled=filled,
                dead_weight=None if dead is None else _steady(found[dead]),
            )
            for (scenario, name, factor, filled), (own, bare, dead) in zip(
                asked.rows, asked.keys, strict=True
            )
        ]

    def with_source(self, solver: Solver, layout: Layout) -> Solver:
        """Return a solver of the panel in its sound and under the source of a layout."""
        if layout.source is None:
            return solver
        force = self.force_with(layout.source, layout.pressure_factor)
        return solver.in_field(replace(solver.panel, modal_force=force))

    def force_with(
        self, source: Callable[[Array], Array], factor: float
    ) -> Callable[[Array], Array | Complexes]:
        """Return G with which S_p times it holds the PSD of a source too.

        Parameters
        ----------
        source
            PSD of its modal forces over frequency [N²/Hz].
        factor
            S_p over that of the study, by which the answer will be multiplied.
        """

        def force(frequency: Array) -> Array | Complexes:
            # the solver multiplies by the pressure, and the answer by the factor
            sound = factor * self.psd(frequency)
            share = np.divide(1.0, sound, out=np.zeros_like(sound), where=sound > 0)
            return self.force(frequency) + share[:, None, None] * source(frequency)

        return force

    def _source(self, filled: Sequence[Filled]) -> Callable[[Array], Array] | None:
        """Return the PSD of the modal forces of the particles; None where they have none."""
        sources = {one.patch: one.source_force for one in filled if one.source_force is not None}
        return self.own_forces(sources) if sources else None

    def own_forces(self, sources: Mapping[int, CoupledDamping]) -> Callable[[Array], Array]:
        """Return the PSD of the modal forces of particles over frequency [N²/Hz].

        Parameters
        ----------
        sources
            By patch.
        """
        basis = self.basis
        nodes = np.geomspace(*self.study.response.frequency_hz, OWN_FORCE_NODES)
        area = cell_areas(basis.vertex_position, basis.cells)
        total = np.zeros((len(nodes), *basis.patch_overlap.shape[1:]))
        for patch, source in sources.items():
            parts = elements_of_patch(
                basis.shape_at_vertices,
                basis.vertex_position,
                basis.cells,
                area,
                basis.cell_in_patch[patch],
            )
            independent = source.cell_area * basis.patch_overlap[patch]
            for k, (f, psd, c) in enumerate(zip(nodes, *source.own_force(nodes), strict=True)):
                coherent = parts.coherent_load(source.own_length / f)
                total[k] += psd * (c * coherent + (1 - c) * independent)

        def psd_at(frequency: Array) -> Array:
            return between(frequency, nodes, total)(slice(None))

        return psd_at

    def _filled(self, scenario: Scenario, readings: Readings, name: str) -> tuple[Filled, ...]:
        found = []
        for filling in scenario.fillings:
            patch = self.basis.patch_names.index(filling.patch)
            carriers = np.flatnonzero(self.carriers == patch).tolist()
            found += [
                readings.of(name, scenario.label, filling, patch, carrier) for carrier in carriers
            ]
        return tuple(found)

    def _layout(self, filled: Sequence[Filled], factor: float) -> Layout:
        loads = tuple(
            Load(one.carrier, one.load_damping, one.reading.depends_on_acceleration)
            for one in filled
        )
        with_slope = any(one.reading.nodes is not None for one in filled)
        stated = self.study.damping.level.acceleration_g
        return Layout(loads, factor, stated, with_slope, source=self._source(filled))

    @cached_property
    def _at_balance(self) -> tuple[slice, Array | Complexes, Complexes | None]:
        """Lines on which the power balance is checked, G (n_lines, n, n) and the air on them."""
        shapes = self.modal.natural_frequency.size
        count = int(np.clip(BALANCE_WORK / shapes**3, *BALANCE_LINES))
        step = max(1, len(self.frequency) // count)
        lines = slice(step // 2, None, step)
        frequency, air = self.frequency[lines], self.air_stiffness
        return lines, self.force(frequency), None if air is None else air(frequency)

    def power_balance_error(self, one: ScenarioResponse, factor: float) -> float:
        """Return the largest error of the power balance of a scenario over some lines [1].

        Parameters
        ----------
        one
            The response.
        factor
            S_p over that of the study.
        """
        lines, force, air = self._at_balance
        balance = power_balance(
            self.frequency[lines],
            self.modal,
            self.field.patches.only(one.loads.tolist()),
            factor * self.psd(self.frequency[lines]),
            force,
            one.equivalent_damping[:, lines],
            one.apparent_mass[:, lines],
            air,
        )
        return float(balance.error.max())


def _steady(found: ScenarioResponse | UnstableDamping) -> ScenarioResponse:
    """Return a response without negative damping, which cannot be unstable."""
    if isinstance(found, UnstableDamping):
        raise found
    return found


def _masses(filled: Sequence[Filled]) -> tuple[tuple[int, float], ...] | None:
    """Return carrier and mass per area [kg/m²] of each load; None where one is not known."""
    found = tuple((one.carrier, one.mass_per_area) for one in filled)
    return found if found and np.isfinite([mass for _, mass in found]).all() else None


def _of_mass(masses: Sequence[tuple[int, float]], factor: float) -> Layout:
    """Return the layout of masses that do not damp."""

    def load(patch: int, mass: float) -> Load:
        def damping(frequency: Array, gamma: float) -> tuple[Array, Array, Flags]:
            none = np.zeros(frequency.shape)
            return none, none + mass, np.ones(frequency.shape, dtype=np.bool_)

        return Load(patch, damping, depends_on_acceleration=False)

    return Layout(tuple(load(*one) for one in masses), factor, with_motion=False)


def widened(panel: PanelInSound, plate: StoredPlate, left_out: Array) -> PanelInSound:
    """Return the panel with a basis that holds what another left out.

    The sound on the new shapes is computed here, since their choice rests on the response.

    Parameters
    ----------
    panel
        With the basis of the panel stage.
    plate
        Its elements.
    left_out
        (n_free, k) further shapes.
    """
    if not left_out.shape[1]:
        return replace(panel, elements=patch_elements(panel.basis, plate, plate.shapes))
    shapes = joined_shapes(panel.basis, plate, left_out)
    study, basis = panel.study, refined(panel.basis, plate, shapes)
    elements = patch_elements(basis, plate, shapes.vectors)
    force = modal_force_tables(study.sound, study.response.frequency_hz[1], basis)
    air = panel.air
    if air is not None:
        tables = air_tables(study.sound, basis, force, air_mass=study.response.air_mass)
        diffuse = tables.get(DIFFUSE, force[MODAL_FORCE])
        air = replace(air, diffuse=diffuse, added_volume=tables.get(ADDED_VOLUME))
    table = force[MODAL_FORCE]
    return replace(panel, basis=basis, force_table=table, air=air, elements=elements)


def read_panel_in_sound(study: Study, files: PanelFiles, radiation: Radiation) -> PanelInSound:
    """Read what the panel and sound stages left.

    Parameters
    ----------
    study
        The study.
    files
        Of the stages upstream.
    radiation
        Sides that radiate into the air and carry its mass.

    Raises
    ------
    ValueError
        Where the air's own file is not given though it counts.
    """
    panel = PanelInSound(
        study,
        read_basis(files.modes),
        spectrum_of(study.sound),
        read_table(files.modal_force, MODAL_FORCE),
        None,
    )
    return with_air(panel, files, radiation)


def with_air(panel: PanelInSound, files: PanelFiles, radiation: Radiation) -> PanelInSound:
    """Return a panel with other sides in the air.

    Parameters
    ----------
    panel
        In the sound. The air is read where it has none, for the basis of the panel stage.
    files, radiation
        As of `read_panel_in_sound`, whose errors it has.
    """
    if radiation == "none":
        return replace(panel, air=None)
    if panel.air is not None:
        return replace(panel, air=replace(panel.air, wetted_sides=WETTED_SIDES[radiation]))
    if files.air is None:
        raise ValueError(f"radiation = {radiation}: the file of the air is required")
    study, force = panel.study, panel.force_table
    air = Air(
        study.sound.air_density_kg_m3,
        study.sound.speed_m_s,
        WETTED_SIDES[radiation],
        force if study.sound.field == "diffuse" else read_table(files.air, DIFFUSE),
        read_table(files.air, ADDED_VOLUME) if study.response.air_mass else None,
    )
    return replace(panel, air=air)
