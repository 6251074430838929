"""The basis against all elements under base motion, and a basis that misses less.

As under sound (`solve.basis_error`), with the force of base motion: per acceleration of the
supports it is −M 1 on the panel and s_p/ω² ∫_p φ dA of each damper. The error is the largest
difference of the PSD of the absolute acceleration of a point, over the largest PSD of any point at
that frequency: a point that is nearly at rest there has none of its own.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.response.cases import ResponseScenario, plan_cases
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.refinement import stiffness_on_patches
from pidpanel.solve.base_motion import (
    UNIT,
    SupportedPanel,
    Translation,
    integrals_of_shapes,
    supported_panel,
)
from pidpanel.solve.basis_error import (
    BasisCheck,
    ErrorsAt,
    check_basis,
    lines_to_try,
    sufficient_basis,
)
from pidpanel.solve.elements import ElementMotion
from pidpanel.solve.layout import LayoutResponse

# A panel in some basis → the panel under each motion of a study
Shaken = Callable[[SupportedPanel], Sequence[ResponsePanel]]


def checked_panel(
    start: PanelBasis,
    plate: StoredPlate,
    further_shapes: Array,
    highest: float,
    mass: float,
    shaken: Shaken,
    scenarios: Sequence[ResponseScenario],
    translation: Translation = UNIT,
) -> tuple[SupportedPanel, float]:
    """Return the panel in a basis that is good for all motions, and its largest error [1].

    Parameters
    ----------
    start, plate, further_shapes, highest, mass, translation
        Same as in `supports.supported_panel`.
    shaken
        Function that returns the panel under each motion of the supports.
    scenarios
        Layouts of dampers.
    """

    def check(further: Array, attempt: int) -> tuple[SupportedPanel, list[BasisCheck]]:
        supported = supported_panel(start, plate, further, highest, mass, translation)
        panels = shaken(supported)
        return supported, [_check(panel, supported, plate, scenarios, attempt) for panel in panels]

    return sufficient_basis(further_shapes, check)


def _check(
    panel: ResponsePanel,
    supported: SupportedPanel,
    plate: StoredPlate,
    scenarios: Sequence[ResponseScenario],
    attempt: int,
) -> BasisCheck:
    """Return the check of all scenarios under one motion."""
    plan = plan_cases(panel, scenarios, dead_weight=False).response_alone()
    columns = len(plan.layouts) * len(panel.basis.point_names)
    span = panel.settings.frequency_range
    lines = lines_to_try(span, plate.stiffness.shape[0], columns, attempt)
    solver = panel.solver(rms_only=True).with_lines(lines, panel.deflection_at_points)
    answers = {id(case.response): case.response for case in plan.solve(solver)}.values()
    stiffness = [
        stiffness_on_patches(panel, item) for item in answers if isinstance(item, LayoutResponse)
    ]
    basis = supported.basis
    return check_basis(
        basis,
        plate,
        supported.vectors.astype(np.float32),
        base_errors(basis, plate, supported.vectors, supported.inertia.translation),
        panel.settings.damping_ratio,
        span[1],
        lines,
        np.array(stiffness),
    )


def base_errors(
    basis: PanelBasis, plate: StoredPlate, vectors: Array, translation: Translation = UNIT
) -> ErrorsAt:
    """Return the errors of the shapes ``vectors`` (n_free, n) under base motion."""
    integrals = integrals_of_shapes(basis, plate, translation)[:, :-1]
    everything = np.column_stack([plate.inertia, integrals])
    in_shapes = vectors.T @ everything

    def psds(point_motion: Complexes, omega: float, s: Complexes, loads: Array) -> Array:
        """Return PSDs (n_points,) of the absolute accelerations over that of the supports."""
        force = loads[:, 1:] @ s / omega**2 - loads[:, 0]
        return np.asarray(np.abs(translation.points - omega**2 * (point_motion.T @ force)) ** 2)

    def errors(frequency: float, stiffness: Complexes, motions: Sequence[ElementMotion]) -> Array:
        omega, pairs = 2 * np.pi * frequency, list(zip(stiffness, motions, strict=True))
        full = np.stack([psds(motion.whole, omega, s, everything) for s, motion in pairs])
        reduced = np.stack([psds(motion.of_basis, omega, s, in_shapes) for s, motion in pairs])
        return np.asarray((np.abs(reduced - full) / full.max(axis=1)[:, None]).max(axis=1))

    return errors
