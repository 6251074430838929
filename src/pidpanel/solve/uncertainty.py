"""Standard errors of C_e and m_a carried through to PSDs and rms values.

The dampers act line by line, so what a change of C_e or m_a of load p does to the PSD at a
frequency is that of s = iω C_e − ω² m_a there, δS_a = −2 Re(δs t_p) with t_p of
`dampers.attach_dampers`:

    A_p(f) = ∂ ln S_a/∂ ln C_e = 2ω C_e Im t_p/S_a,      B_p(f) = ∂ ln S_a/∂ m_a = 2ω² Re t_p/S_a

at given Γ.

Where Γ is the patches' own, a change of their motion moves Γ too. With a change b of C_e or m_a
that alters ln a_rms of the patches by q_b at given Γ, Γ_out(Γ) the motions that the Γ of all loads
lead to, and J = ∂ ln Γ_out/∂ ln Γ,

    d ln Γ = (1 − J)⁻¹ q_b,
    d ln S_a = Σ_p A_p δ ln C_e + B_p δ m_a + (A_p ∂ ln C_e/∂ ln Γ_p + B_p ∂ m_a/∂ ln Γ_p) d ln Γ_p.

Changes are given at nodes of frequency and linear in ln f between them, so a covariance over the
nodes becomes that of every line: first order in the errors, which near the jump of C_e are not
small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.layout import AttachedDamper, DamperLayout, LayoutResponse, evaluate_dampers
from pidpanel.solve.model import ResponseError
from pidpanel.solve.solvers import PanelSolver, Request

STEP = 0.05  # ε, of ln Γ: central differences are then good to ε²/6 of a derivative's own scale


class FurtherPsd(NamedTuple):
    """PSDs that follow the damping besides those of the points."""

    psd: Array  # (nf, k)
    # (n_loads, nf, k) ∂ ln S/∂ ln C_e and ∂ ln S/∂ m_a at given Γ
    of_damping: Array
    of_mass: Array


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives with respect to what is known with errors.

    Load by load ln C_e at the n nodes, then m_a [kg/m²] at the nodes; k = 2n n_loads in all.
    """

    log_psd: Array  # (k, nf, n_points) of ln S_a
    log_rms: Array  # (k, n_points) of ln of the rms acceleration
    log_acceleration: Array  # (k, n_loads) of ln Γ; 0 where Γ is stated or plays no part

    def standard_errors(self, covariance: Array) -> StandardErrors:
        """Return the standard errors for a covariance (k, k)."""

        def error(derivative: Array) -> Array:
            flat = derivative.reshape(len(derivative), -1)
            variance = np.sum(flat * (covariance @ flat), axis=0).reshape(derivative.shape[1:])
            return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

        return StandardErrors(*map(error, (self.log_psd, self.log_rms, self.log_acceleration)))


@dataclass(frozen=True)
class StandardErrors:
    """Standard errors of the logarithms of a scenario's responses."""

    log_psd: Array  # (nf, n_points) of ln S_a
    log_rms: Array  # (n_points,) of ln of the rms acceleration: its relative standard error
    log_acceleration: Array  # (n_loads,) of ln Γ


def sensitivity(
    solver: PanelSolver,
    layout: DamperLayout,
    response: LayoutResponse,
    nodes: Array,
    further: FurtherPsd | None = None,
) -> Sensitivity:
    """Return the sensitivity of a layout's response to its damping.

    Parameters
    ----------
    solver, layout
        Same as in `layout.solve_with`.
    response
        Response of the layout; its slopes are computed here if it has none.
    nodes
        (n,) rising [Hz], of all loads.
    further
        PSDs whose derivatives follow those of the points.
    """
    loads, patches = layout.dampers, layout.patches
    value, mass = response.equivalent_damping, response.apparent_mass
    slope = response.response.slope
    if slope is None:
        (answer,) = solver.responses([Request(patches, value, mass, with_slope=True)])
        if answer.slope is None:
            raise ResponseError("the solver gave no slope, though one was asked for")
        slope = layout.factor * answer.slope
    psd = response.response.acceleration_psd
    by_node = _hats(solver.panel.frequency, nodes)
    local = _local(slope, psd, solver.panel.frequency, value)
    if further is not None:
        psd = np.hstack([psd, further.psd])
        slopes = zip(local, (further.of_damping, further.of_mass), strict=True)
        local = tuple(np.concatenate(parts, axis=2) for parts in slopes)
    # Γ held
    rows = _rows(local, by_node)  # (k, nf, points)
    log_acceleration = np.zeros((len(rows), len(loads)))
    moving = np.flatnonzero(layout.follows_motion)
    if moving.size:
        jacobian, pushed = _motion(solver, loads, response, nodes)
        at_rest = np.eye(moving.size) - jacobian[np.ix_(moving, moving)]
        log_acceleration[:, moving] = np.linalg.solve(at_rest, pushed[:, moving].T).T
        follows = _with_motion(
            loads, solver.panel.frequency, response.acceleration_g, moving.tolist()
        )
        for load in moving:
            by_motion = sum(
                derivative[load] * change[load][:, None]
                for derivative, change in zip(local, follows, strict=True)
            )
            rows += log_acceleration[:, load, None, None] * by_motion
    return Sensitivity(rows, _log_rms(solver.panel.frequency, psd, rows), log_acceleration)


