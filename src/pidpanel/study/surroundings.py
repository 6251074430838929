"""The surroundings of a panel in words, and those that a study does not take."""

from collections.abc import Sequence

from pidpanel.study.mistakes import listed
from pidpanel.study.response import Radiation, Response
from pidpanel.study.sound import Sound

AIR = {"none": "no air", "one_side": "air on one face", "two_sides": "air included"}
FACES = {1: "one face", 2: "both faces"}
ALONE = {"plane_wave": "level of the wave alone", "sources": "level of the sources alone"}
FREE = {
    "diffuse": "free in the room",
    "plane_wave": "free in a plane wave",
    "sources": "free among sources",
    "measured": "free in a measured field",
}
LEVELS = {
    "surface": "level on the surface",
    "room": "level of the room",
    "incident": "level of the incident wave",
}


def setting(sound: Sound, radiation: Radiation) -> str:
    """Return where the panel hangs, its faces with sound and air, and the place of the level.

    Examples
    --------
    >>> from pathlib import Path
    >>> sound = Sound(spectrum=Path("any.csv"))
    >>> setting(sound, "none")
    'in a baffle, one face, no air; level on the surface'
    >>> setting(sound.model_copy(update={"surroundings": "free"}), "two_sides")
    'free in the room, both faces, air included; level of the room'
    """
    if not sound.is_free:
        place = "in a baffle"
    else:
        place = FREE[sound.field_name]
        if sound.wall < float("inf"):
            place += f", {sound.wall:g} m from a rigid wall"
    level = LEVELS[sound.reference]
    if sound.is_free:
        level = ALONE.get(sound.field_name, level)
    return f"{place}, {FACES[sound.faces]}, {AIR[radiation]}; {level}"


def opposite(sound: Sound, response: Response) -> dict[str, Sound | Response]:
    """Return the sections with the other surroundings by default; none for other fields."""
    if sound.field_name not in ("diffuse", "plane_wave") or sound.incidence_deg == 90:
        return {}
    surroundings = {
        "surroundings": "baffle" if sound.is_free else "free",
        "loaded_sides": None,
        "pressure_reference": None,
    }
    air = {"radiation": None, "air_mass": True}
    return {
        "sound": sound.model_copy(update=surroundings),
        "response": response.model_copy(update=air),
    }


def change_text(setting: str, frequency: Sequence[float], change: Sequence[float]) -> str:
    """Return what other surroundings change: frequencies of modes [Hz], changes of their rms [dB].

    Examples
    --------
    >>> change_text("baffle", [64.9, 124.8], [6.24, -0.96])
    'other surroundings (baffle) change the rms of the modes at 64.9 and 125 Hz by +6.2 and −1.0 dB'
    >>> change_text("baffle", [], [])
    'other surroundings: baffle; the change is not computed here'
    """
    if not len(change):
        return f"other surroundings: {setting}; the change is not computed here"
    modes = listed([f"{value:.3g}" for value in frequency])
    decibels = listed([f"{value:+.1f}".replace("-", "−") for value in change])
    word = "modes" if len(change) > 1 else "mode"
    rms = f"change the rms of the {word} at {modes} Hz by {decibels} dB"
    return f"other surroundings ({setting}) {rms}"
