"""Every scenario in every reading of the damping: psd.nc, summary.csv, stress.nc, stress.csv."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scripts.panel_in_sound import PanelInSound, damping_of

from pidpanel.damping.surface import DampingSurface
from pidpanel.response import scenarios, stress, uncertainty
from pidpanel.response.model import UnstableDamping
from pidpanel.response.tables import (
    psd_dataset,
    stress_dataset,
    stress_rows,
    summary_rows,
)
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, modes, modal_force, surface, *outputs = sys.argv[1:]
    psd_nc, summary_csv, stress_nc, stress_csv = outputs
    study = load_study(study_path)
    panel = PanelInSound(study, Path(modes), Path(modal_force))
    basis = panel.basis
    laws = {reading: damping_of(reading, study, surface) for reading in study.damping.readings}
    layers = stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
    level = study.damping.level
    wanted = study.all_scenarios()
    used = dict.fromkeys(s.patch for s in wanted if s.patch is not None)
    solvers = panel.solvers(list(used))
    found, bare, rows, strained, strain_rows = {}, {}, [], {}, []
    errors = {}
    for scenario in wanted:
        patch = scenario.patch or next(iter(used))
        own = panel.spectrum.oaspl
        oaspl = own if scenario.oaspl_db is None else scenario.oaspl_db
        factor = panel.spectrum.pressure_factor(oaspl)
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
                    if isinstance(law, DampingSurface):
                        errors[reading, scenario.label] = uncertainty.sensitivity(
                            solvers[patch],
                            damping,
                            one,
                            law.nodes,
                            own_level=law.depends_on_level and level.acceleration_g is None,
                            damper_mass=study.response.damper_mass,
                        ).under(
                            law.covariance(law.nodes, scenario.fill_fraction, one.acceleration_g)
                        )
            except UnstableDamping as error:
                print(f"{reading}, {scenario.label}: {error}", file=sys.stderr)
                rows += [{**row, "point": p, "status": "unstable"} for p in basis.point_names]
                continue
            if level.outside == "refuse" and not one.inside.all():
                worst = panel.frequency[~one.inside]
                sys.exit(
                    f"{reading}, {scenario.label}: C_e is asked for at {one.acceleration_g:.3g} g, "
                    f"{worst.min():.4g} to {worst.max():.4g} Hz, outside the run points; widen "
                    "coupon.sweep or set damping.level.outside: mark"
                )
            found[reading, scenario.label] = one
            rows += [
                {**row, "status": "ok", **values}
                for values in uncertainty.error_columns(
                    summary_rows(
                        one,
                        bare[oaspl],
                        basis.point_names,
                        thickness=study.panel.section.thickness,
                        power_balance_error=float(panel.balance(patch, factor, one)),
                    ),
                    errors.get((reading, scenario.label)),
                )
            ]
            psd = stress.layer_psd(one.response, layers)
            strained[reading, scenario.label] = psd
            of = {"reading": reading, "scenario": scenario.label}
            for number, layer in enumerate(layers.names):
                strain_rows += [
                    {**of, "layer": layer, **values}
                    for values in stress_rows(
                        panel.frequency, psd[:, :, number], stress.QUANTITIES, basis.point_names
                    )
                ]
            if np.any(basis.core_stress):
                strain_rows += [
                    {**of, "layer": "core", **values}
                    for values in stress_rows(
                        panel.frequency,
                        stress.core_psd(one.response, basis.core_stress),
                        stress.CORE_QUANTITIES,
                        basis.point_names,
                    )
                ]
    axes = (panel.frequency, list(laws), [s.label for s in wanted], basis.point_names)
    pd.DataFrame(rows).to_csv(summary_csv, index=False, float_format="%.6g")
    psds = uncertainty.with_errors(psd_dataset(found, *axes), errors)
    psds.assign_attrs(stamp(study), level=level.kind).to_netcdf(psd_nc, engine="scipy")
    pd.DataFrame(strain_rows).to_csv(stress_csv, index=False, float_format="%.6g")
    stress_dataset(strained, *axes, layers.names, stress.QUANTITIES).assign_attrs(
        stamp(study)
    ).to_netcdf(stress_nc, engine="scipy")
