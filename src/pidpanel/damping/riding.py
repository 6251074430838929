"""Trend of the loss of beds that ride, in the groups of the atlas.

With x = W/L, N = r depth/d layers and Γ over gravity, η = C_e/(m″ω) is near to

    A N^p Γ^−q μ^k + B x^s (N(1 − e²))^t N^v e^(wr).

The first term is the bed that the floor throws and catches, or that slides on it where gravity is
across the motion, with constants A and k of its own there. The second is the gas between both ends,
whose agitation depends on N(1 − e²) (Kumaran, *Phys. Rev. E* 57, 5660 (1998)); it goes over into
the loss of the inelastic body that crosses. What cases differ by from it is left to a Gaussian
process.
"""

import numpy as np
from scipy.optimize import least_squares

from pidpanel.arrays import Array
from pidpanel.damping.inelastic import LONGEST_GAP, slug

# ln A, p, q, k, then ln A and k of gravity across over these, ln B, s, t, v, w: where the search
# starts; each differs from it by about 1.
START = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0])

CLOSE = 0.25  # error of the trend about which cases are compared: few are outliers


def riding_trend(constants: Array, points: Array) -> Array:
    """Return ln 2πη (n,) of beds that ride, at `atlas.AtlasBed.points` (n, 9).

    Parameters
    ----------
    constants
        (11,) of `fit_riding`.
    """
    fill, gamma, throw, loss, friction, width, layers, upright, _ = points.T
    friction = friction + width - layers + np.log(fill)  # ln μ
    a, p, q, k, across, k_across, b, s, t, v, w = constants
    thrown = a + p * layers - q * gamma + k * friction + upright * (across + k_across * friction)
    stroke = throw - gamma  # ln(W/L)
    gas = b + s * stroke + t * loss + v * layers + w * fill
    body, _ = slug(np.minimum(np.exp(-stroke), LONGEST_GAP))
    gas = -np.logaddexp(-gas, -np.log(body / np.pi))
    return np.asarray(np.log(2 * np.pi) + np.logaddexp(thrown, gas))


def fit_riding(points: Array, log_loss: Array, error: Array) -> Array:
    """Return the constants (11,) of cases that ride, by robust least squares.

    Parameters
    ----------
    points, log_loss, error
        (n, 9), ln 2πη (n,) and its standard errors.
    """
    scale = np.hypot(error, CLOSE)

    def away(constants: Array) -> Array:
        residual = (riding_trend(constants, points) - log_loss) / scale
        return np.concatenate([residual, constants - START])

    return np.asarray(least_squares(away, START, loss="soft_l1").x)
