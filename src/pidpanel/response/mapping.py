"""Rms values over the whole panel for some scenarios: NetCDF, and VTU and one PVD for ParaView."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, Index, variable
from pidpanel.panel.files import write_vtu
from pidpanel.provenance.files import Files
from pidpanel.response.cases import ResponseScenario, own_force_of
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.psd_files import is_steady
from pidpanel.solve import stress
from pidpanel.solve.excitation import Excitation, Superposition
from pidpanel.solve.maps import layer_maps, modal_covariances, motion_weights, rms_map

# Unit of each map; strains and stresses have one for each layer.
UNITS = {"acceleration": "m s-2", "displacement": "m", **stress.QUANTITIES}


def map_dataset(
    maps: Mapping[str, Mapping[str, Array]],
    relative_error: Sequence[float],
    vertex_position: Array,
    cells: Index,
    layers: Sequence[str],
) -> xr.Dataset:
    """Return rms maps of some scenarios over the vertices of the mesh."""
    variables = {}
    for name in next(iter(maps.values())):
        unit = UNITS.get(name, "Pa")
        values = np.array([maps[name] for maps in maps.values()])
        dims = "case layer vertex" if values.ndim == 3 else "case vertex"
        variables[f"{name}_rms"] = variable(dims, values, unit, f"rms of {name}")
    errors = np.array(relative_error, dtype=np.float64)
    meaning = "largest standard error of the points' g rms"
    variables["relative_error"] = variable("case", errors, "1", meaning)
    position = variable("vertex axis", vertex_position, "m", "vertices of the mesh")
    variables["vertex_position"] = position
    variables["cells"] = variable("cell corner", cells, "1", "vertex numbers")
    dataset = xr.Dataset(variables, {"scenario": ("case", list(maps))})
    return dataset.assign_coords(layer=list(layers)) if layers else dataset


def write_paraview(folder: Path, dataset: xr.Dataset) -> None:
    """Write a VTU file for each case, and ``maps.pvd`` with all of them as steps."""
    folder.mkdir(exist_ok=True)
    position = dataset["vertex_position"].to_numpy()
    cells = dataset["cells"].to_numpy()
    entries = []
    for step in range(dataset.sizes["case"]):
        case = dataset.isel(case=step)
        data = {}
        for name in [str(name) for name in dataset.data_vars if str(name).endswith("_rms")]:
            values = case[name]
            unit = values.attrs["units"].replace(" ", "_")
            if "layer" not in values.dims:
                data[f"{name}_{unit}"] = values.to_numpy()
                continue
            for layer in case["layer"].to_numpy():
                key = f"{name}_{unit}_{layer}".replace(" ", "_")
                data[key] = values.sel(layer=layer).to_numpy()
        name = f"{case['scenario'].item()}.vtu"
        write_vtu(folder / name, position, cells, data)
        entries.append(f'<DataSet timestep="{step}" part="0" file={quoteattr(name)}/>')
    (folder / "maps.pvd").write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        + "\n".join(entries)
        + "\n</Collection>\n</VTKFile>\n",
        encoding="utf-8",
    )


def scenario_covariances(
    panel: ResponsePanel,
    scenarios: Sequence[ResponseScenario],
    psd: xr.Dataset,
    lines: Array,
    weights: Array,
) -> dict[str, Array]:
    """Return Σ (n_weights, n, n) of the scenarios that have a response, by label.

    ``weights`` (n_weights, nf) are those of lines (nf,) [Hz] in `modal_covariances`.
    """
    # the own force of the particles is that of one scenario
    groups: dict[tuple[tuple[str, ...], str], list[ResponseScenario]] = {}
    filled = [s.patches for s in scenarios if not (s.is_bare or s.is_coupled)]
    for scenario in scenarios:
        if is_steady(psd, scenario.label):
            label = scenario.label if scenario.is_coupled else ""
            # the bare panel goes with others: most of the work is the same for all of a group
            places = filled[0] if scenario.is_bare and filled else scenario.patches
            groups.setdefault((places, label), []).append(scenario)
    by_label: dict[str, Array] = {}
    for (names, _), cases in groups.items():
        excitation: Excitation = panel.excitation
        if (force := own_force_of(panel, cases[0])) is not None:
            excitation = Superposition(excitation, force, 1 / cases[0].factor)
        dampers = [_dampers(lines, psd, case, names) for case in cases]
        patches = panel.patches.subset([panel.basis.patch_names.index(name) for name in names])
        spectrum = excitation.spectrum(lines)
        covariances = modal_covariances(
            lines, weights, panel.modal, patches, spectrum, excitation, dampers, panel.air
        )
        labels = (case.label for case in cases)
        by_label |= zip(labels, covariances, strict=True)
    return by_label


def write_rms_maps(
    panel: ResponsePanel,
    scenarios: Sequence[ResponseScenario],
    psd: xr.Dataset,
    attributes: Mapping[str, str],
    output: Files,
) -> None:
    """Write rms values over the whole panel."""
    basis = panel.basis
    layers = stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
    lines = panel.coarse_frequency
    found = scenario_covariances(panel, scenarios, psd, lines, motion_weights(lines))
    maps: dict[str, dict[str, Array]] = {}
    for label, (acceleration, displacement) in found.items():
        maps[label] = {
            "acceleration": rms_map(acceleration, basis.shape_at_vertices),
            "displacement": rms_map(displacement, basis.shape_at_vertices),
        }
        if layers.names:  # of modes from a file there are none
            maps[label] |= layer_maps(displacement, basis.curvature_at_vertices, layers)
        if np.any(basis.core_stress):
            shear = np.swapaxes(basis.core_stress @ basis.shear_at_vertices, 0, 1)
            maps[label] |= {
                name: rms_map(displacement, motion)
                for name, motion in zip(stress.CORE_STRESSES, shear, strict=True)
            }
    errors = [_error_of_points(psd, label) for label in maps]
    dataset = map_dataset(maps, errors, basis.vertex_position, basis.cells, layers.names)
    dataset.assign_attrs(attributes).to_netcdf(output.maps, engine="scipy")
    write_paraview(output.folder, dataset)


def _error_of_points(psd: xr.Dataset, label: str) -> float:
    """Return the largest relative error of g rms of the points, all lines erring together."""
    case = psd.sel(scenario=label)
    if "acceleration_psd_log_error" not in psd:
        return np.nan
    values, lines = case["acceleration_psd"].to_numpy(), case["frequency"].to_numpy()
    log_error = case["acceleration_psd_log_error"].to_numpy()
    total = np.trapezoid(values, lines, axis=0)
    moving = total > 0
    error = np.trapezoid(values * log_error, lines, axis=0)[moving] / (2 * total[moving])
    return float(error.max()) if error.size else np.nan


def _dampers(
    frequency: Array, psd: xr.Dataset, scenario: ResponseScenario, names: Sequence[str]
) -> tuple[Array, Array, float]:
    """Return C_e and m_a (n_patches, nf) at frequencies, and the factor of the excitation."""
    if scenario.is_bare:
        zero = np.zeros((len(names), frequency.size))
        return zero, zero, scenario.factor
    case = psd.sel(scenario=scenario.label, patch=list(names))
    lines = psd["frequency"].to_numpy()

    def values(name: str) -> Array:
        by_patch = case[name].transpose("patch", "frequency").to_numpy()
        rows = [np.interp(frequency, lines, row) for row in by_patch]
        return np.array(rows).reshape(-1, frequency.size)

    return values("equivalent_damping"), values("apparent_mass"), scenario.factor
