"""The sections ``response`` and ``measurements`` of a study: what is computed and measured."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pidpanel.study.base import SectionModel, Text, file_in
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.structure import Structure

if TYPE_CHECKING:
    from pidpanel.study.study import Study

Frequency = Annotated[float, Quantity(0.5, 20000, unit="kilohertz")]  # [Hz]
Radiation = Literal["none", "one_side", "two_sides"]

# Least ratio of the highest frequency to the lowest: several bandwidths of a resonance.
LEAST_SPAN = 1.02


class Response(SectionModel):
    """The frequencies of the response, and the terms of the panel's equation of motion."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "radiation_beside": "was removed; run a copy of the study with response.radiation, and "
        "pidpanel compare both"
    }

    frequency_hz: tuple[Frequency, Frequency] = (20.0, 2000.0)
    """Lowest and highest frequency [Hz]."""
    damper_mass: bool = True
    """Whether the apparent mass of the particles is added to the panel."""
    modal_damping: Literal["full", "diagonal"] = "full"
    """``full``: the whole modal damping matrix; ``diagonal``: the paper's Eq. 9–12, with
    the damping at the motion of the full matrix."""
    radiation: Radiation | None = None
    """Sides of a panel in a baffle that radiate into the air and carry its mass; by default none,
    as in the paper. A panel with other ``sound.surroundings`` has air on both faces by default,
    and none with ``none``."""
    air_mass: bool = True
    """Whether a panel in a baffle carries the mass of the air on the sides that radiate; false:
    resistance alone."""
    maps: tuple[Text, ...] = ()
    """Scenarios, by their names in summary.csv, to map over the panel; by default the first bare
    panel, and the scenario with the least motion at its worst point."""

    def mistakes(self) -> Iterator[Mistake]:
        if self.frequency_hz[1] <= self.frequency_hz[0]:
            yield Mistake(("frequency_hz",), "must be two values, the second above the first")
        elif self.frequency_hz[1] < LEAST_SPAN * self.frequency_hz[0]:
            message = f"the second must be at least {LEAST_SPAN:g} times the first"
            yield Mistake(("frequency_hz",), f"spans hardly a resonance; {message}")
        if self.modal_damping == "diagonal" and self.radiation not in (None, "none"):
            message = "must be none for modal_damping: diagonal, the paper's form"
            yield Mistake(("radiation",), message)


class Energy(SectionModel):
    """Frequencies above those of the response, by statistical energy."""

    highest_hz: Frequency = 8000.0
    """Highest frequency of the PSDs [Hz]; dampers have theirs to the end of their data."""


def mistakes_of_energy(study: "Study") -> Iterator[Mistake]:
    """Yield what statistical energy does not go together with."""
    if study.energy is None or study.sound is None:
        return
    if isinstance(study.panel, Structure):
        yield Mistake(("energy",), "only allowed with a panel, flat and of one section")
    if study.sound.field != "diffuse":
        yield Mistake(("energy",), "only allowed with sound.field: diffuse")
    if study.sound.wall < float("inf"):
        yield Mistake(("energy",), "not allowed with a wall behind the panel")
    highest = study.response.frequency_hz[1]
    if study.energy.highest_hz <= highest:
        message = f"must be above the highest of response.frequency_hz, {highest:g}"
        yield Mistake(("energy", "highest_hz"), message)


class Measurement(SectionModel):
    """A measured acceleration PSD, transmissibility or accelerance of a response point."""

    file: Annotated[Path, file_in()]
    """CSV table with ``frequency_hz`` and ``acceleration_psd_g2_hz``, ``transmissibility`` or
    ``accelerance_1_kg``, or a universal file (data set 58)."""
    point: Text
    """Response point, by name."""
    scenario: Text | None = None
    """Label of the scenario that was tested; by default the first, the bare panel."""
    excitation: Literal["sound", "base"] | None = None
    """What excited the panel; by default the sound where there is a section ``sound``. A
    transmissibility is always of base motion."""
    record: Annotated[int, whole(1, 10_000)] | None = None
    """Number of the data set 58 in a universal file that has several."""
    node: Annotated[int, whole(0, 2_000_000_000)] | None = None
    """Response node of the data set 58 in a universal file that has several."""
    direction: Literal["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"] | None = None
    """Direction of the response of that data set; without a sign either."""
    drive: Text | None = None
    """Response point that a hammer hits; of an acceleration over force, which is compared with the
    bare panel."""
