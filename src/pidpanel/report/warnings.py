"""Limitations of the numbers: where the response, the damping and the coupon cannot be trusted.

Every function returns sentences, none where there is nothing to say.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.damping.surface_cases import COUNTED
from pidpanel.panel.resolution import ORDER
from pidpanel.paths import SECTION
from pidpanel.report.answer_text import massless_text
from pidpanel.report.inputs import Inputs, ReportedStudy
from pidpanel.report.layouts_section import of_layouts
from pidpanel.report.names import with_names
from pidpanel.report.psds import inside_of
from pidpanel.report.radiation_section import compared, radiation_finding
from pidpanel.report.text import READINGS, number, percent, records
from pidpanel.response.trust import (
    BASIS_ERROR,
    MESH_ERROR,
    MESH_RMS,
    MOTION_RESIDUAL,
    POWER_BALANCE,
)
from pidpanel.solve.mesh_error import ALLOWED_DB, ALLOWED_RMS, decibels

NAMED = 3
"""Scenarios that a warning names, those that it concerns most."""

SINGLE_TONES = (
    "C_e and m_a come from coupons shaken at single frequencies. Under sound a bed kept loose "
    "by low frequencies dissipates less at high ones, so coupons overestimate the damping "
    "there (by about 6 at 2 kHz in one measurement with random drive of 10 g rms). C_e is "
    "that at the sine with the patch's rms acceleration, Γ = √2 a_rms/g, which is a further "
    "assumption."
)

EQUIVALENT_SINE = (
    "The damping depends on the amplitude. It is evaluated at the sine with the patch's rms "
    "acceleration over the whole spectrum, Γ = √2 a_rms/g. This is an assumption; damping "
    "measured with single tones overestimates the effect of a damper under broadband sound."
)


def study_warnings(inputs: Inputs) -> list[str]:
    """Return the limitations of a study with a panel, the most important first."""
    study = inputs.study
    lines = response_warnings(study, inputs.summary, inputs.psd, inputs.layouts)
    if study.surfaces:
        lines.append(SINGLE_TONES)
    elif inputs.layouts["damping_read_at_g"].notna().any():
        lines.append(EQUIVALENT_SINE)
    if inputs.radiation is not None:
        rows = with_names(compared(inputs.summary, inputs.radiation), study.names)
        bare = rows[rows["patch"] == "none"]
        # the others are in the section
        worst = [str(bare["point"].iloc[int(bare["acceleration_rms_g"].argmax())])]
        lines.append(radiation_finding(rows, study.radiation, worst, air_mass=study.air_mass))
    for name, coupon in inputs.coupons.items():
        lines += coupon_warnings(coupon.cases, "" if name == SECTION else f" of {name}")
    return lines


def response_warnings(
    study: ReportedStudy, summary: pd.DataFrame, psd: xr.Dataset, layouts: pd.DataFrame
) -> list[str]:
    """Return the limitations of the response."""
    good = summary[summary["status"] == "ok"]
    return [
        *massless_text(study),
        *_plate_warnings(study, good),
        *_damping_warnings(study, good, psd, layouts),
        *_solution_warnings(study, summary),
    ]


def _plate_warnings(study: ReportedStudy, good: pd.DataFrame) -> list[str]:
    """Where linear plate theory does not hold."""
    names = study.names
    warnings = []
    nonlinear = good[good["beyond_linear_plate"].astype(bool)]
    if len(nonlinear):
        worst = nonlinear.iloc[int(nonlinear["displacement_rms_mm"].argmax())]
        place = ["scenario", "point"]
        left, all_ = len(nonlinear.drop_duplicates(place)), len(good.drop_duplicates(place))
        warnings.append(
            f"Linear plate theory does not hold in {left} of {all_} combinations of scenario "
            "and point: the rms displacement exceeds a tenth of the panel's thickness of "
            f"{study.panel.thickness_mm:g} mm. The largest is "
            f"{worst['displacement_rms_mm']:.3g} mm ({names[worst['scenario']]}, point "
            f"{worst['point']}). A real panel becomes stiffer there through membrane stress, "
            "which is not modelled."
        )
    return warnings


def _damping_warnings(
    study: ReportedStudy, good: pd.DataFrame, psd: xr.Dataset, layouts: pd.DataFrame
) -> list[str]:
    """Where C_e is extrapolated, or goes with several motions or with none."""
    names = study.names
    warnings = []
    for reading in dict.fromkeys(good["reading"]):
        rows = good[good["reading"] == reading].drop_duplicates("scenario")
        outside = rows[rows["outside_run_points_share"] > 0]
        if len(outside):
            parts = [
                f"{names[row['scenario']]}, Γ = {_read_at(row, layouts)}, "
                f"{percent(row['outside_run_points_share'])} of the lines "
                f"({_ranges_outside(psd, reading, row['scenario'])})"
                for row in records(
                    outside.sort_values("outside_run_points_share", ascending=False, kind="stable")
                )
            ]
            if len(parts) > NAMED + 1:
                parts = [*parts[:NAMED], f"and {len(parts) - NAMED} more (All scenarios)"]
            here = good[(good["reading"] == reading) & good["scenario"].isin(outside["scenario"])]
            warnings.append(
                f"{READINGS[reading]}: C_e is extrapolated beyond its data: {'; '.join(parts)}. "
                f"Up to {percent(here['extrapolated_share'].max())} of the change in mean square "
                "acceleration rests on it, lines at less than twice the data's range counted in "
                "part."
            )
        several = rows[rows["levels"] > 1]
        if len(several):
            warnings.append(
                f"{READINGS[reading]}: damping and motion agree at more than one acceleration in "
                + "; ".join(several["scenario"].map(names))
                + "; the solution with the largest motion is shown."
            )
        rough = rows[rows["motion_residual"] > MOTION_RESIDUAL]
        if len(rough):
            warnings.append(
                f"{READINGS[reading]}: the acceleration for C_e is not converged in "
                f"{'; '.join(rough['scenario'].map(names))}: it differs from the resulting "
                f"motion by up to {percent(rough['motion_residual'].max(), 1)}."
            )
    return warnings


def _solution_warnings(study: ReportedStudy, summary: pd.DataFrame) -> list[str]:
    """Where the power, the basis or the stability says that a solution is not right."""
    good, names = summary[summary["status"] == "ok"], study.names
    warnings = []
    balance = good["power_balance_error"].max()
    if balance > POWER_BALANCE:
        warnings.append(
            f"Power input and power loss differ by up to {number(balance, 2)} of the power input."
        )
    if "basis_error" in good and good["basis_error"].max() > BASIS_ERROR:
        largest = records(good.sort_values("basis_error"))[-1]
        warnings.append(
            "The basis is too small for some dampers: against all elements the PSDs of "
            f"{names[largest['scenario']]} ({READINGS[largest['reading']]}) are off by about "
            f"{percent(largest['basis_error'], 1)}, more than {percent(BASIS_ERROR, 1)}."
        )
    if "mesh_error" in good and (
        good["mesh_error"].max() > MESH_ERROR or good["mesh_error_rms"].max() > MESH_RMS
    ):
        largest = records(good.sort_values("mesh_error"))[-1]
        beyond = max(
            decibels(largest["mesh_error"]) / ALLOWED_DB,
            good["mesh_error_rms"].max() / ALLOWED_RMS,
        )
        shorter = math.ceil(10 * beyond ** (1 / ORDER)) / 10
        warnings.append(
            f"The mesh is too coarse: it shifts resonances of {names[largest['scenario']]} "
            f"({READINGS[largest['reading']]}), which changes PSDs by up to "
            f"{number(decibels(largest['mesh_error']), 2)} dB and rms accelerations by up to "
            f"{percent(good['mesh_error_rms'].max(), 1)}. Use element edges {number(shorter, 2)} "
            "times shorter."
        )
    unstable = summary[~summary["status"].isin(["ok", "held"])].drop_duplicates(
        ["reading", "scenario"]
    )
    for reading, rows in unstable.groupby("reading", sort=False):
        warnings.append(
            f"{READINGS[str(reading)]}: no steady response in {len(rows)} scenarios "
            f"({'; '.join(rows['scenario'].map(names))}): "
            f"{', '.join(dict.fromkeys(rows['status']))}."
        )
    return warnings


def _read_at(row: dict[str, Any], layouts: pd.DataFrame) -> str:
    """Return Γ at which the damping of a scenario is read, patch by patch where it has several."""
    if np.isfinite(row["damping_read_at_g"]):
        return f"{row['damping_read_at_g']:.3g}"
    rows = of_layouts(layouts, row["reading"], row["scenario"])
    outside = [row for row in rows if row["outside_run_points_share"] > 0]
    return ", ".join(f"{row['damping_read_at_g']:.3g} ({row['patch']})" for row in outside)


def _ranges_outside(psd: xr.Dataset, reading: str, scenario: str) -> str:
    """Return the frequency ranges in which a scenario's damping is extrapolated."""
    inside = inside_of(psd, reading, scenario)
    frequency = psd["frequency"].to_numpy()
    edges = np.flatnonzero(np.diff(inside.astype(int))) + 1
    runs = np.split(np.arange(len(frequency)), edges)
    parts = [
        f"{frequency[run[0]]:.0f}–{frequency[run[-1]]:.0f} Hz" for run in runs if not inside[run[0]]
    ]
    return ", ".join(parts)


