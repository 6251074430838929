"""Error of a response in modes from a file: what the modes beyond the last would add.

Nothing is known of a structure beyond its modes. The response in two thirds of them differs from
that in all by more than that in all differs from the truth, since what is left out falls with the
number of modes. Residual vectors of static cases make up for most of it: of their largest change of
g rms 5 % remained on a light shell, and up to 16 % on the coarse paraboloid of docs/structures.md.
"""

from dataclasses import replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.response.cases import CasePlan
from pidpanel.response.panel import ResponsePanel
from pidpanel.solve.model import ResponseError, UnstableDamping

# Error of g rms over its change between two thirds of the modes and all: above 1 on light shells
# under heavy dampers.
MARGIN, KEPT = 1.5, 2 / 3
REMAINING = 0.25  # share of the change by residual vectors that is stated
LARGEST = 0.10  # largest error of g rms that is stated
AT_REST = 1e9  # modal mass of a mode that does not move, over its own


def truncation_errors(panel: ResponsePanel, plan: CasePlan) -> Array:
    """Return the relative error of the PSD of a point of each case (n_cases,) [1].

    Raises
    ------
    ResponseError
        If g rms errs by more than `LARGEST`.
    """
    basis = panel.basis
    modes = np.flatnonzero(~basis.is_residual)
    dropped, margin = modes[int(np.ceil(KEPT * len(modes))) :], MARGIN
    if basis.is_residual.any():
        dropped, margin = np.flatnonzero(basis.is_residual), REMAINING
    mass = basis.modal_mass.copy()
    mass[dropped] *= AT_REST
    truncated = replace(panel, basis=replace(basis, modal_mass=mass)).solver(rms_only=True)
    quick, complete = plan.response_alone(), panel.solver(rms_only=True)
    motions = plan.search(complete)
    cases = list(zip(quick.solve(complete, motions), quick.solve(truncated, motions), strict=True))
    errors = np.zeros(len(cases))
    for index, (case, second) in enumerate(cases):
        responses = [
            answer.response.acceleration_rms
            for answer in (case.response, second.response)
            if not isinstance(answer, UnstableDamping)
        ]
        if len(responses) < 2:
            continue
        rms, remaining_rms = responses
        moving = rms > 0
        error = margin * float(np.max(np.abs(remaining_rms[moving] / rms[moving] - 1), initial=0.0))
        if error > LARGEST:
            last = basis.natural_frequency[modes[-1]]
            raise ResponseError(
                f"{case.scenario.label}: {len(modes)} modes to {last:.4g} Hz leave an error of"
                f" {error:.0%} of g rms, at most {LARGEST:.0%} is allowed; add modes, or static"
                " cases of the patches (structure.modes.static)"
            )
        errors[index] = 2 * error
    return errors
