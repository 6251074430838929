"""What other surroundings of a study change at its first modes, and what microphones know there."""

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_waves import WettedFace
from pidpanel.sound import field
from pidpanel.sound.field_files import MODAL_FORCE
from pidpanel.sound.from_study import air_of, excitation_of, measured_tables, sound_tables
from pidpanel.sound.microphones import MeasuredTable
from pidpanel.study import Study
from pidpanel.study.mistakes import listed
from pidpanel.study.surroundings import change_text
from pidpanel.surroundings.modes import face_of_modes, mode_accelerations

COMPARED_MODES = 3  # number of modes at which other surroundings are compared


def surroundings_text(study: Study, moved: WettedFace, frequency: Array, mass: Array) -> str:
    """Return what the other surroundings of a study change at its first modes.

    Of a measured field, what microphones know of the load on them; "" of other fields.

    Parameters
    ----------
    moved
        The face in the modes, and in further shapes.
    frequency, mass
        (n,) natural frequencies [Hz], ascending, and modal masses [kg] of the modes.
    """
    is_measured = study.acoustics.field_name == "measured"
    opposite = study if is_measured else study.opposite
    if opposite is None or moved.quadrature_normal is not None:
        return ""
    low, high = study.response.frequency_hz
    modes = np.flatnonzero((frequency >= low) & (frequency <= high))[:COMPARED_MODES]
    ratio = study.panel.modal_damping.of_modes(frequency)[modes]
    frequency, mass = frequency[modes], mass[modes]
    if is_measured:
        return _known_text(study, moved, modes, frequency) if modes.size else ""
    change = np.empty(0)
    if modes.size:
        k_max = field.wavenumber(frequency[-1], study.acoustics.speed_m_s)
        face = face_of_modes(moved, modes, float(k_max))
        change = _level(opposite, face, frequency, mass, ratio)
        change -= _level(study, face, frequency, mass, ratio)
    return change_text(opposite.setting, frequency.tolist(), change.tolist())


def _known_text(study: Study, moved: WettedFace, modes: Index, frequency: Array) -> str:
    """Return which share of a diffuse load on the first modes microphones would determine."""
    k = field.wavenumber(frequency, study.acoustics.speed_m_s)
    face = face_of_modes(moved, modes, float(k[-1]))
    table = measured_tables(_up_to(study, frequency), face, air=False)[MODAL_FORCE]
    assert isinstance(table, MeasuredTable)
    force, coupling = table.diffuse.matrix(k), table.coupling.matrix(k)
    share = np.diagonal(table.microphones.known_share(k, force, coupling))
    percent = listed([f"{100 * value:.0f}" for value in share])
    hertz = listed([f"{value:.3g}" for value in frequency])
    return f"the microphones determine {percent} % of the load on the modes at {hertz} Hz"


def _up_to(study: Study, frequency: Array) -> Study:
    """Return a study up to the last of some frequencies."""
    lines = {"frequency_hz": (study.response.frequency_hz[0], float(frequency[-1]))}
    return study.model_copy(update={"response": study.response.model_copy(update=lines)})


def _level(study: Study, face: WettedFace, frequency: Array, mass: Array, ratio: Array) -> Array:
    """Return the rms of `mode_accelerations` in some surroundings [dB]."""
    low = _up_to(study, frequency)
    is_wet = low.radiation != "none"
    tables = sound_tables(low, face, air=is_wet)
    air = air_of(low, tables) if is_wet else None
    excitation = excitation_of(low.acoustics, tables[MODAL_FORCE])
    return 20 * np.log10(mode_accelerations(frequency, mass, ratio, excitation, air))