def coupon_warnings(cases: pd.DataFrame, suffix: str = "") -> list[str]:
    """Return the cases that are excluded, not steady or less accurate than requested."""
    warnings = []

    def warn(rows: pd.DataFrame, text: str, *, named: bool = True) -> None:
        if len(rows):
            names = f": {', '.join(rows['case'])}" if named else ""
            warnings.append(f"{len(rows)} of {len(cases)} coupon cases{suffix} {text}{names}.")

    for status, rows in cases[cases["status"] != "ok"].groupby("status", sort=True):
        drifts = "did not reach steady state; included with enlarged errors"
        warn(rows, drifts if status in COUNTED else f"excluded ({status})")
    good = cases[cases["status"] == "ok"]
    value, error = good["equivalent_damping_n_s_m3"], good["equivalent_damping_error_n_s_m3"]
    missed = ~good["target_met"].astype(bool)
    largest = (error / value).abs()[missed].max()
    warn(
        good[missed],
        "stopped at max_cycles before reaching the requested accuracy; their relative standard "
        f"errors reach {percent(largest)}",
        named=False,
    )
    excessive = good[good["share_of_bound"] > 1]
    warn(
        excessive,
        "above the bound of a perfectly inelastic bed (up to "
        f"{excessive['share_of_bound'].max():.2f} times the bound)",
    )
    warn(good[value <= error], "with C_e no larger than its own standard error")
    return warnings
