"""Rows of the published atlas from the cases of a study."""

import math
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import pandas as pd

from pidpanel.atlas.groups import Direction
from pidpanel.constants import LIGGGHTS_VERSION, STANDARD_GRAVITY
from pidpanel.coupon.bed import Bed
from pidpanel.coupon.cases import Case
from pidpanel.coupon.contact import Constants

# Statuses of the cases used. A run that is not steady has an error as large as its drift. The
# energy balance misses losses of strongly damped contacts with friction (docs/atlas.md); the
# momentum, from which C_e and m_a come, does not.
COUNTED = ("ok", "NotSteady", "EnergyNotClosed")


def atlas_table(cases: Mapping[str, Case], rows: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the rows of the atlas, in the order of the cases, by label.

    Rows are those of ``coupon/cases.csv`` without failed cases; the source names who computed them
    with which study. Raises `ValueError` for a case that the groups do not describe.
    """
    counted = rows[rows["status"].isin(COUNTED)]
    table = [
        _row(cases[str(row["case"])], row) | {"source": source}
        for row in counted.to_dict("records")
    ]
    return pd.DataFrame(table)


def _row(case: Case, row: Mapping[Any, Any]) -> dict[str, Any]:
    run, drive = case.point, case.point.drive
    packing, constants = run.packing, run.constants
    _check_groups(case)
    mass = row["particle_mass_per_area_kg_m2"]
    scale = mass * drive.angular_frequency  # of C_e [N s/m³]
    states = [float(value) for value in _listed(row["state_damping_n_s_m3"])]
    return {
        "case": case.label,
        "fill_fraction": run.fill_fraction,
        "gamma": drive.gamma,
        "stroke_per_gap": run.bed.stroke_per_gap(drive),
        "restitution": constants.restitution,
        "friction": constants.friction,
        "width_per_diameter": packing.across_flats / packing.diameter,
        "depth_per_diameter": packing.depth / packing.diameter,
        "direction": _direction(run.bed),
        "loss_factor": row["loss_factor"],
        "loss_factor_error": row["loss_factor_error"],
        "loss_factor_statistical_error": row["statistical_error_n_s_m3"] / scale,
        "mass_ratio": row["apparent_mass_kg_m2"] / mass,
        "mass_ratio_error": row["apparent_mass_error_kg_m2"] / mass,
        "states": row["states"],
        "state_loss_factors": " ".join(f"{value / scale:.4g}" for value in states),
        "state_shares": " ".join(_listed(row["state_share"])),
        "hardness": packing.density * drive.speed**2 / constants.youngs_modulus,
        "contact_time_per_period": run.contact_time_at(constants.youngs_modulus) * drive.frequency,
        "overlap_per_radius": run.overlap_at(constants.youngs_modulus),
        "modulus_bias": row["modulus_bias"],
        "bulk_fraction": row["bulk_fraction"],
        "spheres_per_cell": row["spheres_per_cell"],
        "cells": row["cells"],
        "seeds": row["seeds"],
        "cycles": row["cycles_used"],
        "closure": row["closure"],
        "target_met": str(row["target_met"]).lower(),
        "status": row["status"],
        "diameter_mm": packing.diameter * 1e3,
        "density_kg_m3": packing.density,
        "youngs_modulus_mpa": constants.youngs_modulus / 1e6,
        "poissons_ratio": constants.poissons_ratio,
        "frequency_hz": drive.frequency,
        "across_flats_mm": packing.across_flats * 1e3,
        "depth_mm": packing.depth * 1e3,
        "particle_mass_per_area_kg_m2": mass,
        "equivalent_damping_n_s_m3": row["equivalent_damping_n_s_m3"],
        "equivalent_damping_error_n_s_m3": row["equivalent_damping_error_n_s_m3"],
        "apparent_mass_kg_m2": row["apparent_mass_kg_m2"],
        "apparent_mass_error_kg_m2": row["apparent_mass_error_kg_m2"],
        "liggghts_version": LIGGGHTS_VERSION,
        "pidpanel_version": version("pidpanel"),
    }


def _check_groups(case: Case) -> None:
    """Refuse a case that differs in more than its groups."""
    packing, constants = case.point.packing, case.point.constants
    faults = {
        "cells must be hexagons": packing.shape != "hexagon",
        "particles must have one size": packing.sizes.kind != "mono",
        "there must be no rolling friction": constants.has_rolling_friction,
        "walls must have the constants of the particles": constants
        != Constants.alike(
            constants.youngs_modulus,
            constants.poissons_ratio,
            constants.restitution,
            constants.friction,
        ),
    }
    for says, is_wrong in faults.items():
        if is_wrong:
            raise ValueError(f"{case.label}: {says}")


def _direction(bed: Bed) -> Direction:
    """Return the direction of gravity by its name in the groups."""
    size, along = bed.gravity / STANDARD_GRAVITY, bed.gravity_direction[2]
    if size == 0:
        return "none"
    if math.isclose(size, 1) and along == -1:
        return "flat"
    if math.isclose(size, 1) and along == 0:
        return "upright"
    raise ValueError(f"gravity of {size:g} g along {bed.gravity_direction} is not in the atlas")


def _listed(values: object) -> list[str]:
    """Return the values that a cell lists; none of an empty one."""
    return [] if values != values or values is None else str(values).split()
