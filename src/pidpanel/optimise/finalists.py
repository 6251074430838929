"""The best layouts at their consistent motion: errors and dead weight."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.base.basis_check import checked_panel
from pidpanel.damping.readings import DampingReading
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import residual_vectors
from pidpanel.response.cases import ResponseScenario, SolvedCase, plan_cases
from pidpanel.response.dampers import DampingModels, PatchFilling
from pidpanel.response.model_error import model_error_of, with_model_error
from pidpanel.response.panel import ExcitationSource, ResponsePanel, widen
from pidpanel.response.refinement import checked_responses
from pidpanel.response.results import standard_errors
from pidpanel.solve.basis_error import basis_shapes
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.model import PanelResponse, ResponseError
from pidpanel.solve.supports import SupportedPanel

# Share of the largest static response to a patch below which a direction is left out
STATIC_TOLERANCE = 1e-2


@dataclass(frozen=True)
class Finalist:
    """A layout at its consistent motion."""

    # With the dampers, without them, and with their mass alone
    response: PanelResponse
    bare: PanelResponse
    dead_weight: PanelResponse
    # (n_points,) standard error of ln of the rms acceleration; 0 where none is known
    log_rms_error: Array
    acceleration_g: Array  # (n_loads,) Γ of each patch; NaN for a damper that does not depend on it
    basis_error: float  # largest relative error of a PSD [1]


def confirm(
    panel: ResponsePanel,
    plate: StoredPlate,
    layouts: Sequence[Sequence[PatchFilling]],
    models: Mapping[str, DampingReading],
    source: ExcitationSource,
) -> list[Finalist]:
    """Return layouts at their consistent motion under sound, in a basis checked with them.

    Panel and plate have the places of the layouts as patches. A `ResponseError` says that a damper
    feeds energy to the panel.
    """
    static = _static_shapes(panel.basis, plate)
    wider = widen(panel, plate, static, source)
    plate = replace(plate, shapes=basis_shapes(panel.basis, plate, static).vectors)
    checked = checked_responses(wider, plate, *_scenarios(layouts, models), source)
    return [
        _finalist(case, error)
        for case, error in zip(checked.cases, checked.basis_error.tolist(), strict=True)
    ]


def confirm_on_shaker(
    basis: PanelBasis,
    plate: StoredPlate,
    layouts: Sequence[Sequence[PatchFilling]],
    models: Mapping[str, DampingReading],
    shaken: Callable[[SupportedPanel, Sequence[ResponseScenario], DampingModels], ResponsePanel],
    highest: float,
    mass: float,
) -> list[Finalist]:
    """Return layouts at their consistent motion on moving supports; see `confirm`.

    ``shaken`` puts the panel on its supports under the motion; for ``highest`` and ``mass`` see
    `base.basis_check.checked_panel`.
    """
    scenarios, stated = _scenarios(layouts, models)
    supported, error = checked_panel(
        basis, plate, _static_shapes(basis, plate), highest, mass,
        lambda supported: [shaken(supported, scenarios, stated)], scenarios, stated,
    )  # fmt: skip
    panel = shaken(supported, scenarios, stated)
    cases = plan_cases(panel, scenarios, stated).solve(panel.solver())
    return [_finalist(case, error) for case in cases]


def _static_shapes(basis: PanelBasis, plate: StoredPlate) -> Array:
    """Return the static response (n_free, k) to the patches."""
    modes = plate.shapes[:, ~basis.is_residual].astype(np.float64)
    return residual_vectors(plate, modes, STATIC_TOLERANCE)[1]


def _scenarios(
    layouts: Sequence[Sequence[PatchFilling]], models: Mapping[str, DampingReading]
) -> tuple[list[ResponseScenario], DampingModels]:
    """Return a scenario for each layout, and the models of their dampers."""
    scenarios = [
        ResponseScenario(str(index), "bare", np.nan, 1.0, tuple(fillings), None, np.nan)
        for index, fillings in enumerate(layouts)
    ]
    return scenarios, DampingModels(("stated",), {}, models)


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
