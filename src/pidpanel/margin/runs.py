"""The answers of a panel with one set of inputs: g rms, bare and with each layout of dampers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.margin.waves import WaveMatrix
from pidpanel.solve.bands import band_rms
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.layout import sine_accelerations_g
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.modal import BarePanel, bare_panels
from pidpanel.solve.model import ModalBasis, PatchCoordinates, Patches
from pidpanel.solve.motions import Motions
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
    medium: AcousticMedium,
    layouts: Sequence[DampedLayout],
    band_edges: Array,
    near: Sequence[Array] | None = None,
) -> Answers:
    """Return the answers of a run.

    Parameters
    ----------
    band_edges
        (n_bands, 2) of the bands whose rms values are computed too [Hz].
    near
        ln Γ of each layout near which it is searched; None searches from all sides.
    """
    bare = _bare(inputs, medium, layouts)
    bare_psd = bare[()].point_psd[:, :, 0, 0].real
    psds, motions_of_layouts = [bare_psd], []
    for number, layout in enumerate(layouts):
        panel, area = bare[layout.patches], inputs.area[list(layout.patches)]
        start = None if near is None else near[number]
        gamma = _motion(layout, panel, area, start)
        damping, mass = _read(layout, inputs.frequency, gamma)
        psds.append(layout.factor * attach_dampers(panel, damping, mass).displacement_psd)
        motions_of_layouts.append(gamma)
    g = (2 * np.pi * inputs.frequency[:, None]) ** 4 / STANDARD_GRAVITY**2
    acceleration = [psd * g for psd in psds]
    weight = trapezoid_weights(inputs.frequency)
    rms = np.sqrt([weight @ psd for psd in acceleration])
    bands = [band_rms(inputs.frequency, psd, band_edges).T for psd in acceleration]
    return Answers(rms, tuple(motions_of_layouts), np.array(bands))


def _bare(
    inputs: RunInputs, medium: AcousticMedium, layouts: Sequence[DampedLayout]
) -> dict[tuple[int, ...], BarePanel]:
    """Return the panel without dampers by the patches that carry some."""
    vectors, frequency = inputs.vectors, inputs.frequency
    patches = Patches.of_rows(inputs.rows @ vectors, inputs.area)
    force = medium.force.in_modes(vectors)

    def number(f: Array) -> Array:
        return 2 * np.pi * f / inputs.speed

    air: Callable[[Array], Complexes] | None = None
    if medium.resistance is not None:
        shared = medium.resistance is medium.force
        resistance = force if shared else medium.resistance.in_modes(vectors)
        volume = None if medium.volume is None else medium.volume.in_modes(vectors)

        def air(f: Array) -> Complexes:
            omega = 2 * np.pi * f[:, None, None]
            mass = medium.sides * inputs.density * omega**2
            matrix = 1j * (mass * omega / (2 * np.pi * inputs.speed)) * resistance(number(f))
            return np.asarray(matrix if volume is None else matrix - mass * volume(number(f)))

    sets = list(dict.fromkeys([*(layout.patches for layout in layouts), ()]))
    panels = bare_panels(
        frequency, inputs.basis, [patches.subset(loaded) for loaded in sets],
        inputs.points @ vectors, inputs.pressure, lambda f: force(number(f)), air,
        overlap_cutoff=CUTOFF,
    )  # fmt: skip
    return dict(zip(sets, panels, strict=True))


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
    if near is not None:  # in few steps, for which a decomposition of one patch does not pay
        columns, weight, inverse = astuple(panel.coordinates)
        if weight.ndim == 2:
            weight = weight[:, :, None] * np.eye(weight.shape[1])
        panel = replace(panel, coordinates=PatchCoordinates(columns, weight, inverse))
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
