"""The table of the atlas, and the constants of the processes that are fitted to it."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.atlas import table
from pidpanel.damping.atlas import (
    JUMP_LENGTHS,
    Atlas,
    AtlasBed,
    atlas_bed,
    dimensional,
    dimensionless,
)
from pidpanel.damping.surface_cases import Constants, TrainingData, clear_gap, training_data
from pidpanel.paths import ATLAS_CASES, ATLAS_CONSTANTS

# Scales of the coordinates of `atlas.AtlasBed.points`, near their standard deviations in the atlas.
SPREAD = np.array([0.26, 1.8, 3.5, 1.2, 1.0, 0.46, 1.0, 0.5, 2.1])

ARRAYS = ("calibration", "student_scale", "bulk")  # of the file of the constants
UNKNOWN_MASS = 1.0  # error of m_a over the mass of the particles in one of several states


@cache
def read_atlas(cases: Path = ATLAS_CASES, constants: Path = ATLAS_CONSTANTS) -> Atlas:
    """Read the atlas that comes with pidpanel, or another one of the same form."""
    return _atlas(read_rows(cases), constants)


def extended_atlas(bed: AtlasBed, cases: pd.DataFrame, mass_per_fill: float) -> Atlas:
    """Return the atlas with further cases of a bed, in the columns of `surface_cases.counted`.

    Its processes, given these cases, are those of a surface whose prior is the atlas.
    """
    log_loss, log_friction, log_width, log_depth, across = bed.shape[0]
    rows = dimensionless(cases, bed.depth, bed.gravity, mass_per_fill).assign(
        restitution=np.sqrt(-np.expm1(log_loss)),
        friction=np.exp(log_friction),
        width_per_diameter=np.exp(log_width),
        depth_per_diameter=np.exp(log_depth),
        direction=np.sqrt(across),
        state_loss_factors="",
        is_of_atlas=False,
    )
    return _atlas(pd.concat([read_rows(ATLAS_CASES), rows], ignore_index=True), ATLAS_CONSTANTS)


def _atlas(frame: pd.DataFrame, constants: Path) -> Atlas:
    stored = json.loads(constants.read_text(encoding="utf-8"))
    trend = np.array(stored["trend"])
    data = atlas_data(by_state(frame), trend)
    damping = data.damping_sides(stored_sides(stored["damping"]))
    mass, jump = data.mass_sides(stored_sides(stored["mass"])), data.jump(JUMP_LENGTHS)
    calibration, scale, bulk = map(np.array, (stored[name] for name in ARRAYS))
    version = stored["version"]
    return Atlas(frame, damping, mass, jump, calibration, scale, bulk, trend, version)


def version_text(atlas: Atlas, cases: Path = ATLAS_CASES) -> str:
    """Return version and cases of an atlas: those of the table, and those that teach damping."""
    count = len(table.read_atlas(cases))
    text = f"version {atlas.version}, {count} simulated cases"
    return f"{text}, {len(atlas.cases)} of them with gravity and a loss above its error"


def read_rows(path: Path) -> pd.DataFrame:
    """Read the cases, with W/L in the clear gap of `surface_cases.clear_gap`.

    Rows are used if they have gravity, η larger than its error and Γ above the onset.
    """
    frame = table.read_atlas(path)
    fill, gamma = frame["fill_fraction"], frame["gamma"]
    counts = (
        (frame["loss_factor"] > frame["loss_factor_error"])
        & (frame["direction"] != "none")
        & ((gamma > 1) | (frame["direction"] != "flat"))
    )
    stroke = frame["stroke_per_gap"] * (1 - fill) / clear_gap(fill.to_numpy(float))
    return frame.assign(stroke_per_gap=stroke, is_of_atlas=True)[counts].reset_index(drop=True)


def by_state(cases: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each state of motion of the cases; m_a of one of several is not known."""
    several = cases["state_loss_factors"] != ""
    losses = cases["state_loss_factors"][several].str.split().explode().astype(float)
    states = cases.loc[losses.index]
    relative = states["loss_factor_statistical_error"] / states["loss_factor"]
    states = states.assign(
        loss_factor=losses, loss_factor_error=relative * losses, mass_ratio_error=UNKNOWN_MASS
    )
    return pd.concat([cases[~several], states], ignore_index=True)


def atlas_data(cases: pd.DataFrame, trend: Array | None = None) -> TrainingData:
    """Return what the cases of the atlas teach, with m₁ = 1 and the trend of beds that ride."""
    names = ["restitution", "friction", "width_per_diameter", "depth_per_diameter"]
    restitution, friction, width, depth = cases[names].to_numpy(float).T
    bed = atlas_bed(restitution, friction, width, depth, 1.0, cases["direction"].tolist())
    bed = replace(bed, trend=trend)
    outliers = cases["is_of_atlas"].to_numpy(bool)
    return replace(training_data(dimensional(cases, depth), bed), spread=SPREAD, outliers=outliers)


def stored_sides(stored: Any) -> Constants:
    """Return lengths, size and scatter of the processes of both sides."""
    return np.array(stored["riding"]), np.array(stored["crossing"])
