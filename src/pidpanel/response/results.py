"""The files of the stage: PSDs and tables of every scenario, maps, files for other programs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, Complexes
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.plate_files import read_plate
from pidpanel.provenance.digests import stamp
from pidpanel.response import stress, uncertainty
from pidpanel.response.coupled_damping import read_coupled, read_errors
from pidpanel.response.export import Curve, third_octave_rows, write_tabrnd1, write_uff58
from pidpanel.response.from_study import (
    PanelFiles,
    PanelInSound,
    Readings,
    SolvedScenario,
    read_panel_in_sound,
    readings_of,
    widened,
    with_air,
)
from pidpanel.response.map_files import map_dataset, write_paraview
from pidpanel.response.maps import layer_maps, modal_covariances, rms_map
from pidpanel.response.model import ResponseError, UnstableDamping
from pidpanel.response.refinement import checked_responses, read_left_out, write_left_out
from pidpanel.response.scenarios import ScenarioResponse, Solver
from pidpanel.response.solvers import Request
from pidpanel.response.tabdmp1 import modal_damping_ratio, write_tabdmp1
from pidpanel.response.tables import (
    OnPatches,
    beside_rows,
    dead_weight_columns,
    psd_dataset,
    stress_dataset,
    stress_rows,
    summary_rows,
)
from pidpanel.response.trust import BETWEEN, TRUST, doubts_in, judged
from pidpanel.study import Scenario, Study
from pidpanel.study.damping import COUPLED


class OutsideSimulatedRange(ResponseError):
    """C_e is read where no coupon was simulated, and the study refuses that."""


class ResponseFiles(NamedTuple):
    """What `write_response` leaves; ``radiation_csv`` only where the study asks for it."""

    psd_nc: Path
    summary_csv: Path
    layouts_csv: Path
    stress_nc: Path
    stress_csv: Path
    left_out_nc: Path
    radiation_csv: Path | None = None


# --------------------------------------------------------------------------- every scenario


def write_response(
    study: Study,
    files: PanelFiles,
    plate: Path,
    section: Path,
    damping: Path | None,
    output: ResponseFiles,
    coupled: Path | None = None,
) -> None:
    """Write PSDs, rms values, strain and stress of every scenario in every reading.

    Parameters
    ----------
    study
        The study.
    files
        Of the stages upstream.
    plate
        ``panel/plate.nc``, to check the basis against all elements.
    section
        ``panel/section.csv``, from which the panel's mass is taken.
    damping
        Folder of the surfaces, ``results/<study>/damping``; None for a study without any.
    output
        What to write.
    coupled
        Folder of what the coupled runs found; None for a study without any.

    Raises
    ------
    OutsideSimulatedRange
        Where the study refuses an extrapolated C_e.
    ValueError
        As the stages upstream have it.
    """
    found_coupled = None if coupled is None else coupled / "impedance.csv"
    readings = readings_of(study, damping, found_coupled)
    start = read_panel_in_sound(study, files, study.response.radiation)
    checked = checked_responses(start, plate, readings)
    panel = checked.panel
    panel_mass = read_panel_mass(study, section)
    layers = _layers(panel)
    # what the diagonal form of the paper costs is said beside it
    of_coupled = {}
    if coupled is not None:
        tables = coupled / "summary.csv", coupled / "psd.csv"
        of_coupled = read_errors(*tables, panel.frequency, panel.basis.point_names)
    judge = panel.full_solver() if study.response.modal_damping == "diagonal" else None
    found, dead, errors = {}, {}, {}
    rows, layout_rows, strained, strain_rows = [], [], {}, []
    for case, basis_error in zip(checked.cases, checked.basis_error.tolist(), strict=True):
        one, key = case.found, (case.reading, case.scenario.label)
        if isinstance(one, UnstableDamping):
            print(f"{case.reading}, {case.scenario.label}: {one}", file=sys.stderr)
            rows += _unstable_rows(panel, case)
            continue
        if study.damping.level.outside == "refuse":
            _refuse_outside(panel.frequency, case, one)
        error = standard_errors(panel, case, one)
        if case.reading == COUPLED and case.scenario.label in of_coupled:
            # those of the runs hold more than the errors of C_e and m_a
            error = of_coupled[case.scenario.label]
        if error is not None:
            errors[key] = error
        by_patch = patch_rows(panel, case, one)
        rows += [
            {**row, "basis_error": basis_error}
            for row in _summary(panel, case, one, error, judge, panel_mass)
        ]
        layout_rows += [{**_what(case), **row} for row in by_patch]
        found[key] = on_patches(panel, case, one)
        if case.dead_weight is not None:
            dead[key] = case.dead_weight.response.acceleration_psd
        strained[key], more = _strains(panel, layers, one, error)
        strain_rows += [{**_what(case), **row} for row in more]
    labels = [scenario.label for scenario in study.all_scenarios()]
    basis = panel.basis
    axes = (panel.frequency, list(readings.names), labels, basis.point_names)
    summary = judged(study, pd.DataFrame(rows), of_coupled if coupled is not None else None)
    _write_csv(output.summary_csv, summary)
    _write_csv(output.layouts_csv, pd.DataFrame(layout_rows, columns=list(PATCH_COLUMNS)))
    psds = uncertainty.with_errors(psd_dataset(found, dead, *axes, basis.patch_names), errors)
    psds.assign_attrs(
        stamp(study), level=study.damping.level.kind, resolved_damping_ratio=panel.resolved_ratio
    ).to_netcdf(output.psd_nc, engine="scipy")
    _write_csv(output.stress_csv, pd.DataFrame(strain_rows))
    stress_dataset(strained, *axes, layers.names, stress.QUANTITIES).assign_attrs(
        stamp(study)
    ).to_netcdf(output.stress_nc, engine="scipy")
    write_left_out(output.left_out_nc, checked.left_out, stamp(study))
    if output.radiation_csv is not None:
        if panel.air is None and checked.left_out.shape[1]:
            other = with_air(start, files, study.response.radiation_beside)
            other = widened(other, read_plate(plate), checked.left_out)
            other = replace(other, least_damping_ratio=panel.least_damping_ratio)
        else:
            other = with_air(panel, files, study.response.radiation_beside)
        _write_csv(output.radiation_csv, with_other_radiation(other, readings))


def read_panel_mass(study: Study, section: Path) -> float:
    """Return the mass of the panel with what is attached to it [kg]."""
    table = pd.read_csv(section).set_index("quantity")["value"]
    return float(table["mass"]) + sum(one.mass_kg for one in study.panel.masses.values())


def standard_errors(
    panel: PanelInSound, case: SolvedScenario, one: ScenarioResponse
) -> uncertainty.StandardErrors | None:
    """Return the standard errors of a scenario's response from those of its damping.

    Loads of one source have the errors of that in common; those of different ones are
    independent. None for the bare panel and where no load has errors.
    """
    known = [filled.reading.nodes for filled in case.filled]
    with_errors = [nodes for nodes in known if nodes is not None]
    if not with_errors:
        return None
    nodes = np.unique(np.concatenate(with_errors))
    at = [
        (filled.fill_fraction, float(gamma))
        for filled, gamma in zip(case.filled, one.acceleration_g, strict=True)
    ]
    blocks = [
        [
            a.reading.cross_covariance(nodes, at[i], at[j])
            if a.source == b.source and a.reading.nodes is not None
            else None
            for j, b in enumerate(case.filled)
        ]
        for i, a in enumerate(case.filled)
    ]
    covariance, _ = uncertainty.joint_covariance(blocks, len(nodes))
    return uncertainty.sensitivity(
        case.solver,
        case.layout.loads,
        one,
        nodes,
        case.pressure_factor,
        own_acceleration=case.layout.own_acceleration,
    ).under(covariance)


def with_other_radiation(panel: PanelInSound, readings: Readings) -> pd.DataFrame:
    """Return rms values of every scenario on a panel with ``response.radiation_beside``."""
    radiation = panel.study.response.radiation_beside
    rows = []
    # only rms values are asked for: few lines give them within 1e-3
    asked = panel.asked(readings, dead_weight=False).response_alone()
    for case in panel.solved(panel.solver(rms_only=True), asked):
        if not isinstance(case.found, UnstableDamping):
            read_at, _ = _motion_of_one(panel, case, case.found)
            values = beside_rows(case.found, case.bare, panel.basis.point_names, read_at)
            rows += [{"radiation": radiation, **_what(case), **value} for value in values]
    return pd.DataFrame(rows)


def _layers(panel: PanelInSound) -> stress.Layers:
    basis = panel.basis
    return stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)


def _what(case: SolvedScenario) -> dict[str, Any]:
    return {"reading": case.reading, "scenario": case.scenario.label}


def _row(panel: PanelInSound, case: SolvedScenario) -> dict[str, Any]:
    """Return what a row of ``summary.csv`` is of."""
    scenario = case.scenario
    return {
        **_what(case),
        "patch": scenario.patch or "none",
        "fill_fraction": scenario.fill_fraction,
        "oaspl_db": scenario.oaspl_db or panel.spectrum.oaspl,
    }


def _unstable_rows(panel: PanelInSound, case: SolvedScenario) -> list[dict[str, Any]]:
    row = _row(panel, case)
    return [{**row, "status": "unstable", "point": point} for point in panel.basis.point_names]


def _refuse_outside(frequency: Array, case: SolvedScenario, one: ScenarioResponse) -> None:
    for filled, gamma, inside in zip(case.filled, one.acceleration_g, one.inside, strict=True):
        if inside.all():
            continue
        worst = frequency[~inside]
        raise OutsideSimulatedRange(
            f"{case.reading}, {case.scenario.label}: C_e is read at {gamma:.3g} g, "
            f"{worst.min():.4g} to {worst.max():.4g} Hz, outside the simulated range of "
            f"{filled.source}; widen its sweep or set damping.level.outside: mark"
        )


def _summary(
    panel: PanelInSound,
    case: SolvedScenario,
    one: ScenarioResponse,
    error: uncertainty.StandardErrors | None,
    judge: Solver | None,
    panel_mass: float,
) -> list[dict[str, Any]]:
    """Rows of ``summary.csv`` of a scenario, a point each."""
    full = one.response
    if judge is not None:
        patches = case.layout.patches
        request = Request(patches, one.equivalent_damping, one.apparent_mass)
        full = judge.responses([request])[0].response.under(case.pressure_factor)
    read_at, motion = _motion_of_one(panel, case, one)
    values = summary_rows(
        one,
        case.bare,
        panel.basis.point_names,
        thickness=panel.study.panel.section.thickness,
        power_balance_error=panel.power_balance_error(one, case.pressure_factor),
        full=full,
        read_at_g=read_at,
        patch_motion_g=motion,
    )
    beside = dead_weight_columns(
        case.bare, case.dead_weight, case.masses(panel.load_area(one)), panel_mass
    )
    row = _row(panel, case)
    return [
        {**row, "status": "held" if held else "ok", **own, **more}
        for held, own, more in zip(
            panel.held, uncertainty.error_columns(values, error), beside, strict=True
        )
    ]


def _motion_of_one(
    panel: PanelInSound, case: SolvedScenario, one: ScenarioResponse
) -> tuple[float, float]:
    """Γ at which the damping of the only patch is read, and of its motion; NaN for several.

    Of the bare panel it is the motion of the patch that is filled first in the study.
    """
    rows = patch_rows(panel, case, one)
    if len(rows) == 1:
        return rows[0]["damping_read_at_g"], rows[0]["patch_motion_g"]
    filled = next((s.patches[0] for s in panel.study.all_scenarios() if s.patches), None)
    if rows or filled is None:
        return np.nan, np.nan
    return np.nan, panel.bare_motion_g(case.bare, panel.basis.patch_names.index(filled))


def on_patches(panel: PanelInSound, case: SolvedScenario, one: ScenarioResponse) -> OnPatches:
    """Return a response with its damping by patch of the panel: means over area of its loads."""
    count = len(panel.basis.patch_names)
    damping, mass = np.zeros((2, count, panel.frequency.size))
    inside = np.ones((count, panel.frequency.size))
    area = panel.load_area(one)
    owner = np.array([filled.patch for filled in case.filled], dtype=np.int64)
    for patch in dict.fromkeys(owner.tolist()):
        own = owner == patch
        share = area[own] / area[own].sum()
        damping[patch] = share @ one.equivalent_damping[own]
        mass[patch] = share @ one.apparent_mass[own]
        inside[patch] = one.inside[own].all(axis=0)
    return OnPatches(one.response, damping, mass, inside)


PATCH_COLUMNS = (
    "reading", "scenario", "patch", "damper", "fill_fraction", "area_m2", "mass_kg",
    "damping_read_at_g", "patch_motion_g", "bare_patch_motion_g", "lowest_element_motion_g",
    "highest_element_motion_g", "outside_run_points_share",
)  # fmt: skip
"""Columns of ``layouts.csv``."""


def patch_rows(
    panel: PanelInSound, case: SolvedScenario, one: ScenarioResponse
) -> list[dict[str, Any]]:
    """Rows of ``layouts.csv`` of a scenario, a filled patch each."""
    area = panel.load_area(one)
    masses = case.masses(area)
    rows = []
    for filling in case.scenario.fillings:
        patch = panel.basis.patch_names.index(filling.patch)
        own = np.array([filled.patch == patch for filled in case.filled])
        share = area[own] / area[own].sum()
        cells = one.patch_acceleration_g[own] if panel.by_element else one.cell_acceleration_g[own]
        rows.append(
            {
                "patch": filling.patch,
                "damper": case.filled[int(own.argmax())].source,
                "fill_fraction": filling.fill_fraction,
                "area_m2": area[own].sum(),
                "mass_kg": masses[own].sum(),
                "damping_read_at_g": np.sqrt(share @ one.acceleration_g[own] ** 2),
                "patch_motion_g": np.sqrt(share @ one.patch_acceleration_g[own] ** 2),
                "bare_patch_motion_g": panel.bare_motion_g(case.bare, patch),
                "lowest_element_motion_g": cells.min(),
                "highest_element_motion_g": cells.max(),
                "outside_run_points_share": 1 - one.inside[own].all(axis=0).mean(),
            }
        )
    return rows


def _strains(
    panel: PanelInSound,
    layers: stress.Layers,
    one: ScenarioResponse,
    error: uncertainty.StandardErrors | None,
) -> tuple[Array, list[dict[str, Any]]]:
    """PSDs of strain and stress in the layers, and the rows of the layers and of the core."""
    basis = panel.basis
    psd = stress.layer_psd(one.response, layers)
    parts = {
        layer: (psd[:, :, number], stress.QUANTITIES) for number, layer in enumerate(layers.names)
    }
    if np.any(basis.core_stress):
        core = stress.core_psd(one.response, basis.core_stress)
        parts["core"] = (core, stress.CORE_QUANTITIES)
    rows = [
        {"layer": layer, **values}
        for layer, (part, quantities) in parts.items()
        for values in stress_rows(
            panel.frequency,
            part,
            quantities,
            basis.point_names,
            None if error is None else error.log_psd,
        )
    ]
    return psd, rows


def _write_csv(path: Path, frame: pd.DataFrame, digits: int = 6) -> None:
    frame.to_csv(path, index=False, float_format=f"%.{digits}g")


# --------------------------------------------------------------------------- what rests on psd.nc


def read_psd(path: Path) -> xr.Dataset:
    """Read the dataset of ``response/psd.nc``, in memory."""
    with xr.open_dataset(path, engine="scipy") as dataset:
        return dataset.load()


def is_steady(psd: xr.Dataset, reading: str, scenario: str) -> bool:
    """Whether a scenario has a response; none where the damping feeds the panel."""
    one = psd["acceleration_psd"].sel(reading=reading, scenario=scenario)
    return not bool(np.isnan(one).any())


def write_maps(
    study: Study,
    files: PanelFiles,
    plate: Path,
    left_out: Path,
    psd_nc: Path,
    coupled: Path | None,
    maps_nc: Path,
    folder: Path,
) -> None:
    """Write rms values all over the panel for the scenarios of ``response.maps``.

    Parameters
    ----------
    study, files
        As of `write_response`.
    plate, left_out
        ``panel/plate.nc`` and ``response/left_out.nc``: the basis of the responses.
    psd_nc
        ``response/psd.nc``, from which C_e and m_a are taken.
    coupled
        ``coupled/impedance.csv``, from which the particles' own force is taken; None for none.
    maps_nc, folder
        What to write: NetCDF, and a folder for ParaView.
    """
    panel = read_panel_in_sound(study, files, study.response.radiation)
    panel = widened(panel, read_plate(plate), read_left_out(left_out))
    psd, basis, layers = read_psd(psd_nc), panel.basis, _layers(panel)
    panel = replace(panel, least_damping_ratio=float(psd.attrs["resolved_damping_ratio"]))
    own_forces = {} if coupled is None else read_coupled(coupled)
    by_patches: dict[tuple[tuple[str, ...], str], list[tuple[str, Scenario]]] = {}
    for scenario in study.mapped_scenarios():
        for reading in study.readings[: 1 if scenario.is_bare else None]:
            if is_steady(psd, reading, scenario.label):
                # a force of the particles' own is that of one scenario
                own = scenario.label if reading == COUPLED and not scenario.is_bare else ""
                by_patches.setdefault((scenario.patches, own), []).append((reading, scenario))
    found: dict[tuple[str, str], dict[str, Array]] = {}
    for (names, own), cases in by_patches.items():
        force: Callable[[Array], Array | Complexes] = panel.force
        sources = {
            basis.patch_names.index(patch): one
            for (label, patch), one in own_forces.items()
            if label == own
        }
        if sources:
            factor = panel.pressure_factor(cases[0][1])
            force = panel.force_with(panel.own_forces(sources), factor)
        covariances = modal_covariances(
            panel.coarse_frequency,
            panel.modal,
            panel.patches.only([basis.patch_names.index(name) for name in names]),
            panel.psd(panel.coarse_frequency),
            force,
            [_dampers(panel, psd, *case) for case in cases],
            panel.air_stiffness,
        )
        for (reading, scenario), one in zip(cases, covariances, strict=True):
            found[reading, scenario.label] = {
                "acceleration": rms_map(one.acceleration, basis.shape_at_vertices),
                "displacement": rms_map(one.displacement, basis.shape_at_vertices),
                **layer_maps(one.displacement, basis.curvature_at_vertices, layers),
            }
    errors = [_error_of_points(psd, *key) for key in found]
    dataset = map_dataset(found, errors, basis.vertex_position, basis.cells, layers.names)
    dataset.assign_attrs(stamp(study)).to_netcdf(maps_nc, engine="scipy")
    write_paraview(folder, dataset)


def _error_of_points(psd: xr.Dataset, reading: str, label: str) -> float:
    """Return the largest relative error of g rms of the points, all lines erring together."""
    one = psd.sel(reading=reading, scenario=label)
    if "acceleration_psd_log_error" not in psd:
        return np.nan
    of = one["acceleration_psd"].to_numpy(), one["acceleration_psd_log_error"].to_numpy()
    lines = one["frequency"].to_numpy()
    whole = np.trapezoid(of[0], lines, axis=0)
    moving = whole > 0
    error = np.trapezoid(of[0] * of[1], lines, axis=0)[moving] / (2 * whole[moving])
    return float(error.max()) if error.size else np.nan


def _dampers(
    panel: PanelInSound, psd: xr.Dataset, reading: str, scenario: Scenario
) -> tuple[Array, Array, float]:
    """C_e and m_a (n_loads, nf) on the lines of the maps, and S_p over the study's."""
    lines, at = psd["frequency"].to_numpy(), panel.coarse_frequency
    if scenario.is_bare:
        none = np.zeros((0, at.size))
        return none, none, panel.pressure_factor(scenario)
    one = psd.sel(reading=reading, scenario=scenario.label, patch=list(scenario.patches))

    def read(name: str) -> Array:
        of = one[name].transpose("patch", "frequency").to_numpy()
        return np.array([np.interp(at, lines, row) for row in of]).reshape(-1, at.size)

    return read("equivalent_damping"), read("apparent_mass"), panel.pressure_factor(scenario)


