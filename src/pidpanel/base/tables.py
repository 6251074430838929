"""Curves of all cases as datasets, and tables of their rms values and peaks."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, described_variables
from pidpanel.base.random import Limit, RandomCase
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis import PanelBasis
from pidpanel.response.tables import cases_dataset
from pidpanel.response.trust import judged_base
from pidpanel.solve.base_motion import Inertia
from pidpanel.solve.mesh_error import MeshShift, mesh_error
from pidpanel.solve.uncertainty import StandardErrors

INPUTS, DIRECTIONS = ("stated", "notched"), ("up", "down")

# Variables of a case
VARIABLES = described_variables(Path(__file__).with_name("variables.csv"))


def mode_rows(basis: PanelBasis, inertia: Inertia) -> pd.DataFrame:
    """Return a row per mode of a basis: frequency, masses, and sums of effective masses."""
    modes = np.flatnonzero(~basis.is_residual)
    effective = inertia.effective_mass(basis.modal_mass)[modes]
    return pd.DataFrame(
        {
            "mode": np.arange(1, modes.size + 1),
            "frequency_hz": basis.natural_frequency[modes],
            "modal_mass_kg": basis.modal_mass[modes],
            "participation_kg": inertia.participation[modes],
            "effective_mass_kg": effective,
            "effective_mass_share": effective / inertia.mass,
            "cumulative_share": np.cumsum(effective) / inertia.mass,
        }
    )


def curves_dataset(
    cases: Mapping[Any, Mapping[str, Array | float]],
    frequency: Array,
    points: Sequence[str],
    **place: Sequence[str],
) -> xr.Dataset:
    """Return the results of all cases, by names of `VARIABLES`; NaN where there are none."""
    variables = {name: VARIABLES[name] for values in cases.values() for name in values}
    axes = {"frequency": frequency, "point": points, **place}
    return cases_dataset(cases, variables, axes, place=tuple(place))


def random_dataset(
    cases: Sequence[RandomCase],
    labels: Sequence[str],
    points: Sequence[str],
    shifts: Mapping[str, MeshShift],
) -> xr.Dataset:
    """Return PSDs of input, points and interface under the stated and the notched input.

    ``shifts`` are those of `response.refinement.mesh_shifts`.
    """
    results: dict[tuple[str, str], dict[str, Array | float]] = {}
    for case in cases:
        empty = np.full((len(case.frequency), len(points) + 1), np.nan)
        unknown = StandardErrors(empty, empty[0], empty[0])
        for name, part in zip(INPUTS, (case.stated, case.notched), strict=True):
            if part is None:
                continue
            shift = shifts[case.scenario.label]
            mesh = mesh_error(case.frequency, part.absolute, part.input, shift, over_largest=True)
            errors = part.errors or unknown
            results[case.scenario.label, name] = {
                "input_psd": part.input,
                "absolute_acceleration_psd": part.absolute,
                "relative_displacement_psd": part.relative,
                "interface_force_psd": part.force,
                "outside_share": part.outside_share,
                "mesh_error": mesh.line,
                "mesh_error_rms": mesh.rms,
                "point_error_rms": mesh.point_rms,
                "log_error": errors.log_psd[:, :-1],
                "log_rms_error": errors.log_rms[:-1],
                "force_log_error": errors.log_psd[:, -1],
                "force_log_rms_error": float(errors.log_rms[-1]),
            }
    place = {"scenario": labels, "input": INPUTS}
    return curves_dataset(results, cases[0].frequency, points, **place)


def summary_rows(curves: xr.Dataset) -> pd.DataFrame:
    """Return a row per case, input and point of a `random_dataset`."""
    rms = curves.fillna(0.0).integrate("frequency") ** 0.5
    acceleration = rms["absolute_acceleration_psd"] / STANDARD_GRAVITY
    bare = acceleration.isel(scenario=0)
    gain = ((curves["absolute_acceleration_psd"] / curves["input_psd"]) ** 0.5).fillna(0.0)
    mass = (curves["interface_force_psd"] / curves["input_psd"]) ** 0.5
    table = xr.Dataset(
        {
            "input_rms_g": rms["input_psd"] / STANDARD_GRAVITY,
            "acceleration_rms_g": acceleration,
            "acceleration_rms_error_g": acceleration * curves["log_rms_error"],
            "reduction_db": 20 * np.log10(bare / acceleration),
            "relative_displacement_rms_mm": 1e3 * rms["relative_displacement_psd"],
            "peak_transmissibility": gain.max("frequency"),
            "peak_frequency_hz": gain.idxmax("frequency"),
            "interface_force_rms_n": rms["interface_force_psd"],
            "interface_force_rms_error_n": rms["interface_force_psd"]
            * curves["force_log_rms_error"],
            "peak_dynamic_mass_kg": mass.max("frequency"),
            "outside_run_points_share": curves["outside_share"],
            "mesh_error": curves["mesh_error"],
            "mesh_error_rms": curves["mesh_error_rms"],
            "point_error_rms": curves["point_error_rms"],
        }
    )
    table = table.where(curves["outside_share"] >= 0)
    rows = table.to_dataframe(["scenario", "input", "point"]).reset_index()
    unstable = rows["acceleration_rms_g"].isna()
    rows.insert(3, "status", np.where(unstable, "unstable", "ok"))
    shown = rows[~unstable | (rows["input"] == INPUTS[0])]
    return judged_base(shown, ["scenario", "input"])


def psd_rows(curves: xr.Dataset) -> pd.DataFrame:
    """Return the PSDs of a `random_dataset` line by line, a column for each point."""
    to_g = STANDARD_GRAVITY**-2
    points = (to_g * curves["absolute_acceleration_psd"]).to_dataset(dim="point")
    table = points.rename({name: f"acceleration_psd_g2_hz_{name}" for name in points})
    table["input_psd_g2_hz"] = to_g * curves["input_psd"]
    table["interface_force_psd_n2_hz"] = curves["interface_force_psd"]
    table = table.rename({"frequency": "frequency_hz"})
    rows = table.to_dataframe(["scenario", "input", "frequency_hz"]).reset_index()
    return rows[rows["interface_force_psd_n2_hz"].notna()]


def input_rows(cases: Sequence[RandomCase], limits: Sequence[Limit]) -> pd.DataFrame:
    """Return the notched input of each case line by line [g²/Hz], with the reason of each notch."""
    names = ["", *(limit.reason for limit in limits)]
    parts = [
        pd.DataFrame(
            {
                "scenario": case.scenario.label,
                "frequency_hz": case.frequency,
                "stated_psd_g2_hz": case.stated.input / STANDARD_GRAVITY**2,
                "notched_psd_g2_hz": case.notches.psd / STANDARD_GRAVITY**2,
                "notch_db": 10 * np.log10(case.stated.input / case.notches.psd),
                "reason": [names[reason + 1] for reason in case.notches.reason.tolist()],
            }
        )
        for case in cases
        if case.notches is not None and case.stated is not None
    ]
    return pd.concat(parts, ignore_index=True)


def peak_rows(curves: xr.Dataset, level_g: float) -> pd.DataFrame:
    """Return the peaks of sweeps at a level [g], a row per case, direction and point."""
    acceleration, force = curves["acceleration"] / STANDARD_GRAVITY, curves["interface_force"]

    def error_at_peak(values: xr.DataArray, log_error: str) -> xr.DataArray:
        at_peak = values == values.max("frequency")
        return (values * curves[log_error]).where(at_peak).max("frequency")

    peaks = xr.Dataset(
        {
            "peak_acceleration_g": acceleration.max("frequency"),
            "peak_acceleration_error_g": error_at_peak(acceleration, "acceleration_log_error"),
            "peak_frequency_hz": acceleration.idxmax("frequency"),
            "peak_transmissibility": acceleration.max("frequency") / level_g,
            "peak_relative_displacement_mm": 1e3 * curves["relative_displacement"].max("frequency"),
            "peak_interface_force_n": force.max("frequency"),
            "peak_interface_force_error_n": error_at_peak(force, "interface_force_log_error"),
            "motion_residual": curves["motion_residual"],
            "mesh_error": curves["mesh_error"],
        }
    )
    rows = peaks.to_dataframe(["scenario", "direction", "point"]).reset_index()
    return judged_base(rows, ["scenario", "direction"])
