"""Every scenario in every reading of the damping: psd.nc, summary.csv, stress and radiation."""

import sys

import numpy as np
import pandas as pd
from scripts.panel_in_sound import PanelInSound, damping_of

from pidpanel.damping.surface import DampingSurface
from pidpanel.response import stress, uncertainty
from pidpanel.response.model import UnstableDamping
from pidpanel.response.tables import (
    beside_rows,
    psd_dataset,
    stress_dataset,
    stress_rows,
    summary_rows,
)
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, modes, modal_force, surface, air, *outputs = sys.argv[1:]
    psd_nc, summary_csv, stress_nc, stress_csv, *radiation_csv = outputs
    study = load_study(study_path)
    panel = PanelInSound(study, modes, modal_force, air, study.response.radiation)
    basis, points = panel.basis, panel.basis.point_names
    laws = {reading: damping_of(reading, study, surface) for reading in study.damping.readings}
    layers = stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
    level = study.damping.level
    patches = list(dict.fromkeys(s.patch for s in study.all_scenarios() if s.patch is not None))
    solvers = panel.solvers(patches)
    full = None
    if study.response.modal_damping == "diagonal":
        full = panel.full_solvers(patches)  # which says what the diagonal form costs
    found, errors, rows, strained, strain_rows = {}, {}, [], {}, []
    for case in panel.responses(solvers, laws):
        scenario, reading, one, law = case.scenario, case.reading, case.found, laws[case.reading]
        row = {
            "reading": reading,
            "scenario": scenario.label,
            "patch": scenario.patch or "none",
            "fill_fraction": scenario.fill_fraction,
            "oaspl_db": scenario.oaspl_db or panel.spectrum.oaspl,
        }
        if isinstance(one, UnstableDamping):
            print(f"{reading}, {scenario.label}: {one}", file=sys.stderr)
            rows += [{**row, "point": point, "status": "unstable"} for point in points]
            continue
        if level.outside == "refuse" and not one.inside.all():
            worst = panel.frequency[~one.inside]
            sys.exit(
                f"{reading}, {scenario.label}: C_e is asked for at {one.acceleration_g:.3g} g, "
                f"{worst.min():.4g} to {worst.max():.4g} Hz, outside the run points; widen "
                "coupon.sweep or set damping.level.outside: mark"
            )
        found[reading, scenario.label] = one
        if isinstance(law, DampingSurface) and scenario.patch is not None:
            own_acceleration = law.depends_on_acceleration and level.acceleration_g is None
            errors[reading, scenario.label] = uncertainty.sensitivity(
                case.solver,
                case.damping,
                one,
                law.nodes,
                case.pressure_factor,
                own_acceleration=own_acceleration,
                damper_mass=study.response.damper_mass,
            ).under(law.covariance(law.nodes, scenario.fill_fraction, one.acceleration_g))
        judge = one.response
        if full is not None and scenario.patch is not None:
            judge = full[scenario.patch].response(one.equivalent_damping, one.apparent_mass)
            judge = judge.under(case.pressure_factor)
        rows += [
            {**row, "status": "ok", **values}
            for values in uncertainty.error_columns(
                summary_rows(
                    one,
                    case.bare,
                    points,
                    thickness=study.panel.section.thickness,
                    power_balance_error=panel.balance(case),
                    full=judge,
                ),
                errors.get((reading, scenario.label)),
            )
        ]
        of = {"reading": reading, "scenario": scenario.label}
        psd = strained[reading, scenario.label] = stress.layer_psd(one.response, layers)
        parts = {
            layer: (psd[:, :, number], stress.QUANTITIES)
            for number, layer in enumerate(layers.names)
        }
        if np.any(basis.core_stress):
            core = stress.core_psd(one.response, basis.core_stress)
            parts["core"] = (core, stress.CORE_QUANTITIES)
        strain_rows += [
            {**of, "layer": layer, **values}
            for layer, (part, quantities) in parts.items()
            for values in stress_rows(panel.frequency, part, quantities, points)
        ]
    axes = (panel.frequency, list(laws), [s.label for s in study.all_scenarios()], points)
    pd.DataFrame(rows).to_csv(summary_csv, index=False, float_format="%.6g")
    psds = uncertainty.with_errors(psd_dataset(found, *axes), errors)
    psds.assign_attrs(stamp(study), level=level.kind).to_netcdf(psd_nc, engine="scipy")
    pd.DataFrame(strain_rows).to_csv(stress_csv, index=False, float_format="%.6g")
    stress_dataset(strained, *axes, layers.names, stress.QUANTITIES).assign_attrs(
        stamp(study)
    ).to_netcdf(stress_nc, engine="scipy")

    if radiation_csv:
        beside = PanelInSound(study, modes, modal_force, air, study.response.radiation_beside)
        rows = []
        for case in beside.responses(beside.solvers(patches), laws):
            if not isinstance(case.found, UnstableDamping):
                row = {"reading": case.reading, "scenario": case.scenario.label}
                rows += [{**row, **v} for v in beside_rows(case.found, case.bare, points)]
        frame = pd.DataFrame(rows)
        frame.insert(0, "radiation", study.response.radiation_beside)
        frame.to_csv(radiation_csv[0], index=False, float_format="%.6g")
