"""The files of the stage: PSDs and tables of every scenario, maps, files for other programs."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.from_study import reading_of
from pidpanel.damping.readings import DampingReading
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.modes import PanelBasis
from pidpanel.response import stress, uncertainty
from pidpanel.response.export import Curve, third_octave_rows, write_tabrnd1, write_uff58
from pidpanel.response.from_study import (
    PanelFiles,
    PanelInSound,
    SolvedScenario,
    read_panel_in_sound,
)
from pidpanel.response.map_files import map_dataset, write_paraview
from pidpanel.response.maps import layer_maps, modal_covariances, rms_map
from pidpanel.response.model import Response, ResponseError, UnstableDamping
from pidpanel.response.scenarios import ScenarioResponse
from pidpanel.response.solvers import PanelSolver, Request
from pidpanel.response.tabdmp1 import modal_damping_ratio, write_tabdmp1
from pidpanel.response.tables import (
    beside_rows,
    psd_dataset,
    stress_dataset,
    stress_rows,
    summary_rows,
)
from pidpanel.stamp import stamp
from pidpanel.study import Scenario, Study


class OutsideSimulatedRange(ResponseError):
    """C_e is read where no coupon was simulated, and the study refuses that."""


class ResponseFiles(NamedTuple):
    """What `write_response` leaves; ``radiation_csv`` only where the study asks for it."""

    psd_nc: Path
    summary_csv: Path
    stress_nc: Path
    stress_csv: Path
    radiation_csv: Path | None = None


# --------------------------------------------------------------------------- every scenario


def write_response(
    study: Study, files: PanelFiles, surface: Path | None, output: ResponseFiles
) -> None:
    """Write PSDs, rms values, strain and stress of every scenario in every reading.

    Parameters
    ----------
    study
        The study.
    files
        Of the stages upstream.
    surface
        ``damping/surface.nc``; None for a study without the reading ``dem``.
    output
        What to write.

    Raises
    ------
    OutsideSimulatedRange
        Where the study refuses an extrapolated C_e.
    ValueError
        As the stages upstream have it.
    """
    panel = read_panel_in_sound(study, files, study.response.radiation)
    readings: dict[str, DampingReading] = {
        name: reading_of(name, study, surface) for name in study.damping.readings
    }
    layers = _layers(panel)
    # what the diagonal form of the paper costs is said beside it
    judge = None
    if study.response.modal_damping == "diagonal":
        judge = panel.full_solver(panel.frequency, panel.motion_at_points)
    found, errors, rows, strained, strain_rows = {}, {}, [], {}, []
    for case in panel.responses(panel.solver(), readings):
        one, key = case.found, (case.reading, case.scenario.label)
        if isinstance(one, UnstableDamping):
            print(f"{case.reading}, {case.scenario.label}: {one}", file=sys.stderr)
            rows += _unstable_rows(panel, case)
            continue
        if study.damping.level.outside == "refuse":
            _refuse_outside(panel.frequency, case, one)
        found[key] = one
        error = standard_errors(panel, case, one, readings[case.reading])
        if error is not None:
            errors[key] = error
        rows += _summary(panel, case, one, error, _judged(judge, case, one))
        strained[key], more = _strains(panel, layers, one)
        strain_rows += [
            {"reading": case.reading, "scenario": case.scenario.label, **row} for row in more
        ]
    labels = [scenario.label for scenario in study.all_scenarios()]
    axes = (panel.frequency, list(readings), labels, panel.basis.point_names)
    _write_csv(output.summary_csv, pd.DataFrame(rows))
    psds = uncertainty.with_errors(psd_dataset(found, *axes), errors)
    psds.assign_attrs(stamp(study), level=study.damping.level.kind).to_netcdf(
        output.psd_nc, engine="scipy"
    )
    _write_csv(output.stress_csv, pd.DataFrame(strain_rows))
    stress_dataset(strained, *axes, layers.names, stress.QUANTITIES).assign_attrs(
        stamp(study)
    ).to_netcdf(output.stress_nc, engine="scipy")
    if output.radiation_csv is not None:
        _write_csv(output.radiation_csv, with_other_radiation(study, files, readings))


def standard_errors(
    panel: PanelInSound, case: SolvedScenario, one: ScenarioResponse, reading: DampingReading
) -> uncertainty.StandardErrors | None:
    """Return the standard errors of a scenario's response from those of its damping.

    None for the bare panel and for a reading without errors.
    """
    if reading.nodes is None or not case.loads:
        return None
    (gamma,) = one.acceleration_g.tolist()
    covariance = reading.covariance(reading.nodes, case.scenario.fill_fraction, gamma)
    return uncertainty.sensitivity(
        case.solver,
        case.loads,
        one,
        reading.nodes,
        case.pressure_factor,
        own_acceleration=panel.reads_own_motion(reading),
    ).under(covariance)


def with_other_radiation(
    study: Study, files: PanelFiles, readings: Mapping[str, DampingReading]
) -> pd.DataFrame:
    """Return rms values of every scenario with ``response.radiation_beside``."""
    radiation = study.response.radiation_beside
    panel = read_panel_in_sound(study, files, radiation)
    rows = []
    for case in panel.responses(panel.solver(), readings):
        if not isinstance(case.found, UnstableDamping):
            row = {
                "radiation": radiation,
                "reading": case.reading,
                "scenario": case.scenario.label,
            }
            values = beside_rows(case.found, case.bare, panel.basis.point_names)
            rows += [{**row, **value} for value in values]
    return pd.DataFrame(rows)


def _layers(panel: PanelInSound) -> stress.Layers:
    basis = panel.basis
    return stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)


def _row(panel: PanelInSound, case: SolvedScenario) -> dict[str, Any]:
    """Return what a row of ``summary.csv`` is of."""
    scenario = case.scenario
    return {
        "reading": case.reading,
        "scenario": scenario.label,
        "patch": scenario.patch or "none",
        "fill_fraction": scenario.fill_fraction,
        "oaspl_db": scenario.oaspl_db or panel.spectrum.oaspl,
    }


def _unstable_rows(panel: PanelInSound, case: SolvedScenario) -> list[dict[str, Any]]:
    row = _row(panel, case)
    return [{**row, "point": point, "status": "unstable"} for point in panel.basis.point_names]


def _refuse_outside(frequency: Array, case: SolvedScenario, one: ScenarioResponse) -> None:
    if one.inside.all():
        return
    worst = frequency[~one.inside.all(axis=0)]
    raise OutsideSimulatedRange(
        f"{case.reading}, {case.scenario.label}: C_e is read at {one.acceleration_g[0]:.3g} g, "
        f"{worst.min():.4g} to {worst.max():.4g} Hz, outside the simulated range; widen "
        "coupon.sweep or set damping.level.outside: mark"
    )


def _judged(judge: PanelSolver | None, case: SolvedScenario, one: ScenarioResponse) -> Response:
    """Return the response with the full modal damping matrix."""
    if judge is None or not case.loads:
        return one.response
    patches = tuple(load.patch for load in case.loads)
    (full,) = judge.responses([Request(patches, one.equivalent_damping, one.apparent_mass)])
    return full.response.under(case.pressure_factor)


def _summary(
    panel: PanelInSound,
    case: SolvedScenario,
    one: ScenarioResponse,
    error: uncertainty.StandardErrors | None,
    full: Response,
) -> list[dict[str, Any]]:
    """Rows of ``summary.csv`` of a scenario, a point each."""
    balance = panel.power_balance_error(case.scenario.patch, case.pressure_factor, one)
    values = summary_rows(
        one,
        case.bare,
        panel.basis.point_names,
        thickness=panel.study.panel.section.thickness,
        power_balance_error=balance,
        full=full,
    )
    row = _row(panel, case)
    return [{**row, "status": "ok", **own} for own in uncertainty.error_columns(values, error)]


def _strains(
    panel: PanelInSound, layers: stress.Layers, one: ScenarioResponse
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
        for values in stress_rows(panel.frequency, part, quantities, basis.point_names)
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


def write_maps(study: Study, files: PanelFiles, psd_nc: Path, maps_nc: Path, folder: Path) -> None:
    """Write rms values all over the panel for the scenarios of ``response.maps``.

    Parameters
    ----------
    study, files
        As of `write_response`.
    psd_nc
        ``response/psd.nc``, from which C_e and m_a are taken.
    maps_nc, folder
        What to write: NetCDF, and a folder for ParaView.
    """
    panel = read_panel_in_sound(study, files, study.response.radiation)
    psd, basis, layers = read_psd(psd_nc), panel.basis, _layers(panel)
    by_patch: dict[str, list[tuple[str, Scenario]]] = {}
    for scenario in study.mapped_scenarios():
        readings: Sequence[str] = study.damping.readings
        for reading in readings if scenario.patch else readings[:1]:
            if is_steady(psd, reading, scenario.label):
                patch = scenario.patch or basis.patch_names[0]
                by_patch.setdefault(patch, []).append((reading, scenario))
    found: dict[tuple[str, str], dict[str, Array]] = {}
    for patch, cases in by_patch.items():
        covariances = modal_covariances(
            panel.coarse_frequency,
            panel.modal,
            panel.patch(patch),
            panel.psd(panel.coarse_frequency),
            panel.force,
            [_damper(panel, psd, *case) for case in cases],
            panel.air_stiffness,
        )
        for (reading, scenario), one in zip(cases, covariances, strict=True):
            found[reading, scenario.label] = {
                "acceleration": rms_map(one.acceleration, basis.shape_at_vertices),
                "displacement": rms_map(one.displacement, basis.shape_at_vertices),
                **layer_maps(one.displacement, basis.curvature_at_vertices, layers),
            }
    dataset = map_dataset(found, basis.vertex_position, basis.cells, layers.names)
    dataset.assign_attrs(stamp(study)).to_netcdf(maps_nc, engine="scipy")
    write_paraview(folder, dataset)


def _damper(
    panel: PanelInSound, psd: xr.Dataset, reading: str, scenario: Scenario
) -> tuple[Array, Array, float]:
    """C_e and m_a of a scenario (1, nf) on the lines of the maps, and S_p over the study's."""
    one = psd.sel(reading=reading, scenario=scenario.label)
    at = (panel.coarse_frequency, psd["frequency"].to_numpy())
    return (
        np.interp(*at, one["equivalent_damping"].to_numpy())[None],
        np.interp(*at, one["apparent_mass"].to_numpy())[None],
        panel.pressure_factor(scenario),
    )


