"""The shapes of the panel between impulses, exactly.

    q̈_i + 2 ζ_i ω_i q̇_i + ω_i² q_i = Σ_n P_n,i δ(t − nΔt) / m_i

Every force acts as an impulse F Δt at a time step, on the panel and on the spheres alike, and
both move freely in between: no force is needed before it is known, none acts late, and momentum is
kept to rounding. Of a band-limited force the impulses are exact below half their rate.
"""

import numpy as np
import scipy.linalg

from pidpanel.arrays import Array


def free_motion(
    angular_frequency: Array, damping_ratio: Array, time_step: float
) -> tuple[Array, Array]:
    """Return what the shapes do from step to step, exp(A Δt) with A = [[0, 1], [−ω², −2ζω]].

    Examples
    --------
    >>> own, other = free_motion(np.array([0.0]), np.array([0.0]), 0.5)
    >>> own.ravel().tolist(), other.ravel().tolist()
    ([1.0, 1.0], [0.5, 0.0])
    """
    n = len(angular_frequency)
    matrix = np.zeros((n, 2, 2))
    matrix[:, 0, 1] = 1.0
    matrix[:, 1, 0] = -(angular_frequency**2)
    matrix[:, 1, 1] = -2 * damping_ratio * angular_frequency
    # units of a step: entries of one size
    scale = np.array([[1.0, 1 / time_step], [time_step, 1.0]])
    done = scipy.linalg.expm(matrix * scale * time_step) / scale
    return np.stack([done[:, 0, 0], done[:, 1, 1]]), np.stack([done[:, 0, 1], done[:, 1, 0]])


def drift_free_velocity(
    force: Array, mass: Array, interval: float, intervals_per_row: int
) -> Array:
    """Return the velocity (n,) [m/s] with which free shapes are back in their place after a period.

    Modal forces (m + 1, n) [N] are at the rows of a period, linear between them, the last like the
    first; the velocity is that before the first impulse, and ``interval`` [s] between impulses.
    """
    part = np.arange(intervals_per_row)[:, None] / intervals_per_row
    impulse = interval * (force[:-1, None] * (1 - part) + force[1:, None] * part)
    speed = np.cumsum(impulse.reshape(-1, force.shape[1]), axis=0) / mass
    drift: Array = speed.mean(axis=0)
    return -drift


def energy(modal_mass: Array, angular_frequency: Array, state: Array) -> float:
    """Return ½ Σ m (q̇² + ω² q²) of a state (2, n) of q [m] and q̇ [m/s], in J."""
    q, speed = state
    return float(0.5 * modal_mass @ (speed**2 + (angular_frequency * q) ** 2))
