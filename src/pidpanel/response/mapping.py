"""Rms values over the whole panel for some scenarios."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.damping.coupled import COUPLED, CoupledDamping
from pidpanel.provenance.job import Files
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.map_files import CORE_STRESSES, map_dataset, write_paraview
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.psd_files import is_steady
from pidpanel.solve import stress
from pidpanel.solve.excitation import Excitation, Superposition
from pidpanel.solve.maps import layer_maps, modal_covariances, rms_map


def write_rms_maps(
    panel: ResponsePanel,
    scenarios: Sequence[ResponseScenario],
    models: Sequence[str],
    psd: xr.Dataset,
    beds: Mapping[tuple[str, str], CoupledDamping],
    attributes: Mapping[str, str],
    output: Files,
) -> None:
    """Write rms values over the whole panel."""
    basis = panel.basis
    layers = stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
    by_patches: dict[tuple[tuple[str, ...], str], list[tuple[str, ResponseScenario]]] = {}
    for scenario in scenarios:
        for model in models[: 1 if scenario.is_bare else None]:
            if is_steady(psd, model, scenario.label):
                # the own force of the particles is that of one scenario
                label = scenario.label if model == COUPLED and not scenario.is_bare else ""
                by_patches.setdefault((scenario.patches, label), []).append((model, scenario))
    maps: dict[tuple[str, str], dict[str, Array]] = {}
    for (names, label), cases in by_patches.items():
        sources = {
            basis.patch_names.index(patch): bed
            for (scenario_label, patch), bed in beds.items()
            if scenario_label == label
        }
        excitation: Excitation = panel.excitation
        if sources:
            share = 1 / cases[0][1].factor
            excitation = Superposition(excitation, panel.particle_force(sources), share)
        lines, dampers = panel.coarse_frequency, [_dampers(panel, psd, *case) for case in cases]
        patches = panel.patches.subset([basis.patch_names.index(name) for name in names])
        spectrum = excitation.spectrum(lines)
        covariances = modal_covariances(
            lines, panel.modal, patches, spectrum, excitation, dampers, panel.air
        )
        for (model, scenario), covariance in zip(cases, covariances, strict=True):
            maps[model, scenario.label] = {
                "acceleration": rms_map(covariance.acceleration, basis.shape_at_vertices),
                "displacement": rms_map(covariance.displacement, basis.shape_at_vertices),
                **layer_maps(covariance.displacement, basis.curvature_at_vertices, layers),
            }
            if np.any(basis.core_stress):
                shear = np.swapaxes(basis.core_stress @ basis.shear_at_vertices, 0, 1)
                maps[model, scenario.label] |= {
                    name: rms_map(covariance.displacement, motion)
                    for name, motion in zip(CORE_STRESSES, shear, strict=True)
                }
    errors = [_error_of_points(psd, *key) for key in maps]
    dataset = map_dataset(maps, errors, basis.vertex_position, basis.cells, layers.names)
    dataset.assign_attrs(attributes).to_netcdf(output.maps, engine="scipy")
    write_paraview(output.folder, dataset)


def _error_of_points(psd: xr.Dataset, reading: str, label: str) -> float:
    """Return the largest relative error of g rms of the points, all lines erring together."""
    case = psd.sel(reading=reading, scenario=label)
    if "acceleration_psd_log_error" not in psd:
        return np.nan
    values = case["acceleration_psd"].to_numpy()
    log_error = case["acceleration_psd_log_error"].to_numpy()
    lines = case["frequency"].to_numpy()
    whole = np.trapezoid(values, lines, axis=0)
    moving = whole > 0
    error = np.trapezoid(values * log_error, lines, axis=0)[moving] / (2 * whole[moving])
    return float(error.max()) if error.size else np.nan


def _dampers(
    panel: ResponsePanel, psd: xr.Dataset, reading: str, scenario: ResponseScenario
) -> tuple[Array, Array, float]:
    """Return C_e and m_a (n_loads, nf) on the lines of maps, and the factor of the excitation."""
    lines, coarse = psd["frequency"].to_numpy(), panel.coarse_frequency
    if scenario.is_bare:
        none = np.zeros((0, coarse.size))
        return none, none, scenario.factor
    case = psd.sel(reading=reading, scenario=scenario.label, patch=list(scenario.patches))

    def values(name: str) -> Array:
        by_patch = case[name].transpose("patch", "frequency").to_numpy()
        rows = [np.interp(coarse, lines, row) for row in by_patch]
        return np.array(rows).reshape(-1, coarse.size)

    return values("equivalent_damping"), values("apparent_mass"), scenario.factor
