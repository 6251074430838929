"""Rows of the atlas: groups and dimensionless results of cases."""

import math

import pandas as pd
import pytest

from pidpanel.atlas.table import fields
from pidpanel.coupon.from_study import atlas_table, cases_of
from pidpanel.study.coupon import Coupon

VISCOELASTIC = {"value": 0.8, "at_m_s": 1.0, "law": "viscoelastic"}
SWEEP = {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [20]}


def result(case, **changes):
    """A row of ``coupon/cases.csv`` with round numbers."""
    values = {
        "case": case.label, "status": "ok", "particle_mass_per_area_kg_m2": 5.0,
        "equivalent_damping_n_s_m3": 1000.0, "equivalent_damping_error_n_s_m3": 50.0,
        "statistical_error_n_s_m3": 40.0, "apparent_mass_kg_m2": 2.0,
        "apparent_mass_error_kg_m2": 0.1, "loss_factor": 1000 / (5 * 200 * math.pi),
        "loss_factor_error": 50 / (5 * 200 * math.pi), "states": 1,
        "state_damping_n_s_m3": math.nan, "state_share": math.nan, "modulus_bias": 0.01,
        "bulk_fraction": 0.23, "spheres_per_cell": 30.0, "cells": 5, "seeds": 2,
        "cycles_used": 40, "closure": 0.01, "target_met": True,
    }  # fmt: skip
    return {**values, **changes}


def table(*, rows=({},), **coupon):
    (case,) = cases_of(Coupon.model_validate({"sweep": SWEEP, **coupon}))
    results = pd.DataFrame([result(case, **changes) for changes in rows])
    return atlas_table({case.label: case}, results, "a laboratory")


def test_a_row_has_the_groups_and_the_dimensionless_results():
    (row,) = table().to_dict("records")
    assert (row["width_per_diameter"], row["depth_per_diameter"]) == (3.175, 12.5)
    assert row["stroke_per_gap"] == pytest.approx(20 * 9.80665 / (200 * math.pi) ** 2 / 12.5e-3)
    assert row["loss_factor_statistical_error"] == pytest.approx(40 / (5 * 200 * math.pi))
    assert (row["mass_ratio"], row["mass_ratio_error"]) == (0.4, 0.02)
    assert row["direction"] == "flat"
    # a wall's contact at ωW = 0.312 m/s, with the modulus of the run
    assert row["hardness"] == pytest.approx(
        1190 * (20 * 9.80665 / (200 * math.pi)) ** 2 / (1e6 * row["youngs_modulus_mpa"])
    )
    assert list(row) == [field["name"] for field in fields()]


def test_states_are_listed_as_loss_factors():
    several = {"states": 2, "state_damping_n_s_m3": "500 1500", "state_share": "0.5 0.5"}
    (row,) = table(rows=[several]).to_dict("records")
    low, high = map(float, row["state_loss_factors"].split())
    assert (low, high) == pytest.approx((500 / (1000 * math.pi), 1500 / (1000 * math.pi)), rel=1e-3)
    assert row["state_shares"] == "0.5 0.5"


def test_cases_that_failed_are_left_out():
    assert len(table(rows=[{}, {"status": "NotSteady"}, {"status": "RunHung"}])) == 2


@pytest.mark.parametrize(
    ("gravity", "direction", "name"),
    [(1, [0, 0, -1], "flat"), (1, [3, 0, 0], "upright"), (1, [0, 1, 0], "upright"), (0, [0, 0, -1], "none")],
)  # fmt: skip
def test_gravity_has_its_name(gravity, direction, name):
    (row,) = table(gravity_g=gravity, gravity_direction=direction).to_dict("records")
    assert row["direction"] == name


def test_walls_of_glass_that_is_not_softened_are_those_of_the_particles():
    glass = {"youngs_modulus_mpa": 65_000, "poissons_ratio": 0.22}
    sweep = {**SWEEP, "frequency_hz": [6000]}
    (row,) = table(sweep=sweep, particles=glass).to_dict("records")
    assert row["youngs_modulus_mpa"] == 65_000


@pytest.mark.parametrize(
    ("coupon", "message"),
    [
        ({"cell": {"shape": "square"}}, "cells must be hexagons"),
        ({"particles": {"rolling_friction": 0.1}}, "no rolling friction"),
        ({"walls": {"friction": 0.1}}, "walls must have the constants of the particles"),
        ({"particles": {"distribution": {"kind": "uniform", "half_width_mm": 0.2}}}, "one size"),
        ({"gravity_g": 0.5}, "gravity of 0.5 g"),
        ({"particles": {"restitution": VISCOELASTIC}}, "restitution must not depend on the speed"),
    ],
)
def test_a_case_that_the_groups_do_not_describe_is_refused(coupon, message):
    with pytest.raises(ValueError, match=message):
        table(**coupon)
