"""The section ``measurements`` of a study: measured PSDs and transmissibilities."""

from pathlib import Path
from typing import Annotated, Literal

from pidpanel.study.base import SectionModel, Text, file_in
from pidpanel.study.quantity import whole


class Measurement(SectionModel):
    """A measured acceleration PSD or transmissibility of a response point."""

    file: Annotated[Path, file_in()]
    """CSV table with ``frequency_hz`` and ``acceleration_psd_g2_hz`` or ``transmissibility``, or a
    universal file (data set 58)."""
    point: Text
    """Response point, by name."""
    scenario: Text | None = None
    """Label of the scenario that was tested; by default the first, the bare panel."""
    excitation: Literal["sound", "base"] | None = None
    """What excited the panel; by default the sound where there is a section ``sound``. A
    transmissibility is always of base motion."""
    record: Annotated[int, whole(1, 10_000)] | None = None
    """Number of the data set 58 in a universal file that has several."""
