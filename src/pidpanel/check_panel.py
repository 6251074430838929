"""What can be known of a panel in sound to be wrong before anything runs."""

from __future__ import annotations

from pidpanel.damping.laws import FREQUENCY_RANGE
from pidpanel.damping.tables import read_surface
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.sound.table import read_spl_table
from pidpanel.study import Study, StudyError


def check_panel(study: Study) -> None:
    """Refuse what could not be carried through.

    Raises
    ------
    ValueError
        `StudyError` and its like of the other stages: what is asked, what is allowed.
    """
    low, high = study.response.frequency_hz
    asked = f"response.frequency_hz = [{low:g}, {high:g}]"
    edges = read_spl_table(study.sound.spectrum).edge_frequency
    if low < edges[0] or high > edges[-1]:
        raise StudyError(
            f"{asked}: within the bands of {study.sound.spectrum.name}, "
            f"{edges[0]:.5g} to {edges[-1]:.5g} Hz"
        )
    for reading in study.damping.readings:
        if reading.startswith("paper") and not (
            FREQUENCY_RANGE[0] <= low and high <= FREQUENCY_RANGE[1]
        ):
            raise StudyError(
                f"{asked}: the paper's law holds from {FREQUENCY_RANGE[0]:g} to "
                f"{FREQUENCY_RANGE[1]:g} Hz"
            )
    if study.damping.table is not None:
        read_surface(study.damping.table)
    StudiedPanel(study.panel).check(high)
