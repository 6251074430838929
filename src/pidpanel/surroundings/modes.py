"""What the surroundings of a panel change: each mode alone, at its resonance in air."""

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.plane_waves import PanelQuadrature, WettedFace, condensed
from pidpanel.sound.field import SoundExcitation
from pidpanel.sound.radiation import Air

ROUNDS = 4  # of f → f in air; the mass of the air hardly depends on f
# Modes counted to the wavenumber of a face besides its own: of few, Weyl's law is a mean.
MORE_MODES = 6
# Wavenumber to which a face is condensed over that of the sound and of its modes.
REACH = 2.0


def mode_accelerations(
    frequency: Array,
    mass: Array,
    damping_ratio: Array,
    excitation: SoundExcitation,
    air: Air | None = None,
) -> Array:
    """Return the rms acceleration of each mode alone, from its resonance [m/s²].

    A mode of mass M and damping c under a force of PSD S at its frequency ω = 2πf has the rms
    acceleration ω √(S/(4 c M)) (white noise, Crandall and Mark 1963). The air adds its mass and its
    resistance to the mode.

    Parameters
    ----------
    frequency, mass, damping_ratio
        (n,) f [Hz], M [kg] and ζ of the modes in vacuum, in the order of the tables' shapes.
    air
        None for a panel in vacuum.
    """
    omega, natural = 2 * np.pi * frequency, 2 * np.pi * frequency
    total, resistance = mass, np.zeros_like(mass)
    index = np.arange(len(mass))
    if air is not None:
        for _ in range(ROUNDS):
            stiffness = air(omega / (2 * np.pi))[index, index, index]
            total = mass - stiffness.real / omega**2
            omega = natural * np.sqrt(mass / total)
        resistance = stiffness.imag / omega
    damping = 2 * damping_ratio * natural * mass + resistance
    hertz = omega / (2 * np.pi)
    load = excitation(hertz)[index, index, index].real
    accelerations: Array = omega * np.sqrt(
        excitation.spectrum(hertz) * load / (4 * damping * total)
    )
    return accelerations


def face_of_modes(moved: WettedFace, modes: Index, wavenumber: float) -> WettedFace:
    """Return a face in its first modes, condensed for these and for waves to k [rad/m] of sound."""
    area = np.abs(cell_areas(moved.vertex_position, moved.cells)).sum()
    bending = float(np.sqrt(4 * np.pi * (len(modes) + MORE_MODES) / area))
    reach = REACH * max(wavenumber, bending)
    face = condensed(PanelQuadrature.from_face(moved).of_shapes(modes), reach)
    return WettedFace(
        face.position,
        face.weight,
        face.shape,
        reach,
        moved.vertex_position,
        moved.cells,
        moved.shape_at_vertices[:, modes],
        moved.face_overlap[np.ix_(modes, modes)],
    )
