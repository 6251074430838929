"""Standard errors of C_e and m_a carried through to PSDs and rms values.

The damper acts line by line, so what a change of C_e or m_a does to the PSD at a frequency is that
of s = iω C_e − ω² m_a there, δS_a = −2 Re(δs t) with t of `dampers.acceleration_slope`:

    A(f) = ∂ ln S_a/∂ ln C_e = 2ω C_e Im t/S_a,      B(f) = ∂ ln S_a/∂ m_a = 2ω² Re t/S_a

at a given Γ.

Where Γ is the patch's own, a change of its motion moves Γ too. With a change b of C_e or m_a that
alters ln a_rms of the patch by q_b at given Γ, and Γ_out(Γ) the motion that a Γ leads to,

    d ln Γ = q_b/(1 − d ln Γ_out/d ln Γ),
    d ln S_a = A δ ln C_e + B δ m_a + (A ∂ ln C_e/∂ ln Γ + B ∂ m_a/∂ ln Γ) d ln Γ.

Changes are given at nodes of frequency and linear in ln f between them, so a covariance over the
nodes becomes that of every line: first order in the errors, which near the jump of C_e are not
small.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from pidpanel.arrays import Array, Complexes
from pidpanel.response.linearisation import sine_acceleration_g
from pidpanel.response.scenarios import DampingOfMotion, DiagonalSolver, ScenarioResponse, Solver

STEP = 0.05
"""ε, of ln Γ: central differences are then good to ε²/6 of a derivative's own scale."""


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives with respect to ln C_e at the nodes, then m_a [kg/m²] at the nodes.

    Attributes
    ----------
    log_psd
        (2n, nf, n_points) of ln S_a.
    log_rms
        (2n, n_points) of ln of the rms acceleration.
    log_acceleration
        (2n,) of ln Γ; 0 where Γ is stated or plays no part.
    """

    log_psd: Array
    log_rms: Array
    log_acceleration: Array

    def under(self, covariance: Array) -> StandardErrors:
        """Return the standard errors for a covariance (2n, 2n) of C_e and m_a at the nodes."""
        psd, rms, gamma = (
            _standard_error(of, covariance)
            for of in (self.log_psd, self.log_rms, self.log_acceleration)
        )
        return StandardErrors(psd, rms, float(gamma))


@dataclass(frozen=True)
class StandardErrors:
    """Of the logarithms of what a scenario answers.

    Attributes
    ----------
    log_psd
        (nf, n_points) of ln S_a.
    log_rms
        (n_points,) of ln of the rms acceleration: its relative standard error.
    log_acceleration
        Of ln Γ.
    """

    log_psd: Array
    log_rms: Array
    log_acceleration: float


def _standard_error(derivative: Array, covariance: Array) -> Array:
    variance = np.einsum("i...,ij,j...->...", derivative, covariance, derivative, optimize=True)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def sensitivity(
    solver: Solver | DiagonalSolver,
    damping: DampingOfMotion,
    found: ScenarioResponse,
    nodes: Array,
    pressure_factor: float,
    *,
    own_acceleration: bool,
) -> Sensitivity:
    """Return how a scenario's response follows its damping.

    Parameters
    ----------
    solver, damping
        As in `scenarios.solve_scenario`.
    found
        Its answer.
    nodes
        (n,) rising [Hz].
    pressure_factor
        As in `scenarios.solve_scenario`.
    own_acceleration
        Whether Γ is the patch's own, which moves with the damping.
    """
    value, mass = found.equivalent_damping, found.apparent_mass
    psd = found.response.acceleration_psd
    of_damping, of_mass = _local(
        pressure_factor * solver.slope(value, mass), psd, solver.frequency, value
    )
    by_node = _hats(solver.frequency, nodes)
    # Γ held
    rows = np.concatenate(
        [by_node[..., None] * of_damping, by_node[..., None] * of_mass]
    )  # (2n, nf, points)
    log_acceleration = np.zeros(2 * len(nodes))
    if own_acceleration:
        gamma, lines = found.acceleration_g, solver.motion.frequency
        read, read_mass, _ = damping(lines, gamma)
        patch_psd = solver.motion.acceleration_psd(read, read_mass)
        slope = solver.motion.acceleration_slope(read, read_mass)
        local = _local(slope[:, None], patch_psd[:, None], lines, read)
        hats = _hats(lines, nodes)
        pushed = np.concatenate([hats * one[:, 0] for one in local])
        own = _log_rms(lines, patch_psd, pushed)
        log_acceleration = own / (1 - _motion_slope(solver, damping, gamma))
        high, high_mass, _ = damping(solver.frequency, gamma * np.exp(STEP))
        low, low_mass, _ = damping(solver.frequency, gamma * np.exp(-STEP))
        ratio = np.divide(high, low, out=np.ones_like(low), where=low > 0)
        with_motion = (np.log(ratio) / (2 * STEP))[:, None] * of_damping
        with_motion = with_motion + ((high_mass - low_mass) / (2 * STEP))[:, None] * of_mass
        rows = rows + log_acceleration[:, None, None] * with_motion
    return Sensitivity(rows, _log_rms(solver.frequency, psd, rows), log_acceleration)


def _local(slope: Complexes, psd: Array, frequency: Array, damping: Array) -> tuple[Array, Array]:
    """A and B (nf, n) of PSDs (nf, n) with the slopes t."""
    omega = 2 * np.pi * frequency[:, None]
    of_damping = 2 * omega * damping[:, None] * slope.imag / psd
    of_mass = 2 * omega**2 * slope.real / psd
    return of_damping, of_mass


def _motion_slope(solver: Solver | DiagonalSolver, damping: DampingOfMotion, gamma: float) -> float:
    """d ln Γ_out/d ln Γ."""

    def log_out(at: float) -> float:
        value, mass, _ = damping(solver.motion.frequency, at)
        return float(np.log(sine_acceleration_g(solver.motion.acceleration_rms(value, mass))))

    return (log_out(gamma * np.exp(STEP)) - log_out(gamma * np.exp(-STEP))) / (2 * STEP)


def _hats(frequency: Array, nodes: Array) -> Array:
    """(n, nf) the piecewise linear functions of ln f that are 1 at one node and 0 at the others."""
    x, at = np.log(frequency), np.log(nodes)
    return np.stack([np.interp(x, at, one) for one in np.eye(len(nodes))])


def _log_rms(frequency: Array, psd: Array, log_psd: Array) -> Array:
    """Change of the ln of an rms value (k, …) from that of ln of its PSD (k, nf, …)."""
    whole = np.trapezoid(psd, frequency, axis=0)
    return np.asarray(np.trapezoid(psd * log_psd, frequency, axis=1) / (2 * whole))


def with_errors(
    dataset: xr.Dataset, errors: Mapping[tuple[str, str], StandardErrors]
) -> xr.Dataset:
    """Return the dataset of `tables.psd_dataset` with ``acceleration_psd_log_error``.

    NaN where a scenario's damping has no standard error.
    """
    like = dataset["acceleration_psd"]
    values = xr.full_like(like, np.nan)
    for (reading, label), one in errors.items():
        values.loc[{"reading": reading, "scenario": label}] = one.log_psd
    attrs = {"units": "1", "long_name": "standard error of ln of the acceleration PSD"}
    return dataset.assign(acceleration_psd_log_error=values.assign_attrs(attrs))


def error_columns(
    rows: Sequence[dict[str, float]], errors: StandardErrors | None
) -> list[dict[str, float]]:
    """Return rows of `tables.summary_rows`, a point each, with the standard errors of their values.

    ``acceleration_rms_error_g``, ``reduction_error_db`` and ``damping_read_at_error_g``; NaN
    where there are none.
    """
    count = len(rows)
    relative = np.full(count, np.nan) if errors is None else errors.log_rms
    log_acceleration = np.nan if errors is None else errors.log_acceleration
    return [
        {
            **row,
            "acceleration_rms_error_g": row["acceleration_rms_g"] * own,
            "reduction_error_db": 20 / np.log(10) * own,
            "damping_read_at_error_g": row["damping_read_at_g"] * log_acceleration,
        }
        for row, own in zip(rows, relative, strict=True)
    ]
