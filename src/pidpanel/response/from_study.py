"""The panel of a study in its sound, ready for any damper.

The only door of the stage for the study; behind it are functions of arrays. `results` writes the
files of the stage, `rounds` the rounds of a target.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags
from pidpanel.damping.readings import DampingReading
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.modes import PanelBasis, patch_areas
from pidpanel.response.basis_error import cutoff_frequency, damping_ratios
from pidpanel.response.linearisation import DampingOfMotion
from pidpanel.response.lines import frequency_grid
from pidpanel.response.modal import MatrixInput
from pidpanel.response.model import ModalBasis, Patches, UnstableDamping
from pidpanel.response.power import power_balance
from pidpanel.response.radiation import Air
from pidpanel.response.scenarios import Layout, Load, ScenarioResponse, Solver, solve_layouts
from pidpanel.response.solvers import DiagonalSolver, PanelInField, PanelSolver
from pidpanel.sound.field import wavenumber
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE, read_table
from pidpanel.sound.from_study import spectrum_of
from pidpanel.sound.spectrum import BandSpectrum, pressure_psd
from pidpanel.sound.wavenumber_table import WavenumberTable
from pidpanel.study import Scenario, Study
from pidpanel.study.response import Radiation

COARSE_LINES_PER_BANDWIDTH = 3.0
"""Of the search for Γ: rms of the patch within 1e-3."""

BALANCE_LINES = 12
"""Lines on which the power balance of each scenario is checked."""

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
    solver, loads
        What it was computed with; no load for the bare panel.
    """

    scenario: Scenario
    reading: str
    found: ScenarioResponse | UnstableDamping
    bare: ScenarioResponse
    pressure_factor: float
    solver: Solver
    loads: tuple[Load, ...]


