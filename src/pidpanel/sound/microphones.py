"""A sound field that microphones measured: a diffuse field, conditioned on their cross-spectra.

Between microphones nothing is known but that the field obeys the wave equation. So it is taken as a
Gaussian field, diffuse before anything is known (Ueno, Koyama and Saruwatari 2018; in the panel's
terms, kriging). With K the cross-spectra of the microphones in a diffuse field, X those of modal
forces and microphones, G_d the modal forces alone, all per PSD on the face, and Γ what was measured

    G = G_d + B (Γ − K) Bᴴ,    B = X K⁻¹.

G is positive semidefinite, since G_d − B K Bᴴ is the covariance that remains. Where Γ = K nothing
changes; far from every microphone the field stays diffuse. K contains the noise ε of microphones,
gains and positions on its diagonal, without which close microphones would cancel.

On or before a rigid wall K = (sin kR/kR + sin kR′/kR′)/2, with R′ to the image of the other
microphone, and X = ∫ φ sin kR/kR dA. In a room K = sin kR/kR, and X is a mean over all directions
of the forces of plane waves on free edges (`free_edges`), times the wave at the microphones: these
have the room's field, without what the panel scatters.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.sound.field import half_circle, half_gauss
from pidpanel.sound.free_edges import MORE_NODES, NODES_PER_REACH, FreePanel
from pidpanel.sound.wavenumber_table import Table, WavenumberTable, chebyshev_nodes, node_count

MOST_LINES = 200  # at which the error of averages is tabulated


@dataclass(frozen=True)
class Microphones:
    """Microphones, and what they measured."""

    position: Array  # (M, 3) [m], z from the face of the panel
    noise: float  # ε, mean square over that of the pressure [1]
    before_wall: bool  # whether the panel is part of a rigid wall
    wavenumber: Array  # (nl,) rising [rad/m]
    spectra: Complexes  # (nl, M, M) Γ per PSD on the face [1], Hermitian

    def expected(self, wavenumber: Array) -> Array:
        """Return K (nf, M, M) of a diffuse field without noise [1] at k (nf,) [rad/m]."""
        offset = self.position[:, None] - self.position
        coherence = _sinc(wavenumber, np.linalg.norm(offset, axis=2))
        if not self.before_wall:
            return coherence
        offset[..., 2] = self.position[:, None, 2] + self.position[:, 2]
        return (coherence + _sinc(wavenumber, np.linalg.norm(offset, axis=2))) / 2

    def _prior(self, wavenumber: Array) -> Array:
        return self.expected(wavenumber) + self.noise * np.eye(len(self.position))

    def measured(self, wavenumber: Array) -> Complexes:
        """Return Γ (nf, M, M), linear between the lines."""
        upper = np.clip(np.searchsorted(self.wavenumber, wavenumber), 1, self.wavenumber.size - 1)
        low, high = self.wavenumber[upper - 1], self.wavenumber[upper]
        share = np.clip((wavenumber - low) / (high - low), 0, 1)[:, None, None]
        return np.asarray((1 - share) * self.spectra[upper - 1] + share * self.spectra[upper])

    def conditioned(
        self, wavenumber: Array, diffuse: Array | Complexes, coupling: Array | Complexes
    ) -> Complexes:
        """Return G (nf, n, n) of G_d (nf, n, n) and X (nf, n, M)."""
        prior = self._prior(wavenumber)
        weights = _weights(prior, coupling)
        change = self.measured(wavenumber) - prior
        return np.asarray(diffuse + weights @ change @ weights.conj().swapaxes(1, 2))

    def average_error(
        self,
        wavenumber: Array,
        diffuse: Array | Complexes,
        coupling: Array | Complexes,
        averages: int,
        *,
        is_level: bool,
    ) -> Array:
        """Return the relative standard error (nf, n) of the load on each shape by averaging.

        Γ of n independent blocks has a complex Wishart distribution, so that a linear form
        tr(QΓ) has the variance tr(QΓQΓ)/n. The load is bᴴΓb + r ℓ, with what Γ leaves diffuse, r,
        and the level ℓ of the microphones; with a spectrum of its own it is bᴴΓb/ℓ + r.
        """
        prior, spectra = self._prior(wavenumber), self.measured(wavenumber)
        weights = _weights(prior, coupling)
        rows = weights @ spectra
        known = np.sum(rows * weights.conj(), axis=2).real
        by_prior = np.sum((weights @ prior) * weights.conj(), axis=2).real
        remainder = np.diagonal(diffuse, axis1=1, axis2=2).real - by_prior
        expected = np.diagonal(self.expected(wavenumber), axis1=1, axis2=2)
        level = 1 / (expected * len(self.position))  # D, its diagonal
        factor = remainder if is_level else -known
        of_level = np.einsum("fm,fn,fmn->f", level, level, np.abs(spectra) ** 2)
        crossed = np.einsum("fnm,fm->fn", np.abs(rows) ** 2, level)
        variance = known**2 + 2 * factor * crossed + factor**2 * of_level[:, None]
        return np.sqrt(np.maximum(variance, 0) / averages) / (known + remainder)

    def known_share(
        self, wavenumber: Array, diffuse: Array | Complexes, coupling: Array | Complexes
    ) -> Array:
        """Return the share (nf, n) of the diffuse force on each shape that follows from them."""
        weights = _weights(self._prior(wavenumber), coupling)
        share = np.sum(coupling * weights.conj(), axis=2).real
        return np.asarray(share / np.diagonal(diffuse, axis1=1, axis2=2).real)

    def on_wall(self, wavenumber: float, face: PanelQuadrature) -> Complexes:
        """Return X (n, M) [m²] of a panel in a wall."""
        middle = self.position[None, :, :2] - face.position[:, None]
        distance = np.hypot(np.linalg.norm(middle, axis=2), self.position[:, 2])
        load = face.weight[:, None] * face.shape
        return (load.T @ _sinc(np.array([wavenumber]), distance)[0]).astype(complex)

    def distance(self, middle: Array) -> Array:
        """Return the positions (M, 3) from the middle (2,) of the panel [m]."""
        return self.position - np.append(middle, 0.0)

    def reach(self, middle: Array) -> float:
        """Return twice the largest distance from the middle (2,) of the panel [m]."""
        return 2 * float(np.max(np.linalg.norm(self.distance(middle), axis=1)))

    def in_room(
        self, wavenumber: float, panel: FreePanel, couplings: list[Array], middle: Array
    ) -> Complexes:
        """Return X (n, M) [m²] of half of the forces of waves on a panel with free edges."""
        reach = panel.jumps.diameter + self.reach(middle)
        cosine, weight = half_gauss(wavenumber, reach)
        half = half_circle(wavenumber, reach)
        around = np.concatenate([half, half + np.pi])
        angles = np.meshgrid(np.concatenate([cosine, -cosine]), around, indexing="ij")
        theta, alpha = np.arccos(angles[0].ravel()), angles[1].ravel()
        share = np.repeat(np.concatenate([weight, weight]) / 2 / around.size, around.size)
        forces = panel.wave_forces(wavenumber, theta, alpha, couplings) / 2
        sine = np.sin(theta)
        direction = np.stack([sine * np.cos(alpha), sine * np.sin(alpha), np.cos(theta)])
        waves = np.exp(1j * wavenumber * self.distance(middle) @ direction)
        return np.asarray((forces * share[:, None]).T @ waves.T)


@dataclass(frozen=True)
class MeasuredTable:
    """G of a measured field over the wavenumber."""

    diffuse: Table  # G_d [m⁴]
    coupling: WavenumberTable  # X (n, M) [m²]
    microphones: Microphones

    @property
    def wavenumber_max(self) -> float:
        """k_max [rad/m]."""
        return self.diffuse.wavenumber_max

    def matrix(self, wavenumber: ArrayLike, shapes: Index | None = None) -> Complexes:
        """Return `WavenumberTable.matrix`."""
        k = np.asarray(wavenumber, dtype=np.float64)
        diffuse, coupling = self.diffuse.matrix(k), self.coupling.matrix(k)
        matrix = self.microphones.conditioned(k, diffuse, coupling)
        return matrix if shapes is None else matrix[..., shapes]

    def factors_at(self, wavenumber: ArrayLike) -> None:
        """Return None: no short form is known."""

    def average_error(self, averages: int, *, is_level: bool) -> tuple[Array, Array]:
        """Return k (nk,) of at most `MOST_LINES` lines, and `Microphones.average_error` there."""
        lines = self.microphones.wavenumber
        k = lines[lines <= self.wavenumber_max]
        k = k[np.unique(np.linspace(0, k.size - 1, min(k.size, MOST_LINES)).astype(int))]
        matrices = self.diffuse.matrix(k), self.coupling.matrix(k)
        return k, self.microphones.average_error(k, *matrices, averages, is_level=is_level)


def _weights(prior: Array, coupling: Array | Complexes) -> Complexes:
    """Return B (nf, n, M) of K (nf, M, M) and X (nf, n, M)."""
    columns = np.linalg.solve(prior, coupling.conj().swapaxes(1, 2))
    return np.asarray(columns.conj().swapaxes(1, 2))


def tabulate_on_wall(
    wavenumber_max: float, face: PanelQuadrature, microphones: Microphones
) -> WavenumberTable:
    """Tabulate X of a panel in a wall for 0 ≤ k ≤ k_max [rad/m]."""
    reach = face.diameter + microphones.reach(face.center)
    nodes = chebyshev_nodes(wavenumber_max, node_count(wavenumber_max, reach))
    values = np.array([microphones.on_wall(k, face).real for k in nodes])
    return WavenumberTable(wavenumber_max, nodes, values)


def tabulate_in_room(
    panel: FreePanel, face: PanelQuadrature, microphones: Microphones
) -> WavenumberTable:
    """Tabulate X of a panel with free edges for 0 ≤ k ≤ k_max [rad/m] of the panel."""
    k_max, couplings = panel.wavenumber_max, panel.jumps.couplings(face)
    reach = panel.length + microphones.reach(face.center)
    nodes = chebyshev_nodes(k_max, int(NODES_PER_REACH * k_max * reach) + MORE_NODES)
    values = np.array([microphones.in_room(k, panel, couplings, face.center) for k in nodes])
    return WavenumberTable(k_max, nodes, values.real.copy(), values.imag / nodes[:, None, None])


def _sinc(wavenumber: Array, distance: Array) -> Array:
    """Return sin(kR)/(kR) (nf, *distance.shape)."""
    return np.asarray(np.sinc(np.multiply.outer(wavenumber, distance) / np.pi))
