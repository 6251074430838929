"""The panel of a study under its sound, ready for any patch; shared by what needs a response."""

from functools import cached_property

import numpy as np
import xarray as xr

from pidpanel.damping.laws import PaperLaw
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.tables import read_surface
from pidpanel.panel.basis_files import read_basis
from pidpanel.response.dampers import PatchMotion
from pidpanel.response.lines import frequency_grid
from pidpanel.response.modal import bare_panels
from pidpanel.response.model import ModalBasis, Patches
from pidpanel.response.power import power_balance
from pidpanel.response.scenarios import DiagonalSolver, Solver
from pidpanel.sound.field import wavenumber
from pidpanel.sound.field_files import read_modal_force
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.table import read_spl_table

COARSE = {"overlap_cutoff": 1e-4}
COARSE_LINES_PER_BANDWIDTH = 3.0
"""The search for a level: rms of the patch within 1e-3."""

BALANCE_LINES = 12
"""Lines on which the power balance of each scenario is struck."""


class PanelInSound:
    """What the response is computed from, of one study."""

    def __init__(self, study, modes, modal_force):
        self.study = study
        self.basis = read_basis(modes)
        self.table = read_modal_force(modal_force)
        self.spectrum = read_spl_table(study.sound.spectrum)
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
        return pressure_psd(self.spectrum, frequency, self.study.sound.pressure_reference)

    def patch(self, name):
        index = self.basis.patch_names.index(name)
        area = np.prod(self.study.panel.patches[name].size_m)
        return Patches(self.basis.patch_overlap[index : index + 1], np.array([area]))

    @cached_property
    def motion_at_points(self):
        """(n_points, 6, n): w, curvatures, shear angles."""
        shape = self.basis.shape_at_points[:, None]
        return np.concatenate(
            [shape, self.basis.curvature_at_points, self.basis.shear_at_points], axis=1
        )

    def solvers(self, names):
        """A solver of each patch, the panel solved once for all."""
        carriers = [self.patch(name) for name in names]
        nothing = np.zeros((0, 1, self.modal.natural_frequency.size))
        fine, coarse = self.frequency, self.coarse_frequency
        if self.study.response.modal_damping == "diagonal":
            sound = (self.psd(coarse), self.force)
            motions = [PatchMotion.diagonal(coarse, self.modal, p, *sound) for p in carriers]
            panel = (self.motion_at_points, self.psd(fine), self.force)
            return {
                name: DiagonalSolver(fine, self.modal, patch, *panel, motion)
                for name, patch, motion in zip(names, carriers, motions, strict=True)
            }
        few = bare_panels(
            coarse, self.modal, carriers, nothing, self.psd(coarse), self.force, **COARSE
        )
        bare = bare_panels(
            fine, self.modal, carriers, self.motion_at_points, self.psd(fine), self.force
        )
        return {
            name: Solver(one, PatchMotion.of(coarse_one))
            for name, one, coarse_one in zip(names, bare, few, strict=True)
        }

    def balance(self, patch, factor, found):
        """Largest error of the power balance of a scenario."""
        step = max(1, len(self.frequency) // BALANCE_LINES)
        lines = slice(step // 2, None, step)
        return power_balance(
            self.frequency[lines], self.modal, self.patch(patch),
            factor * self.psd(self.frequency[lines]), self.force,
            found.equivalent_damping[None, lines], found.apparent_mass[None, lines],
        ).error.max()  # fmt: skip


def damping_of(reading, study, surface):
    """The answer of a reading to: C_e and m_a at these frequencies, this fill, this Γ."""
    if reading == "dem":
        with xr.open_dataset(surface, engine="scipy") as dataset:
            return DampingSurface.from_dataset(dataset.load())
    if reading == "table":
        return read_surface(study.damping.table)
    return PaperLaw(printed=reading == "paper_printed")