def write_export(study: Study, modes: Path, psd_nc: Path, summary_csv: Path, folder: Path) -> None:
    """Write files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58.

    Parameters
    ----------
    study
        The study.
    modes
        ``panel/modes.nc``.
    psd_nc, summary_csv
        ``response/psd.nc`` and ``response/summary.csv``.
    folder
        Made where it is not there.
    """
    folder.mkdir(exist_ok=True)
    psd = read_psd(psd_nc)
    summary = pd.read_csv(summary_csv, dtype={"scenario": str})
    trust = summary.groupby(["reading", "scenario"])[TRUST].first()
    doubts = {
        (row.reading, row.scenario): BETWEEN.join(doubts_in({"doubts": row.doubts}))
        for row in trust.reset_index().itertuples()
    }
    frequency = psd["frequency"].to_numpy()
    points = [str(name) for name in psd["point"].to_numpy()]
    bare_of = {scenario.label: scenario.bare.label for scenario in study.all_scenarios()}
    curves, bare = [], {}
    for reading in study.readings:
        for label in bare_of:
            if not is_steady(psd, reading, label):
                continue
            under = psd["acceleration_psd"].sel(reading=reading, scenario=bare_of[label])
            for point in points:
                bare[label, point] = under.sel(point=point).to_numpy()
            one = psd.sel(reading=reading, scenario=label)
            curves += _curves(one, reading, label, points, doubts[reading, label])
            _write_csv(
                folder / f"psd_{reading}_{label}.csv", _psd_columns(one, frequency, points), 7
            )
    title = f"pidpanel study {study.name}"
    bands = third_octave_rows(frequency, curves, bare)
    _write_csv(folder / "third_octaves.csv", bands.join(trust, on=["reading", "scenario"]))
    write_tabrnd1(folder / "tabrnd1.bdf", frequency, curves, title)
    write_uff58(folder / "psd.uff", frequency, curves, title)
    own, ratios = modal_damping(study, read_basis(modes), psd)
    write_tabdmp1(folder / "tabdmp1.bdf", own, ratios, title)


