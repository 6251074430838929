"""Modal damping of every scenario for Nastran: damping/tabdmp1.bdf."""

import sys
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.panel.basis_files import read_basis
from pidpanel.response.tabdmp1 import modal_damping_ratio, write_tabdmp1
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, modes, psd_nc, output = sys.argv[1:]
    study, basis = load_study(study_path), read_basis(modes)
    with xr.open_dataset(psd_nc, engine="scipy") as dataset:
        damping = dataset["equivalent_damping"].load()
    own = np.flatnonzero(
        ~basis.is_residual
        & (basis.natural_frequency >= float(damping["frequency"][0]))
        & (basis.natural_frequency <= float(damping["frequency"][-1]))
    )
    own = own[np.argsort(basis.natural_frequency[own])]
    frequency, mass = basis.natural_frequency[own], basis.modal_mass[own]
    ratios = {}
    for reading in study.damping.readings:
        for scenario in study.all_scenarios():
            of = damping.sel(reading=reading, scenario=scenario.label)
            if np.isnan(of).any():
                continue  # no steady response
            patch = basis.patch_names.index(scenario.patch) if scenario.patch else 0
            ratios[f"{reading}, {scenario.label}"] = modal_damping_ratio(
                study.panel.damping_ratio,
                frequency,
                mass,
                basis.patch_overlap[patch, own, own],
                np.interp(frequency, of["frequency"], of),
            )
    write_tabdmp1(Path(output), frequency, ratios, f"pidpanel study {study.name}")
