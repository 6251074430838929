"""Errors of damping models under broadband motion, in what the response answers."""

from __future__ import annotations

import numpy as np

from pidpanel.damping.broadband import BroadbandError
from pidpanel.response.cases import SolvedCase
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.uncertainty import StandardErrors


def model_error_of(case: SolvedCase, response: LayoutResponse) -> StandardErrors | None:
    """Return the errors that the damping models of a case have under broadband motion.

    A share of the effect of damping, |ln S₀/S| of PSDs and |ln g₀/g| of rms accelerations, and a
    part that does not depend on it; see `damping.broadband`. S₀ is with the same mass and no
    damping, or of the bare panel where the mass is not known. None where there is no such error.
    """
    errors = [damper.model.broadband_error for damper in case.dampers]
    largest = BroadbandError(*np.max([*errors, BroadbandError(0.0, 0.0)], axis=0))
    if not any(largest):
        return None
    undamped = (case.dead_weight or case.bare).response
    damped = response.response
    psds = undamped.acceleration_psd, damped.acceleration_psd
    rms = undamped.acceleration_rms, damped.acceleration_rms
    (effect_psd, effect_rms) = (
        np.abs(np.log(np.divide(a, b, out=np.ones_like(a), where=(a > 0) & (b > 0))))
        for a, b in (psds, rms)
    )
    return StandardErrors(
        log_psd=np.hypot(largest.of_effect * effect_psd, 2 * largest.of_rms),
        log_rms=np.hypot(largest.of_effect * effect_rms, largest.of_rms),
        log_acceleration=np.zeros(len(case.dampers)),
    )


def with_model_error(
    errors: StandardErrors | None, model: StandardErrors | None
) -> StandardErrors | None:
    """Return both errors together, which are independent."""
    if errors is None or model is None:
        return errors or model
    return StandardErrors(
        log_psd=np.hypot(errors.log_psd, model.log_psd),
        log_rms=np.hypot(errors.log_rms, model.log_rms),
        log_acceleration=errors.log_acceleration,
    )


def decibels(errors: StandardErrors, point: int) -> float:
    """Return the standard error of an rms acceleration [dB]."""
    return float(20 / np.log(10) * errors.log_rms[point])