def _curves(
    one: xr.Dataset, reading: str, label: str, points: Sequence[str], doubts: str
) -> list[Curve]:
    psd = one["acceleration_psd"]
    return [
        Curve(reading, label, point, node, psd.sel(point=point).to_numpy(), doubts)
        for node, point in enumerate(points, start=1)
    ]


def _psd_columns(one: xr.Dataset, frequency: Array, points: Sequence[str]) -> pd.DataFrame:
    """PSDs of a scenario in the units that a person reads."""
    columns = {"frequency_hz": frequency}
    for point in points:
        here = one.sel(point=point)
        acceleration = here["acceleration_psd"].to_numpy()
        columns |= {
            f"acceleration_psd_g2_hz_{point}": acceleration / STANDARD_GRAVITY**2,
            f"velocity_psd_m2_s2_hz_{point}": here["velocity_psd"].to_numpy(),
            f"displacement_psd_mm2_hz_{point}": here["displacement_psd"].to_numpy() * 1e6,
        }
    return pd.DataFrame(columns)


def modal_damping(
    study: Study, basis: PanelBasis, psd: xr.Dataset
) -> tuple[Array, dict[str, Array]]:
    """Damping ratio of every mode in every scenario that has a steady response.

    Parameters
    ----------
    study
        The study.
    basis
        Modes of the panel.
    psd
        The dataset of ``response/psd.nc``, from which C_e is taken.

    Returns
    -------
    frequency
        (n,) natural frequencies within the range of the PSDs, rising [Hz].
    ratios
        (n,) damping ratios [1] by reading and scenario.
    """
    lines = psd["frequency"].to_numpy()
    natural = basis.natural_frequency
    own = np.flatnonzero(~basis.is_residual & (natural >= lines[0]) & (natural <= lines[-1]))
    own = own[np.argsort(natural[own])]
    ratios = {}
    for reading in study.readings:
        for scenario in study.all_scenarios():
            if not is_steady(psd, reading, scenario.label):
                continue
            ratio = np.full(own.size, study.panel.damping_ratio)
            for name in scenario.patches:
                at = {"reading": reading, "scenario": scenario.label, "patch": name}
                ratio = modal_damping_ratio(
                    ratio,
                    natural[own],
                    basis.modal_mass[own],
                    basis.patch_overlap[basis.patch_names.index(name), own, own],
                    np.interp(natural[own], lines, psd["equivalent_damping"].sel(at).to_numpy()),
                )
            ratios[f"{reading}, {scenario.label}"] = ratio
    return natural[own], ratios
