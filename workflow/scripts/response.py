"""Every scenario in every reading of the damping: response/psd.nc, response/summary.csv."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.damping.laws import PaperLaw
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.tables import read_surface
from pidpanel.panel.basis_files import read_basis
from pidpanel.response import scenarios
from pidpanel.response.lines import frequency_grid
from pidpanel.response.modal import bare_panel
from pidpanel.response.model import ModalBasis, Patches, UnstableDamping
from pidpanel.response.power import power_balance
from pidpanel.response.tables import psd_dataset, summary_rows
from pidpanel.sound.field import wavenumber
from pidpanel.sound.field_files import read_modal_force
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.table import read_spl_table
from pidpanel.stamp import stamp
from pidpanel.study import load_study

COARSE = {"overlap_cutoff": 1e-4}
COARSE_LINES_PER_BANDWIDTH = 3.0
"""The search for a level: rms of the patch within 1e-3."""

BALANCE_LINES = 40
"""Lines on which the power balance of each scenario is struck."""


class Inputs:
    """The study's panel under its sound, ready for any patch."""

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

    def solver(self, patch):
        def arguments(frequency):
            return (
                frequency, self.modal, self.patch(patch), self.basis.shape_at_points,
                self.psd(frequency), self.force,
            )  # fmt: skip

        if self.study.response.modal_damping == "diagonal":
            return scenarios.DiagonalSolver(*arguments(self.frequency))
        return scenarios.Solver(
            bare_panel(*arguments(self.frequency)),
            bare_panel(*arguments(self.coarse_frequency), **COARSE),
        )

    def balance(self, patch, factor, found):
        lines = slice(None, None, max(1, len(self.frequency) // BALANCE_LINES))
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


if __name__ == "__main__":
    study_path, modes, modal_force, surface, psd_nc, summary_csv = sys.argv[1:]
    study = load_study(study_path)
    inputs = Inputs(study, Path(modes), Path(modal_force))
    laws = {reading: damping_of(reading, study, surface) for reading in study.damping.readings}
    level = study.damping.level
    solvers = {}
    found, bare, rows = {}, {}, []
    for scenario in study.all_scenarios():
        patch = scenario.patch or inputs.basis.patch_names[0]
        if patch not in solvers:
            solvers[patch] = inputs.solver(patch)
        own = inputs.spectrum.oaspl
        oaspl = own if scenario.oaspl_db is None else scenario.oaspl_db
        factor = 10 ** ((oaspl - own) / 10)
        for reading, law in laws.items():
            row = {
                "reading": reading,
                "scenario": scenario.label,
                "patch": scenario.patch or "none",
                "fill_fraction": scenario.fill_fraction,
                "oaspl_db": oaspl,
            }
            try:
                if scenario.patch is None:
                    if oaspl not in bare:
                        bare[oaspl] = scenarios.solve_bare(solvers[patch], factor)
                    one = bare[oaspl]
                else:

                    def damping(lines, gamma, law=law, fill=scenario.fill_fraction):
                        values = law(lines, fill, gamma)
                        return values.equivalent_damping, values.apparent_mass, values.inside

                    one = scenarios.solve_scenario(
                        solvers[patch],
                        damping,
                        factor,
                        depends_on_level=law.depends_on_level,
                        stated_level=level.acceleration_g,
                        damper_mass=study.response.damper_mass,
                    )
            except UnstableDamping as error:
                print(f"{reading}, {scenario.label}: {error}", file=sys.stderr)
                rows += [
                    {**row, "point": p, "status": "unstable"} for p in inputs.basis.point_names
                ]
                continue
            if level.outside == "refuse" and not one.inside.all():
                worst = inputs.frequency[~one.inside]
                sys.exit(
                    f"{reading}, {scenario.label}: C_e is asked for at {one.acceleration_g:.3g} g, "
                    f"{worst.min():.4g} to {worst.max():.4g} Hz, outside the run points; widen "
                    "coupon.sweep or set damping.level.outside: mark"
                )
            found[reading, scenario.label] = one
            rows += [
                {**row, "status": "ok", **values}
                for values in summary_rows(
                    one,
                    bare[oaspl],
                    inputs.basis.point_names,
                    thickness=study.panel.section.thickness,
                    power_balance_error=float(inputs.balance(patch, factor, one)),
                )
            ]
    pd.DataFrame(rows).to_csv(summary_csv, index=False, float_format="%.6g")
    psd_dataset(
        found,
        inputs.frequency,
        list(laws),
        [s.label for s in study.all_scenarios()],
        inputs.basis.point_names,
    ).assign_attrs(stamp(study), level=level.kind).to_netcdf(psd_nc, engine="scipy")
