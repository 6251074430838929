"""Responses as tables: a row per scenario and point, or patch, and a dataset of the PSDs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, described_variables, variable
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.broadband import EXACT, BroadbandError
from pidpanel.response import model_error
from pidpanel.response.cases import ResponseScenario, SolvedCase
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.stretching import LINEAR
from pidpanel.solve.bands import reduction
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.lines import root_mean_square
from pidpanel.solve.model import PanelResponse
from pidpanel.solve.uncertainty import StandardErrors


def summary_columns(
    answer: LayoutResponse,
    bare: LayoutResponse,
    *,
    thickness: float,
    power_balance_error: float,
    full: PanelResponse,
    read_at_g: float,
    patch_motion_g: float,
) -> dict[str, Any]:
    """Return rms values of a scenario, of all points (n_points,) or one for all.

    Parameters
    ----------
    answer, bare
        The scenario and the panel without damper at the same sound level.
    thickness
        Thickness of the panel [m]: linear plate theory does not hold if w_rms exceeds 10 % of it.
    power_balance_error
        Largest |input − loss| / input over the checked lines.
    full
        The response with the full modal damping matrix: that of the scenario, unless the paper's
        diagonal form was requested.
    read_at_g, patch_motion_g
        Γ at which damping is evaluated, and that of the patch's motion; NaN for several patches.
    """
    outside = 1 - float(answer.inside.all(axis=0).mean()) if len(answer.inside) else 0.0
    acceleration, displacement = answer.response.acceleration_rms, answer.response.displacement_rms
    return {
        "acceleration_rms_g": acceleration / STANDARD_GRAVITY,
        "velocity_rms_m_s": answer.response.velocity_rms,
        "displacement_rms_mm": displacement * 1e3,
        "reduction_db": reduction(bare.response.acceleration_rms, acceleration),
        "diagonal_form_error_db": reduction(acceleration, full.acceleration_rms),
        "damping_read_at_g": read_at_g,
        "patch_motion_g": patch_motion_g,
        "outside_run_points_share": outside,
        "levels": answer.fixed_points,
        "beyond_linear_plate": displacement > LINEAR * thickness,
        "power_balance_error": power_balance_error,
        "motion_residual": answer.residual,
    }


def error_columns(columns: Mapping[str, Any], errors: StandardErrors | None) -> dict[str, Any]:
    """Return the standard errors of the values of `summary_columns`; NaN where there are none."""
    relative = np.nan if errors is None else errors.log_rms
    log_acceleration = np.nan if errors is None else errors.log_acceleration[0]
    return {
        "acceleration_rms_error_g": columns["acceleration_rms_g"] * relative,
        "reduction_error_db": 20 / np.log(10) * relative,
        "damping_read_at_error_g": columns["damping_read_at_g"] * log_acceleration,
    }


def dead_weight_columns(
    bare: LayoutResponse, dead: LayoutResponse | None, masses: Array, panel_mass: float
) -> dict[str, Any]:
    """Return columns of a scenario's mass, and of the effect of the same mass without damping."""
    total, bare_rms = float(masses.sum()), bare.response.acceleration_rms
    treated = np.full(bare_rms.shape, np.nan) if dead is None else dead.response.acceleration_rms
    if not len(masses):
        treated = bare_rms
    return {
        "added_mass_kg": total,
        "added_mass_percent": 100 * total / panel_mass,
        "dead_weight_acceleration_rms_g": treated / STANDARD_GRAVITY,
        "dead_weight_reduction_db": reduction(bare_rms, treated),
    }


# Variables of a case
PSD_VARIABLES = described_variables(Path(__file__).with_name("variables.csv"))


def cases_dataset(
    cases: Mapping[Any, Mapping[str, Array | float]],
    variables: Mapping[str, tuple[str, str, str]],
    coordinates: Mapping[str, Any],
    dtype: type = np.float64,
    place: Sequence[str] = ("scenario",),
) -> xr.Dataset:
    """Return variables of all cases, NaN where a case has none.

    Parameters
    ----------
    cases
        Values by name of each case, by its place: a label, or one for each of several axes.
    variables
        Dimensions of a case, unit and long name of each.
    coordinates
        Coordinates of the axes of ``place`` and all dimensions.
    place
        Axes along which the cases lie.
    """
    axes = [list(coordinates[name]) for name in place]
    data = {}
    for name, (dims, units, long_name) in variables.items():
        shape = tuple(len(coordinates[dim]) for dim in dims.split())
        if not all(shape):  # a NetCDF 3 file has no dimension of length 0
            continue
        table: Array = np.full((*map(len, axes), *shape), np.nan, dtype)
        for key, values in cases.items():
            if name in values:
                where = (key,) if isinstance(key, str) else key
                table[tuple(map(list.index, axes, where))] = values[name]
        data[name] = variable(f"{' '.join(place)} {dims}", table, units, long_name)
    axis = variable("frequency", coordinates["frequency"], "Hz", "frequency")
    lists = {name: list(values) for name, values in coordinates.items() if len(values)}
    return xr.Dataset(data, {**lists, "frequency": axis})


# Unit of a quantity: the unit a person reads, and its factor.
DISPLAY_UNITS = {"1": ("microstrain", 1e6), "Pa": ("MPa", 1e-6)}


