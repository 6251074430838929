"""Motions of patches whose coupons are driven at random, and those at which a bed agrees with them.

With what records have told of C_e and m_a the panel answers with a motion (`solve`). How C_e and
m_a change with the motion is told beforehand by the inelastic body (`damping.thrown_bed`), so that
the next motion to drive is the one that reproduces itself (`agreeing`): the step of Newton's method
with the slope of a closed form.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.from_study import reading_of_damper
from pidpanel.damping.random_reading import RandomReading
from pidpanel.response.from_study import PanelInSound, Readings, SolvedScenario
from pidpanel.response.linearisation import LinearisationError
from pidpanel.response.model import UnstableDamping
from pidpanel.response.results import standard_errors
from pidpanel.response.scenarios import ScenarioResponse, Solver, read_dampers
from pidpanel.response.search import iterate
from pidpanel.study import Study
from pidpanel.study.damping import RANDOM

Key = tuple[str, str]
"""Scenario and patch."""

Expected = Callable[[float], RandomReading]
"""Rms velocity of a patch [m/s] → C_e and m_a."""

STILL = 1e-6
"""Velocity that is none [m/s]."""

AGREES, MOST_STEPS = 1e-3, 60
"""Of ln of the velocity, and steps of the search; what it finds is a motion to drive, and how far
the panel's answer is from it is seen then."""


@dataclass(frozen=True)
class Solved:
    """What a scenario does with its coupons as they were driven.

    Attributes
    ----------
    motions
        By patch, frequencies (nf,) [Hz] and mean PSD of its acceleration [(m/s²)²/Hz].
    rms_g
        Of points and patches [g].
    relative_error, of_packings
        Largest standard error of the rms acceleration of a point, and the part of it that more
        time does not reduce [1]; None without errors.
    """

    motions: Mapping[str, tuple[Array, Array]]
    rms_g: dict[str, float]
    relative_error: float | None
    of_packings: float | None


def solve(
    study: Study, panel: PanelInSound, readings: Mapping[Key, RandomReading]
) -> dict[str, Solved]:
    """Return what every scenario with a coupon does, by its label.

    Parameters
    ----------
    study, panel
        The study, and its panel in the sound.
    readings
        Of every coupon.
    """
    solver = panel.solver(rms_only=True)
    return {
        label: _solved(panel, solver, case)
        for label, case in _cases(study, panel, solver, readings).items()
    }


def agreeing(
    study: Study,
    panel: PanelInSound,
    expected: Mapping[Key, Expected],
    start: Mapping[Key, float],
) -> dict[str, Solved]:
    """Return what some scenarios do where their motion is that of which their damping is expected.

    Parameters
    ----------
    study, panel
        The study, and its panel in the sound.
    expected
        Of every coupon of the scenarios that are wanted.
    start
        Velocities near which that motion is looked for [m/s].
    """
    solver = panel.solver(rms_only=True)
    there = {key: reading(start[key]) for key, reading in expected.items()}
    readings: dict[Key, RandomReading] = {}
    for label, case in _cases(study, panel, solver, there).items():
        own = [key for key in expected if key[0] == label]
        velocity = _agreeing_velocity(panel, solver, case, own, expected, start)
        readings |= {key: expected[key](v) for key, v in zip(own, velocity, strict=True)}
    return solve(study, panel, readings)


def rms_velocity(motion: tuple[Array, Array]) -> float:
    """Return the rms velocity [m/s] of a motion: (nf,) [Hz] and its PSD [(m/s²)²/Hz]."""
    frequency, psd = motion
    return math.sqrt(float(np.trapezoid(psd / (2 * np.pi * frequency) ** 2, frequency)))


def _cases(
    study: Study, panel: PanelInSound, solver: Solver, readings: Mapping[Key, RandomReading]
) -> dict[str, SolvedScenario]:
    """The scenarios of these readings, by their labels."""
    # with both readings the motion is that of `random`, which coupled runs bear out further
    name = RANDOM["random" not in study.readings]
    dampers = {
        damper: reading_of_damper(study.all_dampers[damper], None)
        for damper in study.used_dampers
        if study.all_dampers[damper].coupon is None
    }
    if not study.response.damper_mass:
        dampers = {damper: reading.without_mass() for damper, reading in dampers.items()}
        readings = {key: reading.without_mass() for key, reading in readings.items()}
    of_all = Readings([name], {}, dampers, readings)
    wanted = {scenario for scenario, _ in readings}
    return {
        case.scenario.label: case
        for case in panel.responses(solver, of_all, dead_weight=False, only=wanted)
    }


