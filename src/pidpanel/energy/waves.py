"""Bending waves of a panel section, and how many modes they make.

A wave w exp(iκ n·x) turns the normals by b = iB. With T B = (n_x B_x, n_y B_y, n_y B_x + n_x B_y),

    [ κ² n·S n      −κ (S n)ᵀ    ]         [ m″  0  ]
    [ −κ S n    κ² Tᵀ D T + S    ]  −  ω²  [ 0   I ] ,

is singular: bending D, core shear S, mass m″ and rotary inertia I of `pidpanel.panel.section`.
Without S the normals follow, B = κ n w, and ω² = κ⁴ D(n)/m″.

Modes are counted in phase space. An edge of length L changes the count by β κ L/4π, κ along it
(Bogomolny and Hugues, Phys. Rev. E 57, 5404 (1998), for thin plates).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from pidpanel.arrays import Array
from pidpanel.panel.section import Section, ThinSection

ANGLES = 36  # directions of waves over half a circle
WAVENUMBERS = np.geomspace(0.02, 2000.0, 160)  # [rad/m] at which frequencies are tabulated
EDGE_NODES = 64  # Gauss nodes of the phase of a reflection over its angle


@dataclass(frozen=True)
class PanelWaves:
    """Waves of a section in all directions."""

    section: Section

    @cached_property
    def angle(self) -> Array:
        """(n_angles,) equally spaced directions over half a circle [rad]."""
        return np.pi * np.arange(ANGLES) / ANGLES

    @cached_property
    def _log_omega(self) -> Array:
        """(n_wavenumbers, n_angles) ln ω of the lowest wave."""
        return np.log(wave_frequency(self.section, WAVENUMBERS[:, None], self.angle))

    def frequency(self, wavenumber: Array) -> Array:
        """Return ω [rad/s] at wavenumbers (…,) [rad/m] in all directions, (…, n_angles)."""
        spline = CubicSpline(np.log(WAVENUMBERS), self._log_omega)
        return np.asarray(np.exp(spline(np.log(wavenumber))))

    def wavenumber(self, omega: Array) -> Array:
        """Return κ [rad/m] in all directions, (nf, n_angles), at ω (nf,) [rad/s]."""
        log_kappa = np.log(WAVENUMBERS)
        columns = [CubicSpline(column, log_kappa)(np.log(omega)) for column in self._log_omega.T]
        return np.exp(np.stack(columns, axis=-1))

    def wavenumber_towards(self, omega: Array, angle: Array) -> Array:
        """Return κ [rad/m] at ω (nf,) [rad/s] and any angles (n,) [rad], (nf, n)."""
        angles = np.append(self.angle, np.pi)
        kappa = self.wavenumber(omega)
        spline = CubicSpline(angles, np.hstack([kappa, kappa[:, :1]]), axis=1, bc_type="periodic")
        return np.asarray(spline(np.mod(angle, np.pi)))

    @cached_property
    def mean_bending(self) -> float:
        """Mean bending stiffness of all directions [N m]."""
        return float(np.mean(bending_of_direction(self.section, self.angle)))

    def edge_factor(self, omega: Array, kind: str) -> Array:
        """Return β (nf,) of edges of a kind; between bending (thin plate) and shear (membrane).

        The share of bending is 1/(1 + D κ²/S), that of the wave's compliance.
        """
        if kind.startswith("simply_supported"):
            return np.full(omega.shape, -1.0)
        thin = edge_factor_thin(kind, poissons_ratio(self.section))
        if isinstance(self.section, ThinSection):
            return np.full(omega.shape, thin)
        kappa = self.wavenumber(omega).mean(axis=1)
        shear = np.trace(self.section.shear) / 2
        share = 1 / (1 + self.mean_bending * kappa**2 / shear)
        return np.asarray(share * thin + (1 - share) * (1.0 if kind == "free" else -1.0))


def wave_frequency(section: Section, wavenumber: Array, angle: Array) -> Array:
    """Return ω [rad/s] of the lowest wave, of κ [rad/m] and directions [rad] that go together."""
    kappa, angle = np.broadcast_arrays(np.asarray(wavenumber, float), np.asarray(angle, float))
    mass = section.mass_per_area
    if isinstance(section, ThinSection):
        return np.asarray(kappa**2 * np.sqrt(bending_of_direction(section, angle) / mass))
    n = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    turn = _curvature_of_turn(n)
    shear = section.shear
    pull = n @ shear
    matrix = np.empty((*kappa.shape, 3, 3))
    matrix[..., 0, 0] = kappa**2 * np.sum(pull * n, axis=-1) / mass
    side = -kappa[..., None] * pull / np.sqrt(mass * section.rotary_inertia)
    matrix[..., 0, 1:], matrix[..., 1:, 0] = side, side
    bending = np.swapaxes(turn, -1, -2) @ section.bending @ turn
    matrix[..., 1:, 1:] = (kappa[..., None, None] ** 2 * bending + shear) / section.rotary_inertia
    return np.asarray(np.sqrt(np.linalg.eigvalsh(matrix)[..., 0]))


def bending_of_direction(section: Section, angle: Array) -> Array:
    """Return the bending stiffness [N m] of waves that run in directions (…,) [rad]."""
    n = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    strain = (_curvature_of_turn(n) @ n[..., None])[..., 0]
    return np.asarray(np.einsum("...i,ij,...j->...", strain, section.bending, strain))


def _curvature_of_turn(n: Array) -> Array:
    """Return T (…, 3, 2)."""
    zero = np.zeros(n.shape[:-1])
    rows = [[n[..., 0], zero], [zero, n[..., 1]], [n[..., 1], n[..., 0]]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def poissons_ratio(section: Section) -> float:
    """Return the ratio of coupled to mean bending stiffness, ν of an isotropic section."""
    D = section.bending
    return float(D[0, 1] / np.sqrt(D[0, 0] * D[1, 1]))


def edge_factor_thin(kind: str, nu: float) -> float:
    """Return β of a clamped or free edge of a thin isotropic plate.

    exp(iδ) is the reflection of a wave whose wavenumber along the edge is u κ. The continuum counts
    4 ∫₀¹ (δ/2π + 1/4) du, with δ = −π at grazing; at a free edge a wave runs along it besides,
    with ξκ (Konenkov 1960).

    Examples
    --------
    >>> round(edge_factor_thin("clamped", 0.3), 4)  # −1 − Γ(3/4)/(√π Γ(5/4)) = −1.7628
    -1.7628
    """
    node, weight = np.polynomial.legendre.leggauss(EDGE_NODES)
    phi = np.pi / 4 * (1 + node)  # u = sin φ
    u, weight = np.sin(phi), np.pi / 4 * weight * np.cos(phi)
    p, s = np.sqrt(1 - u**2), np.sqrt(1 + u**2)
    if kind == "clamped":
        slope, edge_wave = s / p, 0.0
    else:
        slope = s * (s**2 - (2 - nu) * u**2) * (p**2 + nu * u**2)
        slope = slope / (p * (p**2 + (2 - nu) * u**2) * (s**2 - nu * u**2))
        root = 3 * nu - 1 + 2 * np.sqrt(1 - 2 * nu + 2 * nu**2)
        edge_wave = ((1 - nu) * root) ** -0.25
    return float(4 * (weight @ (np.arctan(slope) / np.pi - 0.75) + edge_wave))
