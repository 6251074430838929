"""Columns of scenarios whose panel moves so far that it stretches."""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.panel.matrices import Stretching
from pidpanel.response.cases import SolvedCase
from pidpanel.solve.bands import reduction
from pidpanel.solve.layout import DamperLayout, LayoutResponse
from pidpanel.solve.search import LinearisationError
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.stretching import StretchedResponse, stretched_responses

# Rms displacement over the thickness above which linear plate theory does not hold.
LINEAR = 0.1

# Columns of `stretched_columns`.
COLUMNS = (
    "stretched_acceleration_rms_g", "stretched_acceleration_rms_error_g",
    "stretched_displacement_rms_mm", "stretched_displacement_rms_error_mm",
    "stretched_reduction_db", "frequency_shift_percent", "frequency_shift_error_percent",
)  # fmt: skip


class StretchedCases:
    """The stretched motion of all cases that need it, and of their bare panels."""

    def __init__(
        self,
        solver: PanelSolver,
        stretching: Stretching | None,
        cases: Sequence[SolvedCase],
        thickness: float,
    ) -> None:
        layouts: dict[Hashable, tuple[DamperLayout, Array]] = {}
        self._keys: dict[int, tuple[Hashable, Hashable]] = {}
        self._answers: dict[Hashable, StretchedResponse | LinearisationError] = {}
        if stretching is None:
            return
        for case in cases:
            response = case.response
            if not isinstance(response, LayoutResponse) or not any(
                (answer.response.displacement_rms > LINEAR * thickness).any()
                for answer in (response, case.bare)
            ):
                continue
            bare: Hashable = case.layout.factor
            key = case.scenario.label if case.dampers else bare
            layouts.setdefault(bare, (DamperLayout((), case.layout.factor), np.zeros(0)))
            layouts.setdefault(key, (case.layout, response.acceleration_g))
            self._keys[id(case)] = key, bare
        answers = stretched_responses(solver, stretching, list(layouts.values()))
        self._answers |= zip(layouts, answers, strict=True)

    def columns(
        self, case: SolvedCase, values: Mapping[str, Any], error: Array | float
    ) -> dict[str, Any]:
        """Return the columns of a case; NaN where the panel is linear or no answer is known.

        Parameters
        ----------
        values
            Its columns of `tables.summary_columns`.
        error
            (n_points,) relative standard error of the rms acceleration due to the damping.
        """
        empty = dict.fromkeys(COLUMNS, np.nan)
        answer, bare = (self._answers.get(key) for key in self._keys.get(id(case), (None, None)))
        if not isinstance(answer, StretchedResponse) or not isinstance(bare, StretchedResponse):
            return empty
        acceleration = values["acceleration_rms_g"] * answer.acceleration
        relative = np.hypot(answer.acceleration_error, np.nan_to_num(error))
        bare_rms = case.bare.response.acceleration_rms * bare.acceleration
        displacement = values["displacement_rms_mm"] * answer.displacement
        shown = (
            acceleration,
            acceleration * relative,
            displacement,
            displacement * answer.displacement_error,
            reduction(bare_rms, case.bare.response.acceleration_rms * answer.acceleration
                      * 10 ** (-values["reduction_db"] / 20)),
            100 * (answer.frequency - 1),
            100 * answer.frequency_error,
        )  # fmt: skip
        return dict(zip(COLUMNS, shown, strict=True))