def write_export(study: Study, modes: Path, psd_nc: Path, folder: Path) -> None:
    """Write files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58.

    Parameters
    ----------
    study
        The study.
    modes
        ``panel/modes.nc``.
    psd_nc
        ``response/psd.nc``.
    folder
        Made where it is not there.
    """
    folder.mkdir(exist_ok=True)
    psd = read_psd(psd_nc)
    frequency = psd["frequency"].to_numpy()
    points = [str(name) for name in psd["point"].to_numpy()]
    bare_of = {scenario.label: scenario.bare.label for scenario in study.all_scenarios()}
    curves, bare = [], {}
    for reading in study.damping.readings:
        for label in bare_of:
            if not is_steady(psd, reading, label):
                continue
            under = psd["acceleration_psd"].sel(reading=reading, scenario=bare_of[label])
            for point in points:
                bare[label, point] = under.sel(point=point).to_numpy()
            one = psd.sel(reading=reading, scenario=label)
            curves += _curves(one, reading, label, points)
            _write_csv(
                folder / f"psd_{reading}_{label}.csv", _psd_columns(one, frequency, points), 7
            )
    title = f"pidpanel study {study.name}"
    _write_csv(folder / "third_octaves.csv", third_octave_rows(frequency, curves, bare))
    write_tabrnd1(folder / "tabrnd1.bdf", frequency, curves, title)
    write_uff58(folder / "psd.uff", frequency, curves, title)
    own, ratios = modal_damping(study, read_basis(modes), psd)
    write_tabdmp1(folder / "tabdmp1.bdf", own, ratios, title)


def _curves(one: xr.Dataset, reading: str, label: str, points: Sequence[str]) -> list[Curve]:
    return [
        Curve(reading, label, point, node, one["acceleration_psd"].sel(point=point).to_numpy())
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
    for reading in study.damping.readings:
        for scenario in study.all_scenarios():
            damping = psd["equivalent_damping"].sel(reading=reading, scenario=scenario.label)
            if np.isnan(damping).any():
                continue  # no steady response
            patch = basis.patch_names.index(scenario.patch) if scenario.patch else 0
            ratios[f"{reading}, {scenario.label}"] = modal_damping_ratio(
                study.panel.damping_ratio,
                natural[own],
                basis.modal_mass[own],
                basis.patch_overlap[patch, own, own],
                np.interp(natural[own], lines, damping.to_numpy()),
            )
    return natural[own], ratios
