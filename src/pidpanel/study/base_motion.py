"""The section ``base`` of a study: motion of the supports on a shaker, along the normal."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

from pidpanel.paths import DATA
from pidpanel.study.base import Acceleration, SectionModel, file_in
from pidpanel.study.mistakes import Mistake
from pidpanel.study.places import Along
from pidpanel.study.quantity import Quantity
from pidpanel.study.response import LEAST_SPAN

Frequency = Annotated[float, Quantity(0.5, 20000, unit="kilohertz")]
GRms = Annotated[float, Quantity(0, 500, low_itself=False, unit="gravities")]
PsdLimit = Annotated[float, Quantity(0, 1e6, low_itself=False)]
ForceLimit = Annotated[float, Quantity(0, 1e12, low_itself=False)]


class RandomMotion(SectionModel):
    """A random acceleration of the supports."""

    spectrum: Annotated[Path, file_in(DATA / "base")]
    """Table of break points, relative to the study or from pidpanel: ``frequency_hz``,
    ``acceleration_psd_g2_hz`` and optionally ``slope_db_octave`` from a row to the next."""
    overall_g: GRms | None = None
    """Overall acceleration that the table is meant to have [g rms]; checked within 3 %."""


class SineMotion(SectionModel):
    """A slow sine sweep of the supports, up and down."""

    frequency_hz: tuple[Frequency, Frequency]
    """Lowest and highest frequency [Hz]."""
    acceleration_g: Annotated[float, Quantity(0, 200, low_itself=False, unit="gravities")]
    """Amplitude of the acceleration of the supports [g]."""

    def mistakes(self) -> Iterator[Mistake]:
        """Yield frequencies that do not increase."""
        if self.frequency_hz[1] < LEAST_SPAN * self.frequency_hz[0]:
            yield Mistake(("frequency_hz",), "must be two values, the second above the first")


class PointLimit(SectionModel):
    """Limits of the acceleration of a point."""

    psd_g2_hz: PsdLimit | None = None
    """Largest PSD [g²/Hz]."""
    rms_g: GRms | None = None
    """Largest overall acceleration [g rms]."""
    needed: ClassVar = ("psd_g2_hz", "rms_g")


class InterfaceLimit(SectionModel):
    """Limits of the force of all supports together."""

    psd_n2_hz: ForceLimit | None = None
    """Largest PSD [N²/Hz]."""
    rms_n: ForceLimit | None = None
    """Largest overall force [N rms]."""
    needed: ClassVar = ("psd_n2_hz", "rms_n")


class Notching(SectionModel):
    """Limits that the random input is lowered to meet, band by band."""

    points: Mapping[str, PointLimit] = {}
    """Limits of the acceleration, by response point."""
    force: InterfaceLimit | None = None
    """Limits of the interface force."""


class BaseMotion(SectionModel):
    """Motion of all supports together along the normal.

    The panel is in vacuum, and the scenarios are those of the study, once for each layout.
    """

    random: RandomMotion | None = None
    """Random motion."""
    sine: SineMotion | None = None
    """Sine sweep."""
    notching: Notching | None = None
    """Limits that lower the random motion; those of ``limits`` judge and lower nothing."""
    direction: Along | None = None
    """Direction of the motion of a structure (x, y, z); by default z. A panel moves along its
    normal."""
    steady_acceleration_g: Acceleration | None = None
    """Steady acceleration as in the section ``sound`` [g]; if both have one, that of ``sound``
    counts."""
    removed_keys: ClassVar[Mapping[str, str]] = {"limits": "is called notching, with the same keys"}
    needed: ClassVar = ("random", "sine")

    @property
    def parts(self) -> dict[str, bool]:
        """Parts that the section has; notching without a limit is none."""
        lowers = self.notching is not None and bool(self.notching.points or self.notching.force)
        has_random, has_sine = self.random is not None, self.sine is not None
        return {"random": has_random, "notching": lowers, "sine": has_sine}

    def mistakes(self) -> Iterator[Mistake]:
        """Yield notching without a random motion."""
        if self.notching is not None and self.random is None:
            yield Mistake(("notching",), "only allowed with base.random")


def sound_or_base(sound: Any, info: ValidationInfo) -> Any:
    """Refuse a study with neither; a section base that is wrong is reported on its own."""
    if sound is None and info.data.get("base", sound_or_base) is None:
        raise PydanticCustomError("missing", "missing")
    return sound