def _agreeing_velocity(
    panel: PanelInSound,
    solver: Solver,
    case: SolvedScenario,
    own: Sequence[Key],
    expected: Mapping[Key, Expected],
    start: Mapping[Key, float],
) -> list[float]:
    """Rms velocity [m/s] of each patch of a scenario at which its motion reproduces itself."""
    moved = _Moved(panel, solver, case)
    mass = panel.study.response.damper_mass

    def log_velocity(log_assumed: Array) -> Array:
        readings = {
            key[1]: expected[key](velocity)
            for key, velocity in zip(own, np.exp(log_assumed).tolist(), strict=True)
        }
        if not mass:
            readings = {patch: one.without_mass() for patch, one in readings.items()}
        motions = moved(readings)
        return np.log([max(rms_velocity(motions[patch]), STILL) for _, patch in own])

    log_start = np.log([max(start[key], STILL) for key in own])
    found, _ = iterate(log_velocity, log_start, AGREES, MOST_STEPS)
    velocities: list[float] = np.exp(found).tolist()
    return velocities


class _Moved:
    """Mean motion of every filled patch of a scenario, on the lines of the search."""

    def __init__(self, panel: PanelInSound, solver: Solver, case: SolvedScenario) -> None:
        found = _steady(case)
        self._names = [panel.basis.patch_names[one.patch] for one in case.filled]
        self._area = panel.load_area(found)
        self._factor = case.pressure_factor
        self._lines = solver.search_frequency
        self._motions = panel.with_source(solver, case.layout).motions(case.layout.patches)
        loads = case.layout.loads
        self._damping, self._mass, _ = read_dampers(loads, self._lines, found.acceleration_g)

    def __call__(
        self, readings: Mapping[str, RandomReading] | None = None
    ) -> dict[str, tuple[Array, Array]]:
        """Return the motions by patch, with other readings in place of some of its own."""
        damping, mass = self._damping.copy(), self._mass.copy()
        for patch, reading in (readings or {}).items():
            values = reading(self._lines, math.nan, math.nan)
            own = [name == patch for name in self._names]
            damping[own], mass[own] = values.equivalent_damping, values.apparent_mass
        psd = self._factor * self._motions.acceleration_psd(damping, mass)
        motions = {}
        for patch in dict.fromkeys(self._names):
            own = [name == patch for name in self._names]
            share = self._area[own] / self._area[own].sum()
            motions[patch] = (self._lines, np.asarray(share @ psd[own]))
        return motions


def _solved(panel: PanelInSound, solver: Solver, case: SolvedScenario) -> Solved:
    found = _steady(case)
    motions = _Moved(panel, solver, case)()
    points = found.response.acceleration_rms / STANDARD_GRAVITY
    rms = dict(zip(panel.basis.point_names, points.tolist(), strict=True))
    rms = {name: value for name, value in rms.items() if value > 0}  # not of points that are held
    for patch, (frequency, psd) in motions.items():
        rms[f"patch {patch}"] = float(np.sqrt(np.trapezoid(psd, frequency))) / STANDARD_GRAVITY
    error, of_packings = (_error(panel, one, found) for one in (case, _noiseless(case)))
    return Solved(motions, rms, error, of_packings)


def _steady(case: SolvedScenario) -> ScenarioResponse:
    if isinstance(case.found, UnstableDamping):
        raise LinearisationError(f"{case.scenario.label}: {case.found}")
    return case.found


def _error(panel: PanelInSound, case: SolvedScenario, found: ScenarioResponse) -> float | None:
    errors = standard_errors(panel, case, found)
    return None if errors is None else float(errors.log_rms.max())


def _noiseless(case: SolvedScenario) -> SolvedScenario:
    """The same scenario, only its packings known with an error."""
    filled = [
        replace(one, reading=one.reading.of_packings_alone)
        if isinstance(one.reading, RandomReading)
        else one
        for one in case.filled
    ]
    return replace(case, filled=filled)