def damping_of_motion(reading: DampingReading, fill_fraction: float) -> DampingOfMotion:
    """Return a reading at one fill as a function of frequency [Hz] and Γ."""

    def damping(frequency: Array, gamma: float) -> tuple[Array, Array, Flags]:
        values = reading(frequency, fill_fraction, gamma)
        return values.equivalent_damping, values.apparent_mass, values.inside

    return damping


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
    """

    study: Study
    basis: PanelBasis
    spectrum: BandSpectrum
    force_table: WavenumberTable
    air: Air | None

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
        ratio = self.study.panel.damping_ratio
        return frequency_grid(
            *self.study.response.frequency_hz, ratio, modes, self.spectrum.edge_frequency
        )

    @cached_property
    def coarse_frequency(self) -> Array:
        """(nf,) fewer lines, for rms values within 1e-3 [Hz]."""
        return frequency_grid(
            *self.study.response.frequency_hz,
            self.study.panel.damping_ratio,
            lines_per_bandwidth=COARSE_LINES_PER_BANDWIDTH,
        )

    @cached_property
    def patch_area(self) -> Array:
        """(n_patches,) [m²]."""
        return patch_areas(self.basis)

    @cached_property
    def deflection_at_points(self) -> Array:
        """(n_points, 1, n): w alone."""
        return self.basis.shape_at_points[:, None]

    @cached_property
    def motion_at_points(self) -> Array:
        """(n_points, 6, n): w, curvatures, shear angles."""
        basis = self.basis
        return np.concatenate(
            [self.deflection_at_points, basis.curvature_at_points, basis.shear_at_points], axis=1
        )

    def force(self, frequency: Array) -> Array | Complexes:
        """Return G (nf, n, n) [m⁴] at the frequencies (nf,) [Hz]."""
        return self.force_table.at(wavenumber(frequency, self.study.sound.speed_m_s))

    def psd(self, frequency: Array) -> Array:
        """Return S_p (nf,) [Pa²/Hz] on the panel at the frequencies (nf,) [Hz]."""
        sound = self.study.sound
        return pressure_psd(self.spectrum, frequency, sound.pressure_reference, sound.loaded_sides)

    @property
    def air_stiffness(self) -> MatrixInput | None:
        """iωR − ω²M_air over frequency; None where the air is left out."""
        return None if self.air is None else self.air.stiffness

    def patch(self, name: str) -> Patches:
        """Return one patch by its name."""
        index = self.basis.patch_names.index(name)
        own = slice(index, index + 1)
        return Patches(self.basis.patch_overlap[own], self.patch_area[own])

    def pressure_factor(self, scenario: Scenario) -> float:
        """Return S_p of a scenario over that of the study."""
        if scenario.oaspl_db is None:
            return 1.0
        return self.spectrum.pressure_factor(scenario.oaspl_db)

    @property
    def loaded_patches(self) -> list[str]:
        """Names of the patches that a scenario fills."""
        scenarios = self.study.all_scenarios()
        return list(dict.fromkeys(s.patch for s in scenarios if s.patch is not None))

    # --------------------------------------------------------------- solutions

    def solver(self, *, rms_only: bool = False) -> Solver:
        """Return a solver of all loaded patches, of the form that the study asks for.

        Parameters
        ----------
        rms_only
            Few lines and no strains, enough for rms accelerations within 1e-3.
        """
        lines = self.coarse_frequency if rms_only else self.frequency
        motion = self.deflection_at_points if rms_only else self.motion_at_points
        if self.study.response.modal_damping == "full":
            return self.full_solver(lines, motion)
        return DiagonalSolver(self.in_field, lines, motion, self.coarse_frequency)

    def full_solver(self, frequency: Array, motion_at_points: Array) -> PanelSolver:
        """Return a solver with the full modal damping matrix.

        Parameters
        ----------
        frequency
            (nf,) lines of the result [Hz].
        motion_at_points
            (n_points, m, n) the motions looked at.
        """
        return PanelSolver(self.in_field, frequency, motion_at_points, self.coarse_frequency)

    @cached_property
    def in_field(self) -> PanelInField:
        """The panel with the patches that a scenario fills, in the order of `loaded_patches`."""
        index = [self.basis.patch_names.index(name) for name in self.loaded_patches]
        patches = Patches(self.basis.patch_overlap[index], self.patch_area[index])
        return PanelInField(self.modal, patches, self.psd, self.force, self.air_stiffness)

    def responses(
        self, solver: Solver, readings: Mapping[str, DampingReading]
    ) -> Iterator[SolvedScenario]:
        """Yield every scenario in every reading of the damping."""
        scenarios = self.study.all_scenarios()
        stated = self.study.damping.level.acceleration_g
        factors = list(dict.fromkeys(self.pressure_factor(one) for one in scenarios))
        layouts: dict[tuple[str, str | None, float], Layout] = {
            ("", None, factor): Layout((), factor) for factor in factors
        }
        for scenario in scenarios:
            for name, reading in readings.items():
                if scenario.patch is not None:
                    load = Load(
                        self.loaded_patches.index(scenario.patch),
                        damping_of_motion(reading, scenario.fill_fraction),
                        reading.depends_on_acceleration,
                    )
                    factor = self.pressure_factor(scenario)
                    layouts[name, scenario.label, factor] = Layout((load,), factor, stated)
        found = solve_layouts(solver, list(layouts.values()))
        solved = dict(zip(layouts, found, strict=True))
        for scenario in scenarios:
            factor = self.pressure_factor(scenario)
            bare = solved["", None, factor]
            assert isinstance(bare, ScenarioResponse)  # nothing can feed it
            for name in readings:
                key: tuple[str, str | None, float] = ("", None, factor)
                if scenario.patch is not None:
                    key = (name, scenario.label, factor)
                loads = tuple(layouts[key].loads)
                yield SolvedScenario(scenario, name, solved[key], bare, factor, solver, loads)

    def reads_own_motion(self, reading: DampingReading) -> bool:
        """Whether a reading is taken at the motion that the patch ends up with."""
        return reading.depends_on_acceleration and self.study.damping.level.acceleration_g is None

    def power_balance_error(self, patch: str | None, factor: float, one: ScenarioResponse) -> float:
        """Return the largest error of the power balance of a scenario over some lines [1].

        Parameters
        ----------
        patch
            That carries the damper; None for the bare panel.
        factor
            S_p over that of the study.
        one
            The response.
        """
        step = max(1, len(self.frequency) // BALANCE_LINES)
        lines = slice(step // 2, None, step)
        balance = power_balance(
            self.frequency[lines],
            self.modal,
            self.patch(patch or self.basis.patch_names[0]),
            factor * self.psd(self.frequency[lines]),
            self.force,
            one.equivalent_damping[:, lines] if patch else np.zeros((1, self.frequency[lines].size)),
            one.apparent_mass[:, lines] if patch else np.zeros((1, self.frequency[lines].size)),
            self.air_stiffness,
        )
        return float(balance.error.max())


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
    air = None
    if radiation != "none":
        if files.air is None:
            raise ValueError(f"radiation = {radiation}: the file of the air is required")
        air = Air(
            study.sound.air_density_kg_m3,
            study.sound.speed_m_s,
            WETTED_SIDES[radiation],
            read_table(files.air, DIFFUSE),
            read_table(files.air, ADDED_VOLUME),
        )
    return PanelInSound(
        study,
        read_basis(files.modes),
        spectrum_of(study.sound),
        read_table(files.modal_force, MODAL_FORCE),
        air,
    )
