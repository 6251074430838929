"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

import sys
from pathlib import Path

import numpy as np
import xarray as xr
from scripts.panel_in_sound import PanelInSound

from pidpanel.response.map_files import map_dataset, write_paraview
from pidpanel.response.maps import layer_maps, modal_covariances, rms_map
from pidpanel.response.stress import distinct_layers
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, modes, modal_force, air, psd_nc, maps_nc, folder = sys.argv[1:]
    study = load_study(study_path)
    panel = PanelInSound(study, modes, modal_force, air, study.response.radiation)
    basis, lines = panel.basis, panel.coarse_frequency
    layers = distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
    with xr.open_dataset(psd_nc, engine="scipy") as dataset:
        psd = dataset.load()

    def damper(reading, scenario):
        """C_e and m_a of a scenario on the lines of the maps, and its S_p."""
        one = psd.sel(reading=reading, scenario=scenario.label)
        at = (lines, psd["frequency"].to_numpy())
        factor = 1.0
        if scenario.oaspl_db is not None:
            factor = panel.spectrum.pressure_factor(scenario.oaspl_db)
        return (
            np.interp(*at, one["equivalent_damping"].to_numpy())[None],
            np.interp(*at, one["apparent_mass"].to_numpy())[None],
            factor,
        )

    by_patch = {}
    for scenario in study.mapped_scenarios():
        readings = study.damping.readings if scenario.patch else study.damping.readings[:1]
        for reading in readings:
            one = psd["acceleration_psd"].sel(reading=reading, scenario=scenario.label)
            if not np.isnan(one).any():  # where the damping feeds the panel there is no response
                patch = scenario.patch or basis.patch_names[0]
                by_patch.setdefault(patch, []).append((reading, scenario))
    found = {}
    for patch, cases in by_patch.items():
        covariances = modal_covariances(
            lines,
            panel.modal,
            panel.patch(patch),
            panel.psd(lines),
            panel.force,
            [damper(*case) for case in cases],
            panel.air,
        )
        for (reading, scenario), one in zip(cases, covariances, strict=True):
            found[reading, scenario.label] = {
                "acceleration": rms_map(one.acceleration, basis.shape_at_vertices),
                "displacement": rms_map(one.displacement, basis.shape_at_vertices),
                **layer_maps(one.displacement, basis.curvature_at_vertices, layers),
            }
    dataset = map_dataset(found, basis.vertex_position, basis.cells, layers.names)
    dataset.assign_attrs(stamp(study)).to_netcdf(maps_nc, engine="scipy")
    write_paraview(Path(folder), dataset)