def _motion(
    solver: PanelSolver, loads: Sequence[AttachedDamper], response: LayoutResponse, nodes: Array
) -> tuple[Array, Array]:
    """Return J (n_loads, n_loads) and q (k, n_loads), changes of ln Γ_out."""
    motions = solver.motions(tuple(load.patch for load in loads))
    lines = solver.panel.search_frequency
    gamma = response.acceleration_g
    value, mass, _ = evaluate_dampers(loads, lines, gamma)
    psd = motions.acceleration_psd(value, mass).T  # (nf, patch that moves)
    slope = motions.acceleration_slope(value, mass).transpose(1, 2, 0)  # (damper, nf, patch)
    local = _local(slope, psd, lines, value)
    damping_slope, mass_slope = _with_motion(
        loads, lines, gamma, np.flatnonzero(np.isfinite(gamma)).tolist()
    )
    by_motion = local[0] * damping_slope[:, :, None] + local[1] * mass_slope[:, :, None]
    jacobian = _log_rms(lines, psd, by_motion).T
    return jacobian, _log_rms(lines, psd, _rows(local, _hats(lines, nodes)))


def _with_motion(
    loads: Sequence[AttachedDamper], frequency: Array, gamma: Array, moving: Sequence[int]
) -> tuple[Array, Array]:
    """Return ∂ ln C_e/∂ ln Γ and ∂ m_a/∂ ln Γ (n_loads, nf) of some loads; 0 of the others."""
    damping_slope, mass_slope = np.zeros((2, len(loads), frequency.size))
    for load in moving:
        high, high_mass, _ = loads[load].damping(frequency, float(gamma[load] * np.exp(STEP)))
        low, low_mass, _ = loads[load].damping(frequency, float(gamma[load] * np.exp(-STEP)))
        ratio = np.divide(high, low, out=np.ones_like(low), where=(low > 0) & (high > 0))
        damping_slope[load] = np.log(ratio) / (2 * STEP)
        mass_slope[load] = (high_mass - low_mass) / (2 * STEP)
    return damping_slope, mass_slope


def _rows(local: Sequence[Array], by_node: Array) -> Array:
    """Return (k, nf, n_points) from A and B (n_loads, nf, n_points) and the nodes (n, nf)."""
    terms = np.stack(local, axis=1)[:, :, None] * by_node[:, :, None]  # load, A or B, node, line
    return terms.reshape(-1, *terms.shape[3:])


def _local(slope: Complexes, psd: Array, frequency: Array, damping: Array) -> tuple[Array, ...]:
    """Return A and B (n_loads, nf, n) of PSDs (nf, n) with the slopes t (n_loads, nf, n)."""
    omega, inverse = 2 * np.pi * frequency[:, None], _inverse(psd)
    by_damping = 2 * omega * damping[:, :, None] * slope.imag * inverse
    return by_damping, 2 * omega**2 * slope.real * inverse


def _inverse(psd: Array) -> Array:
    """Return 1/S; 0 where nothing moves, as at a support, so that the error is 0 too."""
    return np.divide(1.0, psd, out=np.zeros_like(psd), where=psd > 0)


def _hats(frequency: Array, nodes: Array) -> Array:
    """Return (n, nf) piecewise linear functions of ln f, 1 at one node and 0 at the others."""
    x, x_nodes = np.log(frequency), np.log(nodes)
    return np.stack([np.interp(x, x_nodes, unit) for unit in np.eye(len(nodes))])


def _log_rms(frequency: Array, psd: Array, log_psd: Array) -> Array:
    """Return the change of the ln of an rms value (k, …) from that of ln of its PSD (k, nf, …)."""
    total = np.asarray(np.trapezoid(psd, frequency, axis=0))
    return np.asarray(np.trapezoid(psd * log_psd, frequency, axis=1) / 2 * _inverse(total))
