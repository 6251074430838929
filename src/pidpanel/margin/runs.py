"""The answers of a panel with one set of inputs: g rms, bare and with each layout of dampers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.margin.waves import WaveMatrix
from pidpanel.solve.bands import band_rms
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.layout import sine_accelerations_g
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.modal import BarePanel, chunks_of_lines, shape_coordinates
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.motions import Motions
from pidpanel.solve.moved_panel import MovedPanel, coupled_shapes
from pidpanel.solve.receptances import Receptances
from pidpanel.solve.search import find_motions, governing, iterate, starts_between

LINES_PER_BANDWIDTH = 2.0  # rms within 0.2 %, see `solve.lines.frequency_grid`
# With these, g rms is within 0.1 %: measured on six samples of the paper's panel, bare and with two
# layouts at two levels, against half of each or less.
CUTOFF = 1e-2  # eigenvalues of D dropped, see `solve.modal.bare_panels`
CONSISTENT = 3e-3  # of ln Γ: g rms within a tenth of it
SEARCHED = 3  # every third line is enough to search Γ

Damping = Callable[[Array, float], tuple[Array, Array]]  # f (nf,), Γ → C_e, m_a (nf,)


class DampedLayout(NamedTuple):
    """Dampers on some patches."""

    patches: tuple[int, ...]
    dampers: tuple[Damping, ...]
    factor: float = 1.0  # on the PSD of the sound
    follows_motion: bool = True


class AcousticMedium(NamedTuple):
    """The sound and the air on the shapes of the family."""

    force: WaveMatrix  # G [m⁴]
    resistance: WaveMatrix | None  # G of the diffuse field [m⁴]; None without air
    volume: WaveMatrix | None  # of the added mass [m³]
    sides: int

    def matrices(self, inputs: RunInputs) -> Callable[[Array], tuple[Array, Complexes | None]]:
        """Return G and −ω²M_air + iωR over frequency in the modes of a run."""
        force = self.force.in_modes(inputs.vectors)
        volume = None if self.volume is None else self.volume.in_modes(inputs.vectors)
        resistance = None if self.resistance is None else force
        if self.resistance is not None and self.resistance is not self.force:
            resistance = self.resistance.in_modes(inputs.vectors)

        def matrices(f: Array) -> tuple[Array, Complexes | None]:
            number = 2 * np.pi * f / inputs.speed
            G = force(number)
            if resistance is None:
                return G, None
            R = G if resistance is force else resistance(number)
            omega = 2 * np.pi * f[:, None, None]
            mass = self.sides * inputs.density * omega**2
            air = np.empty(R.shape, complex)
            air.imag = (mass * omega / (2 * np.pi * inputs.speed)) * R
            air.real = 0.0 if volume is None else -mass * volume(number)
            return G, air

        return matrices


class RunInputs(NamedTuple):
    """The inputs of a run."""

    frequency: Array  # (nf,) lines [Hz]
    basis: ModalBasis  # modes of 1 kg
    vectors: Array  # (n, m) of the modes, in the shapes of the family
    points: Array  # (n_points, n) w of the shapes there
    rows: Array  # (n_patches, k, n) √weight times the shapes at the quadrature of the patches [m]
    area: Array  # (n_patches,) [m²]
    pressure: Array  # (nf,) S [Pa²/Hz]
    density: float  # of the air [kg/m³]
    speed: float  # of sound [m/s]


@dataclass(frozen=True)
class Answers:
    """Answers of a run; the bare panel comes first."""

    rms: Array  # (1 + n_layouts, n_points) [g]
    log_acceleration: tuple[Array, ...]  # of each layout (n_loads,) ln Γ
    band_rms: Array  # (1 + n_layouts, n_points, n_bands) [g]


def answers(
    inputs: RunInputs,
    panel: UnitPanel,
    layouts: Sequence[DampedLayout],
    band_edges: Array,
    near: Sequence[Array] | None = None,
) -> Answers:
    """Return the answers of a run.

    Parameters
    ----------
    panel
        The panel without dampers, from the same inputs.
    band_edges
        (n_bands, 2) of the bands whose rms values are computed too [Hz].
    near
        ln Γ of each layout near which it is searched; None searches from all sides.
    """
    bare_psd = panel.under(inputs.pressure, ()).point_psd[:, :, 0, 0].real
    psds, motions_of_layouts = [bare_psd], []
    for number, layout in enumerate(layouts):
        bare, area = panel.under(inputs.pressure, layout.patches), inputs.area[list(layout.patches)]
        start = None if near is None else near[number]
        gamma = _motion(layout, bare, area, start)
        damping, mass = _read(layout, inputs.frequency, gamma)
        psds.append(layout.factor * attach_dampers(bare, damping, mass).displacement_psd)
        motions_of_layouts.append(gamma)
    g = (2 * np.pi * inputs.frequency[:, None]) ** 4 / STANDARD_GRAVITY**2
    acceleration = [psd * g for psd in psds]
    weight = trapezoid_weights(inputs.frequency)
    rms = np.sqrt([weight @ psd for psd in acceleration])
    bands = [band_rms(inputs.frequency, psd, band_edges).T for psd in acceleration]
    return Answers(rms, tuple(motions_of_layouts), np.array(bands))


@dataclass(frozen=True)
class UnitPanel:
    """The panel without dampers under a sound of 1 Pa²/Hz, seen from its points and patches."""

    frequency: Array  # (nf,) [Hz]
    # (nf, k, k) among the motions of the points and those that the patches feel
    receptance: Complexes  # [m/N]
    psd: Complexes
    points: int  # the first of the motions
    felt: Mapping[int, Index]  # motions of each patch

    @classmethod
    def solved(cls, inputs: RunInputs, medium: AcousticMedium, patches: Sequence[int]) -> UnitPanel:
        """Return the panel whose ``patches`` may carry dampers."""
        vectors, frequency = inputs.vectors, inputs.frequency
        points = inputs.points @ vectors
        rows = [inputs.rows[patch] @ vectors for patch in patches]
        factors = Patches.of_rows(rows, inputs.area[list(patches)]).factors(CUTOFF) if rows else []
        motions = np.hstack([points.T, *factors])
        matrices, parts = medium.matrices(inputs), []
        for lines in chunks_of_lines(frequency.size, points.shape[1]):
            part = frequency[lines]
            force, air = matrices(part)
            moved = MovedPanel(
                part, inputs.basis, coupled_shapes(air, part, inputs.basis), [motions]
            )
            (receptance,) = moved.receptances(0, [0])
            (psd,) = moved.psds(0, [0], force)
            parts.append((receptance, psd))
        receptance, psd = (np.concatenate(values) for values in zip(*parts, strict=True))
        ends = np.cumsum([len(points), *(factor.shape[1] for factor in factors)])
        felt = [np.arange(*slice_ends) for slice_ends in pairwise(ends.tolist())]
        return cls(frequency, receptance, psd, len(points), dict(zip(patches, felt, strict=True)))

    def under(self, pressure: Array, patches: Sequence[int]) -> BarePanel:
        """Return it under a pressure (nf,) [Pa²/Hz], ready for dampers on some patches."""
        coordinates = [self.felt[patch] for patch in patches]
        felt = np.concatenate([*coordinates, np.zeros(0, int)])
        weight = np.array([np.diag(np.isin(felt, part) * 1.0) for part in coordinates])
        weight = weight.reshape(len(patches), felt.size, felt.size)
        seen = np.arange(self.points)
        level = pressure[:, None, None]
        values = Receptances(
            self.receptance[:, felt[:, None], felt],
            self.receptance[:, seen[:, None], felt],
            level * self.psd[:, felt[:, None], felt],
            level * self.psd[:, seen[:, None], felt],
        )
        at_points = (pressure[:, None] * self.psd[:, seen, seen])[:, :, None, None]
        return BarePanel(self.frequency, shape_coordinates(weight), values, at_points)


def _read(layout: DampedLayout, frequency: Array, log_gamma: Array) -> tuple[Array, Array]:
    """Return C_e and m_a (n_loads, nf)."""
    motions = zip(layout.dampers, np.exp(log_gamma).tolist(), strict=True)
    read = [damping(frequency, gamma) for damping, gamma in motions]
    return np.array([value for value, _ in read]), np.array([mass for _, mass in read])


def _motion(layout: DampedLayout, panel: BarePanel, area: Array, near: Array | None) -> Array:
    """Return ln Γ of the loads at their consistent motion."""
    count = len(layout.patches)
    if not layout.follows_motion:
        return np.zeros(count)
    motions = Motions(panel, area).subsampled(SEARCHED)

    def log_motion(log_gamma: Array) -> Array:
        rms = motions.acceleration_rms(*_read(layout, motions.frequency, log_gamma))
        return np.log(sine_accelerations_g(np.sqrt(layout.factor) * rms))

    if near is not None:
        gamma, residual = iterate(log_motion, near, CONSISTENT)
        if residual <= CONSISTENT:
            return gamma
    bare = np.log(sine_accelerations_g(np.sqrt(layout.factor) * motions.bare_acceleration_rms()))
    starts = starts_between(bare - np.log(100), bare + np.log(3))
    return governing(find_motions([log_motion], starts, CONSISTENT)).log_gamma
