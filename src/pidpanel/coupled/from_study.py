"""The coupled runs of a study, and what is found in them: the only module here that knows it."""

from __future__ import annotations

import math
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array, Complexes
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled import estimation, identification, integration, sound_record
from pidpanel.coupled.library import Spheres, load_library
from pidpanel.coupled.process import Progress, in_child
from pidpanel.coupled.record_files import read_record, write_record
from pidpanel.coupled.results import CoupledResult, coupled_result
from pidpanel.coupled.stations import Stations, stations_of
from pidpanel.coupon import coding, contact, geometry, preparation
from pidpanel.coupon.cases import Bed
from pidpanel.coupon.from_study import bed_of
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.failures import EnergyNotClosed, RunFailed
from pidpanel.coupon.records import LoosenOutcome
from pidpanel.panel.plate_files import StoredPlate, read_plate
from pidpanel.response.basis_error import joined_shapes
from pidpanel.response.from_study import PanelFiles, PanelInSound, read_panel_in_sound
from pidpanel.stamp import stamp
from pidpanel.study import Scenario, Study
from pidpanel.study.coupon import Coupon
from pidpanel.study.dampers import coupon_of

ROWS_PER_PERIOD = 10.0
"""Rows of a record in a period of the highest frequency: what is joined linearly between them is
known to 3 %, and corrected for it."""

BALANCE_LIMIT = 0.01
"""Largest share of the sound's energy that may be missing in a run [1]."""

FASTEST = 3.0
"""Speeds at which contacts are held to their limits, over the rms of the bare patch: a Gaussian
motion exceeds it for 0.3 % of the time."""

SILENCE_S, LIMIT_PER_ESTIMATE, LIMIT_AT_LEAST_S = 120.0, 20.0, 600.0
"""Longest silence of a run, and longest duration over what is estimated, on a machine that is
shared."""

STEP_S, SPHERE_STEP_S = 45e-6, 90e-9
"""CPU time of a step and of a sphere in it (16 cells, 752 spheres: 110 µs)."""


@dataclass(frozen=True)
class CoupledRun:
    """One scenario under one record of its sound.

    Attributes
    ----------
    scenario
        Which.
    seed
        Of the sound and the packings.
    beds
        Of its filled patches.
    """

    scenario: Scenario
    seed: int
    beds: tuple[Bed, ...]


def coupled_runs(study: Study) -> dict[str, CoupledRun]:
    """Return the runs of a study by their names, ``<scenario>/<seed>``."""
    if not study.is_coupled:
        return {}
    keys = study.damping.coupled
    return {
        f"{scenario.label}/{seed}": CoupledRun(
            scenario,
            seed,
            tuple(
                bed_of(_coupon(study, scenario, k), fill, cells=keys.cells, seed=seed)
                for k, fill in enumerate(_fills(scenario))
            ),
        )
        for scenario in study.all_scenarios()
        if not scenario.is_bare
        for seed in range(1, keys.seeds + 1)
    }


def _fills(scenario: Scenario) -> list[float]:
    return [float(filling.fill_fraction or math.nan) for filling in scenario.fillings]


def _coupon(study: Study, scenario: Scenario, patch: int) -> Coupon:
    return coupon_of(study.all_dampers, scenario.fillings[patch].damper)
