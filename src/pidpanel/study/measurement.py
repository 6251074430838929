"""The section ``measurements`` of a study: measured PSDs and transmissibilities."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pidpanel.study.base import SectionModel, Text
from pidpanel.study.files import file_in
from pidpanel.study.mistakes import Mistake, mistakes_of_names, not_among
from pidpanel.study.quantity import whole

if TYPE_CHECKING:
    from pidpanel.study.study import Study


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


def mistakes_of_measurements(study: Study) -> Iterator[Mistake]:
    """Yield measurements of no point or scenario."""
    yield from mistakes_of_names("measurements", study.measurements)
    labels = [scenario.label for scenario in study.all_scenarios()]
    for name, measured in study.measurements.items():
        if measured.point not in study.panel.points:
            says = not_among("panel.points", measured.point, list(study.panel.points))
            yield Mistake(("measurements", name, "point"), says)
        if measured.excitation is not None and getattr(study, measured.excitation) is None:
            says = f"only allowed with a section {measured.excitation}"
            yield Mistake(("measurements", name, "excitation"), says)
        if measured.scenario is not None and measured.scenario not in labels:
            says = f"must be one of {', '.join(labels)}"
            yield Mistake(("measurements", name, "scenario"), says)
