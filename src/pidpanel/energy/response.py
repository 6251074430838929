"""Mean square acceleration of a panel in a diffuse field by statistical energy.

With n modes per hertz, radiation efficiency σ, k = ω/c₀ and the loss factor η, the area mean of the
acceleration PSD over the PSD of the pressure on the face is

    S_a/S_p = n ω π σ/(2 η m″² k² A) + (1/m″²) ⟨∫₀¹ dμ/|1 − (ω_t/ω)² (1 + iη)|²⟩.

The first part is resonant: G_ii = (2π/k²) σ ∫φ_i² dA by reciprocity, and ∫ ω⁴ |H_i|² df of each
mode. The second is forced, by waves that are longer along the panel than its own: ω_t is the
frequency of a wave with the trace κ = k √(1 − μ²). It is that of directions below coincidence:
above it the same integral is the resonant part. ⟨⟩ is the mean over the directions of waves in the
panel.

References
----------
Leppington, Broadbent and Heron, Proc. R. Soc. Lond. A 382, 245 (1982): σ.
Lyon and DeJong, Theory and Application of Statistical Energy Analysis (1995): power balance.
Langley and Cotoni, J. Acoust. Soc. Am. 115, 706 (2004): variance.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.damping_ratio import DampingRatio
from pidpanel.energy.waves import PanelWaves

TRACES = 64  # Gauss nodes of the forced waves over their angle of incidence
STEP = 1e-3  # of ln f, for derivatives of the mode count
# |ln κ/k| below which a band is at coincidence: there σ depends on the finite panel. On a thin
# plate and two sandwiches it is 1 to 3 dB off within, and below 0.3 dB beyond.
COINCIDENCE = 0.15
LEAST_COUNT = 0.1  # least share of the modes that edges leave, where the count has no meaning


class Edges(NamedTuple):
    """Straight pieces of the boundary of a panel."""

    length: Array  # (n,) [m]
    angle: Array  # (n,) of their direction [rad]
    kind: tuple[str, ...]  # (n,) as of `pidpanel.panel.supports.EdgeSupport`

    def share(self, kind: str) -> float:
        """Return the share of a kind in the length of the boundary."""
        return float(self.length[[k == kind for k in self.kind]].sum() / self.length.sum())


class Medium(NamedTuple):
    """The air: sound reaches the panel through it, and is radiated into it."""

    speed: float  # c₀ [m/s]
    density: float  # ρ₀ [kg/m³]
    sides: int  # on which it takes power from the panel: 0, 1 or 2
    is_baffled: bool


class DamperLoad(NamedTuple):
    """Dampers of a scenario, over frequency: their loss factor times m″ ω A, and their mass."""

    resistance: Array | float = 0.0  # (nf,) Σ C_e A_d [N s/m]
    mass: Array | float = 0.0  # (nf,) Σ m_a A_d [kg]


class EnergyResponse(NamedTuple):
    """Area mean of the acceleration of a panel, over frequency; all (nf,)."""

    acceleration: Array  # S_a/S_p [(m/s²)²/Pa²]
    modal_density: Array  # modes per hertz [1/Hz]
    radiation_efficiency: Array  # σ, mean over directions [1]
    loss_factor: Array  # η of panel, air and dampers [1]
    damper_loss_factor: Array  # η_d [1]
    resonant_share: Array  # of the resonant part in the acceleration [1]
    wavenumber_ratio: Array  # κ/k of the mean wave [1]; 1 at coincidence
    at_coincidence: Flags  # whether a direction is
    is_known: Flags  # whether its radiation is: false below coincidence with free edges


@dataclass(frozen=True)
class EnergyPanel:
    """A flat panel of one section in a diffuse field."""

    waves: PanelWaves
    area: float  # [m²]
    edges: Edges
    damping_ratio: DampingRatio  # ζ of the bare panel
    medium: Medium

    def mode_count(self, frequency: Array) -> Array:
        """Return N (nf,) below frequencies [Hz], smooth, corrected for the edges."""
        omega = 2 * np.pi * frequency
        return self.area * np.mean(self.waves.wavenumber(omega) ** 2, 1) / (
            4 * np.pi
        ) + self._edges(omega)

    def _edges(self, omega: Array) -> Array:
        """Return the part of the edges in the mode count (nf,)."""
        waves = (
            self.waves.wavenumber_towards(omega, self.edges.angle) * self.edges.length / (4 * np.pi)
        )
        factors = {kind: self.waves.edge_factor(omega, kind) for kind in set(self.edges.kind)}
        return np.sum(waves * np.stack([factors[k] for k in self.edges.kind], axis=1), axis=1)

    def response(self, frequency: Array, load: DamperLoad | None = None) -> EnergyResponse:
        """Return the response at frequencies (nf,) [Hz]."""
        f, waves, load = np.asarray(frequency, float), self.waves, load or DamperLoad()
        mass = waves.section.mass_per_area + np.broadcast_to(load.mass, f.shape) / self.area
        slower = np.sqrt(mass / waves.section.mass_per_area)  # waves of a heavier panel
        omega, k = 2 * np.pi * f, 2 * np.pi * f / self.medium.speed
        kappa = waves.wavenumber(omega * slower)
        ends = [omega * slower * np.exp(sign * STEP) for sign in (-1, 1)]
        square = np.subtract(*[waves.wavenumber(end) ** 2 for end in ends[::-1]])
        modes = self.area * square / (8 * np.pi * STEP * f[:, None])  # per hertz and direction
        plain = modes.mean(axis=1)
        edges = np.subtract(*[self._edges(end) for end in ends[::-1]]) / (2 * STEP * f)
        corrected = np.maximum(1 + edges / plain, LEAST_COUNT)
        sigma = self._radiation_efficiency(kappa, k[:, None])
        by_dampers = np.broadcast_to(load.resistance, f.shape) / (omega * mass * self.area)
        bare = 2 * np.array([self.damping_ratio.ratio_at(line) for line in f.tolist()])
        air = self.medium.sides * self.medium.density * self.medium.speed / (omega * mass)
        eta = (bare + by_dampers)[:, None] + air[:, None] * sigma
        scale = corrected * omega * np.pi / (2 * mass**2 * k**2 * self.area)
        resonant = scale * np.mean(modes * sigma / eta, axis=1)
        total = resonant + self._forced(omega * slower, kappa, k, eta) / mass**2
        ratio = kappa / k[:, None]
        is_known = self.medium.is_baffled and not self.edges.share("free")
        return EnergyResponse(
            total,
            corrected * plain,
            sigma.mean(axis=1),
            eta.mean(axis=1),
            by_dampers,
            resonant / total,
            ratio.mean(axis=1),
            np.any(np.abs(np.log(ratio)) < COINCIDENCE, axis=1),
            np.all((ratio < 1) | is_known, axis=1),
        )

    def _forced(self, omega: Array, kappa: Array, k: Array, eta: Array) -> Array:
        """Return the forced part times m″², (nf,)."""
        node, weight = np.polynomial.legendre.leggauss(TRACES)
        trace = k[:, None] * np.sqrt(1 - ((1 + node) / 2) ** 2)
        ratio = (self.waves.frequency(trace) / omega[:, None, None]) ** 2
        of_trace = 1 / np.abs(1 - ratio * (1 + 1j * eta[:, None])) ** 2
        is_subsonic = kappa > k[:, None]
        return np.mean(is_subsonic * np.einsum("m,fmt->ft", weight / 2, of_trace), axis=1)

    def _radiation_efficiency(self, kappa: Array, k: Array) -> Array:
        clamped = self.edges.share("clamped")
        return radiation_efficiency(kappa, k, self.area, self.edges.length.sum(), 1 + clamped)


def radiation_efficiency(
    kappa: Array, k: Array, area: float, perimeter: float, edge: float = 1.0
) -> Array:
    """Return σ of one side of a baffled panel, mean over the modes of wavenumber κ [1].

    Parameters
    ----------
    kappa, k
        Wavenumbers of the panel and of the air [rad/m], of shapes that go together.
    area, perimeter
        [m²], [m].
    edge
        1 of supported edges, 2 of clamped ones; only below coincidence.

    Examples
    --------
    >>> float(radiation_efficiency(np.array(30.0), np.array(50.0), 1.5, 5.0))
    1.25
    """
    # sides of the rectangle with this area and perimeter
    half, product = perimeter / 4, area
    spread = np.sqrt(max(half**2 - product, 0.0))
    short, long = half - spread, half + spread
    highest = (0.5 - 0.15 * short / long) * np.sqrt(k * short)  # at coincidence
    ratio = kappa / k
    supersonic = 1 / np.sqrt(np.maximum(1 - ratio**2, 1e-12))
    mu = np.maximum(ratio, 1 + 1e-9)
    shape = np.log((mu + 1) / (mu - 1)) + 2 * mu / (mu**2 - 1)
    subsonic = perimeter / (2 * np.pi * mu * k * area * np.sqrt(mu**2 - 1)) * shape
    subsonic *= edge - mu**-8 * (edge - 1)
    return np.asarray(np.minimum(np.where(ratio < 1, supersonic, subsonic), highest))


def relative_variance(modes: Array, eta: Array, factor: Array | float, band: float) -> Array:
    """Return the variance of a band mean over its square, over panels that differ in detail.

    Natural frequencies repel each other as in random matrices (Langley and Cotoni, Eq. 2).

    Parameters
    ----------
    modes
        Modes in the band.
    eta
        Loss factor.
    factor
        ⟨x²⟩/⟨x⟩² of what modes receive and show: 1 if they are all alike.
    band
        Width of the band over its centre.
    """
    B = band / np.asarray(eta)
    spread = (factor - 1) * (2 * B * np.arctan(B) - np.log1p(B**2)) / (np.pi * modes * B)
    return np.asarray(spread + np.log1p(B**2) / (np.pi * modes) ** 2)
