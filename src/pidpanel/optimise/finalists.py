"""The best layouts at their consistent motion: errors and dead weight."""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import residual_vectors
from pidpanel.response.cases import SolvedCase, steady
from pidpanel.response.model_error import model_error_of, with_model_error
from pidpanel.response.results import standard_errors
from pidpanel.solve.model import PanelResponse

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


def static_shapes(basis: PanelBasis, plate: StoredPlate) -> Array:
    """Return the static response (n_free, k) to the patches."""
    modes = plate.shapes[:, ~basis.is_residual].astype(np.float64)
    return residual_vectors(plate, modes, STATIC_TOLERANCE)[1]


def finalist(case: SolvedCase, basis_error: float) -> Finalist:
    """Return a layout from its case."""
    response = steady(case.response)
    errors = with_model_error(standard_errors(case, response), model_error_of(case, response))
    after, bare = response.response, case.bare.response
    dead = bare if case.dead_weight is None else case.dead_weight.response
    log_rms = np.zeros(after.acceleration_rms.shape) if errors is None else errors.log_rms
    return Finalist(after, bare, dead, log_rms, response.acceleration_g, basis_error)