def stress_rows(
    frequency: Array,
    psd: Array,
    quantities: Mapping[str, str],
    points: Sequence[str],
    log_error: Array | None = None,
    undamped_psd: Array | None = None,
    model: BroadbandError = EXACT,
) -> list[dict[str, Any]]:
    """Return rows of rms and three sigma, one per point and quantity.

    The error is that of the damping [ln PSD], fully correlated over the lines, and that which the
    damping model has under broadband motion, from the stress without damping.
    """
    rms = root_mean_square(frequency, psd)
    error = np.full(rms.shape, np.nan)
    if log_error is not None:
        square_error = np.trapezoid(psd * log_error[:, :, None], frequency, axis=0)
        error = np.divide(square_error, 2 * rms**2, out=np.zeros_like(rms), where=rms > 0)
    if undamped_psd is not None and any(model):
        model_errors = model_error.log_error(model, root_mean_square(frequency, undamped_psd), rms)
        error = np.hypot(np.nan_to_num(error), model_errors)
    rows = []
    for index, point in enumerate(points):
        for (quantity, unit), value, relative_error in zip(
            quantities.items(), rms[index], error[index], strict=True
        ):
            display_unit, factor = DISPLAY_UNITS[unit]
            row = {"point": point, "quantity": quantity, "unit": display_unit}
            sizes = {"rms": value * factor, "three_sigma": 3 * value * factor}
            rows.append({**row, **sizes, "relative_error": relative_error})
    return rows


def stress_variables(quantities: Mapping[str, str]) -> dict[str, tuple[str, str, str]]:
    """Return dimensions, unit and long name of the PSDs of strain and stress with these units."""
    units = {"1": "Hz-1", "Pa": "Pa2 Hz-1"}
    return {
        f"{name}_psd": ("frequency point layer", units[unit], f"one-sided PSD of {name}")
        for name, unit in quantities.items()
    }


# Columns of ``layouts.csv``.
PATCH_COLUMNS = (
    "scenario", "patch", "damper", "fill_fraction", "area_m2", "mass_kg",
    "damping_read_at_g", "patch_motion_g", "bare_patch_motion_g", "lowest_element_motion_g",
    "highest_element_motion_g", "outside_run_points_share",
)  # fmt: skip


def patch_rows(
    panel: ResponsePanel, case: SolvedCase, response: LayoutResponse
) -> list[dict[str, Any]]:
    """Return rows of ``layouts.csv`` of a case, one for each filled patch."""
    area = panel.load_area(response)
    masses = case.masses(area)
    rows = []
    for name, damper in case.scenario.dampers.items():
        patch = panel.basis.patch_names.index(name)
        loads = panel.carriers[response.patches] == patch
        share = area[loads] / area[loads].sum()
        elements = response.cell_acceleration_g[loads]
        if panel.by_element:
            elements = response.patch_acceleration_g[loads]
        rows.append(
            {
                "patch": name,
                "damper": damper.name,
                "fill_fraction": damper.fill_fraction,
                "area_m2": area[loads].sum(),
                "mass_kg": masses[loads].sum(),
                "damping_read_at_g": np.sqrt(share @ response.acceleration_g[loads] ** 2),
                "patch_motion_g": np.sqrt(share @ response.patch_acceleration_g[loads] ** 2),
                "bare_patch_motion_g": panel.bare_motion_g(case.bare, patch),
                "lowest_element_motion_g": elements.min(),
                "highest_element_motion_g": elements.max(),
                "outside_run_points_share": 1 - response.inside[loads].all(axis=0).mean(),
            }
        )
    return rows


def only_motion(
    panel: ResponsePanel,
    case: SolvedCase,
    response: LayoutResponse,
    scenarios: Sequence[ResponseScenario],
) -> tuple[float, float]:
    """Return Γ of the damping of a single patch, and of its motion; NaN for several patches.

    Of the bare panel it is the motion of the patch that is filled first in the study.
    """
    rows = patch_rows(panel, case, response)
    if len(rows) == 1:
        return rows[0]["damping_read_at_g"], rows[0]["patch_motion_g"]
    first = next((scenario.patches[0] for scenario in scenarios if scenario.patches), None)
    if rows or first is None:
        return np.nan, np.nan
    return np.nan, panel.bare_motion_g(case.bare, panel.basis.patch_names.index(first))


def damping_on_patches(
    panel: ResponsePanel, case: SolvedCase, response: LayoutResponse
) -> dict[str, Array]:
    """Return the damping of a response by patch of the panel, means over area of its loads.

    C_e, m_a and whether they are within the range of their data (n_patches, nf), by names of
    `tables.PSD_VARIABLES`; 0 where a patch is not filled.
    """
    count = len(panel.basis.patch_names)
    damping, mass = np.zeros((2, count, panel.frequency.size))
    inside = np.ones((count, panel.frequency.size))
    area = panel.load_area(response)
    patches = panel.carriers[response.patches]
    for patch in dict.fromkeys(patches.tolist()):
        loads = patches == patch
        share = area[loads] / area[loads].sum()
        damping[patch] = share @ response.equivalent_damping[loads]
        mass[patch] = share @ response.apparent_mass[loads]
        inside[patch] = response.inside[loads].all(axis=0)
    return {"equivalent_damping": damping, "apparent_mass": mass, "inside": inside}
