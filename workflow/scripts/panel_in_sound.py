"""The panel of a study under its sound, ready for any patch; shared by what needs a response."""

from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from pidpanel.damping.laws import PaperLaw
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.tables import read_surface
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.modes import patch_areas
from pidpanel.response.dampers import PatchMotion
from pidpanel.response.lines import frequency_grid
from pidpanel.response.modal import bare_panels
from pidpanel.response.model import ModalBasis, Patches, UnstableDamping
from pidpanel.response.power import power_balance
from pidpanel.response.radiation import Air
from pidpanel.response.scenarios import (
    DampingOfMotion,
    DiagonalSolver,
    ScenarioResponse,
    Solver,
    solve_bare,
    solve_scenario,
)
from pidpanel.sound.field import wavenumber
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE, read_table
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.table import read_spl_table
from pidpanel.study import Scenario

COARSE = {"overlap_cutoff": 1e-4}
COARSE_LINES_PER_BANDWIDTH = 3.0
"""The search for a level: rms of the patch within 1e-3."""

BALANCE_LINES = 12
"""Lines on which the power balance of each scenario is struck."""


WETTED_SIDES = {"one_side": 1, "two_sides": 2}


def spectrum_of(sound):
    """The band levels of a study, at its level."""
    spectrum = read_spl_table(sound.spectrum).shifted(sound.shift_db)
    return spectrum if sound.oaspl_db is None else spectrum.at_oaspl(sound.oaspl_db)


class Case(NamedTuple):
    """A scenario in a reading of the damping, and what came of it."""

    scenario: Scenario
    reading: str
    found: ScenarioResponse | UnstableDamping
    bare: ScenarioResponse
    """Under the same sound."""
    pressure_factor: float
    """S_p over that of the study."""
    solver: Solver | DiagonalSolver
    damping: DampingOfMotion | None


class PanelInSound:
    """What the response is computed from, of one study."""

    def __init__(self, study, modes, modal_force, air_file, radiation):
        self.study = study
        self.basis = read_basis(modes)
        self.table = read_table(modal_force, MODAL_FORCE)
        self.spectrum = spectrum_of(study.sound)
        self.air = None
        if radiation != "none":
            self.air = Air(
                study.sound.air_density_kg_m3,
                study.sound.speed_m_s,
                WETTED_SIDES[radiation],
                read_table(air_file, DIFFUSE),
                read_table(air_file, ADDED_VOLUME),
            ).stiffness
        self.modal = ModalBasis(
            self.basis.natural_frequency, self.basis.modal_mass, study.panel.damping_ratio
        )
        low, high = study.response.frequency_hz
        modes = self.basis.natural_frequency[~self.basis.is_residual]
        ratio = study.panel.damping_ratio
        self.frequency = frequency_grid(low, high, ratio, modes, self.spectrum.edge_frequency)
        self.coarse_frequency = frequency_grid(
            low, high, ratio, lines_per_bandwidth=COARSE_LINES_PER_BANDWIDTH
        )

    def force(self, frequency):
        return self.table.at(wavenumber(frequency, self.study.sound.speed_m_s))

    def psd(self, frequency):
        sound = self.study.sound
        return pressure_psd(self.spectrum, frequency, sound.pressure_reference, sound.loaded_sides)

    def patch(self, name):
        index = self.basis.patch_names.index(name)
        own = slice(index, index + 1)
        return Patches(self.basis.patch_overlap[own], self.patch_area[own])

    @cached_property
    def patch_area(self):
        """(n_patches,) [m²]."""
        return patch_areas(self.basis)

    @cached_property
    def motion_at_points(self):
        """(n_points, 6, n): w, curvatures, shear angles."""
        shape = self.basis.shape_at_points[:, None]
        return np.concatenate(
            [shape, self.basis.curvature_at_points, self.basis.shear_at_points], axis=1
        )

    def solvers(self, names):
        """A solver of each patch, the panel solved once for all."""
        if self.study.response.modal_damping == "full":
            return self.full_solvers(names)
        fine, coarse = self.frequency, self.coarse_frequency
        carriers = [self.patch(name) for name in names]
        sound = (self.psd(coarse), self.force)
        panel = (self.motion_at_points, self.psd(fine), self.force)
        return {
            name: DiagonalSolver(
                fine, self.modal, patch, *panel,
                PatchMotion.diagonal(coarse, self.modal, patch, *sound),
            )
            for name, patch in zip(names, carriers, strict=True)
        }  # fmt: skip

    def full_solvers(self, names):
        """Solvers with the full modal damping matrix."""
        carriers = [self.patch(name) for name in names]
        nothing = np.zeros((0, 1, self.modal.natural_frequency.size))
        fine, coarse = self.frequency, self.coarse_frequency
        few = bare_panels(
            coarse, self.modal, carriers, nothing, self.psd(coarse), self.force, self.air, **COARSE
        )
        bare = bare_panels(
            fine, self.modal, carriers, self.motion_at_points, self.psd(fine), self.force, self.air
        )
        return {
            name: Solver(one, PatchMotion.of(coarse_one))
            for name, one, coarse_one in zip(names, bare, few, strict=True)
        }

    def responses(self, solvers, laws):
        """Every scenario in every reading of the damping; an error where it feeds the panel.

        Yields a `Case` of each.
        """
        bare = {}
        stated = self.study.damping.level.acceleration_g
        for scenario in self.study.all_scenarios():
            solver = solvers[scenario.patch or next(iter(solvers))]
            factor = 1.0
            if scenario.oaspl_db is not None:
                factor = self.spectrum.pressure_factor(scenario.oaspl_db)
            if scenario.patch is None:
                bare[factor] = solve_bare(solver, factor)
            for reading, law in laws.items():
                if scenario.patch is None:
                    yield Case(scenario, reading, bare[factor], bare[factor], factor, solver, None)
                    continue

                def damping(lines, gamma, law=law, fill=scenario.fill_fraction):
                    values = law(lines, fill, gamma)
                    return values.equivalent_damping, values.apparent_mass, values.inside

                try:
                    one = solve_scenario(
                        solver,
                        damping,
                        factor,
                        depends_on_acceleration=law.depends_on_acceleration,
                        stated_acceleration_g=stated,
                        damper_mass=self.study.response.damper_mass,
                    )
                except UnstableDamping as error:
                    one = error
                yield Case(scenario, reading, one, bare[factor], factor, solver, damping)

    def balance(self, case):
        """Largest error of the power balance of a scenario."""
        patch, found = case.scenario.patch or self.basis.patch_names[0], case.found
        step = max(1, len(self.frequency) // BALANCE_LINES)
        lines = slice(step // 2, None, step)
        balance = power_balance(
            self.frequency[lines],
            self.modal,
            self.patch(patch),
            case.pressure_factor * self.psd(self.frequency[lines]),
            self.force,
            found.equivalent_damping[None, lines],
            found.apparent_mass[None, lines],
            self.air,
        )
        return float(balance.error.max())


def damping_of(reading, study, surface):
    """The answer of a reading to: C_e and m_a at these frequencies, this fill, this Γ."""
    if reading == "dem":
        with xr.open_dataset(surface, engine="scipy") as dataset:
            return DampingSurface.from_dataset(dataset.load())
    if reading == "table":
        return read_surface(study.damping.table)
    return PaperLaw(printed=reading == "paper_printed")
