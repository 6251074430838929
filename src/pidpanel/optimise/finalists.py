"""The best layouts at their consistent motion: errors and dead weight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.readings import DampingReading
from pidpanel.panel.plate_files import StoredPlate
from pidpanel.panel.shapes import residual_vectors
from pidpanel.response.cases import ResponseScenario, SolvedCase
from pidpanel.response.dampers import DampingModels, PatchFilling
from pidpanel.response.model_error import model_error_of, with_model_error
from pidpanel.response.panel import ResponsePanel, widen
from pidpanel.response.refinement import checked_responses
from pidpanel.response.results import standard_errors
from pidpanel.solve.basis_error import basis_shapes
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.model import PanelResponse, ResponseError

STATIC_TOLERANCE = 1e-2
"""Share of the largest static response to a patch below which a direction is left out."""


@dataclass(frozen=True)
class Finalist:
    """A layout at its consistent motion.

    Attributes
    ----------
    response, bare, dead_weight
        With the dampers, without them, and with their mass alone.
    log_rms_error
        (n_points,) standard error of ln of the rms acceleration; 0 where none is known.
    acceleration_g
        (n_loads,) Γ of each patch; NaN for a damper that does not depend on it.
    basis_error
        Largest relative error of a PSD [1].
    """

    response: PanelResponse
    bare: PanelResponse
    dead_weight: PanelResponse
    log_rms_error: Array
    acceleration_g: Array
    basis_error: float


def confirm(
    panel: ResponsePanel,
    plate: StoredPlate,
    layouts: Sequence[Sequence[PatchFilling]],
    models: Mapping[str, DampingReading],
) -> list[Finalist]:
    """Return layouts at their consistent motion, in a basis that is checked with them.

    Parameters
    ----------
    panel, plate
        With the places of the layouts as patches.
    models
        Damping models by the names of the dampers.

    Raises
    ------
    ResponseError
        Where a damper feeds energy to the panel.
    """
    scenarios = [_scenario(str(index), fillings) for index, fillings in enumerate(layouts)]
    stated = DampingModels(("stated",), {}, models)
    checked = checked_responses(*with_static_shapes(panel, plate), scenarios, stated)
    return [
        _finalist(case, error)
        for case, error in zip(checked.cases, checked.basis_error.tolist(), strict=True)
    ]


def with_static_shapes(
    panel: ResponsePanel, plate: StoredPlate
) -> tuple[ResponsePanel, StoredPlate]:
    """Return a panel and its plate with the static response to its patches in the basis."""
    modes = plate.shapes[:, ~panel.basis.is_residual].astype(np.float64)
    _, static = residual_vectors(plate, modes, STATIC_TOLERANCE)
    shapes = basis_shapes(panel.basis, plate, static).vectors
    return widen(panel, plate, static), replace(plate, shapes=shapes)


def _scenario(label: str, fillings: Sequence[PatchFilling]) -> ResponseScenario:
    return ResponseScenario(label, "bare", np.nan, 1.0, tuple(fillings), None, np.nan)


def _finalist(case: SolvedCase, basis_error: float) -> Finalist:
    response = _steady(case.response)
    errors = with_model_error(standard_errors(case, response), model_error_of(case, response))
    after, bare = response.response, case.bare.response
    dead = bare if case.dead_weight is None else case.dead_weight.response
    return Finalist(
        after,
        bare,
        dead,
        np.zeros(after.acceleration_rms.shape) if errors is None else errors.log_rms,
        response.acceleration_g,
        basis_error,
    )


def _steady(response: LayoutResponse | ResponseError) -> LayoutResponse:
    if isinstance(response, ResponseError):
        raise response
    return response
