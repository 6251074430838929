"""Errors of damping models under broadband motion, and of coupled runs, in the response."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.broadband import EXACT, BroadbandError
from pidpanel.provenance.results import read_csv
from pidpanel.response.cases import SolvedCase
from pidpanel.response.panel import ResponsePanel
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.model import PanelResponse
from pidpanel.solve.uncertainty import StandardErrors


def model_error_of(case: SolvedCase, response: LayoutResponse) -> StandardErrors | None:
    """Return the errors that the damping models of a case have under broadband motion.

    A share of the effect of damping, |ln S₀/S| of PSDs and |ln g₀/g| of rms accelerations, and a
    part that does not depend on it; see `damping.broadband`. S₀ is with the same mass and no
    damping, or of the bare panel where the mass is not known. None where there is no such error.
    """
    largest = broadband_error_of(case)
    if not any(largest):
        return None
    undamped, damped = undamped_response(case), response.response
    psd_error = BroadbandError(largest.of_effect, 2 * largest.of_rms)
    return StandardErrors(
        log_psd=log_error(psd_error, undamped.acceleration_psd, damped.acceleration_psd),
        log_rms=log_error(largest, undamped.acceleration_rms, damped.acceleration_rms),
        log_acceleration=np.zeros(len(case.dampers)),
    )


def broadband_error_of(case: SolvedCase) -> BroadbandError:
    """Return the largest error of the damping models of a case under broadband motion."""
    errors = [damper.model.broadband_error for damper in case.dampers]
    return BroadbandError(*np.max([*errors, EXACT], axis=0))


def undamped_response(case: SolvedCase) -> PanelResponse:
    """Return the response with the same mass and no damping; the bare one without that."""
    return (case.dead_weight or case.bare).response


def log_error(error: BroadbandError, undamped: Array, damped: Array) -> Array:
    """Return the standard error of ln of rms values [1] from those without damping."""
    moves = (undamped > 0) & (damped > 0)
    effect = np.log(np.divide(undamped, damped, out=np.ones_like(damped), where=moves))
    return np.hypot(error.of_effect * effect, error.of_rms)


def load_error_of(panel: ResponsePanel, response: PanelResponse) -> StandardErrors | None:
    """Return what the errors of the loads on modes leave in a response; None without them.

    A line has that of the nearest resonance.
    """
    if panel.load_error is None:
        return None
    natural = panel.basis.natural_frequency[~panel.basis.is_residual]
    nearest = np.searchsorted(np.sqrt(natural[:-1] * natural[1:]), panel.frequency)
    log_psd = np.repeat(panel.load_error[nearest][:, None], len(panel.basis.point_names), axis=1)
    parts = response.acceleration_psd * trapezoid_weights(panel.frequency)[:, None]
    total, by_mode = parts.sum(axis=0), np.zeros((natural.size, parts.shape[1]))
    np.add.at(by_mode, nearest, parts * log_psd)
    change = np.linalg.norm(by_mode, 1 + panel.has_independent_loads, axis=0)
    log_rms = np.divide(change, 2 * total, out=np.zeros_like(total), where=total > 0)
    return StandardErrors(log_psd, log_rms, np.zeros(1))


def with_model_error(
    errors: StandardErrors | None, model: StandardErrors | None
) -> StandardErrors | None:
    """Return both errors together, which are independent."""
    if errors is None or model is None:
        return errors or model
    log_psd = np.hypot(errors.log_psd, model.log_psd)
    log_rms = np.hypot(errors.log_rms, model.log_rms)
    log_acceleration = np.hypot(errors.log_acceleration, model.log_acceleration)
    return StandardErrors(log_psd, log_rms, log_acceleration)


def read_errors(folder: Path, frequency: Array, points: Sequence[str]) -> dict[str, StandardErrors]:
    """Return the errors of the coupled runs in a folder at the points, by scenario."""
    files = (folder / "summary.csv", folder / "psd.csv")
    summary, psd = (read_csv(path, dtype={"point": str}) for path in files)
    errors = {}
    for scenario, rows in summary.groupby("scenario", sort=False):
        at_points = rows.set_index("point").loc[list(points)]
        lines = psd[psd["scenario"] == scenario]
        by_point = [lines[lines["point"] == point] for point in points]
        log_psd = [
            np.interp(np.log(frequency), np.log(table["frequency_hz"]), table["error_db"])
            for table in by_point
        ]
        errors[str(scenario)] = StandardErrors(
            np.log(10) / 10 * np.stack(log_psd, axis=1),
            (at_points["g_rms_error"] / at_points["g_rms"]).to_numpy(float),
            np.array([np.nan]),
        )
    return errors
