"""The section ``scenarios`` of a study: families of one patch each, and explicit layouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Discriminator, Field, Tag, model_validator

from pidpanel.paths import SECTION
from pidpanel.study.base import Fill, Level, SectionModel, Text
from pidpanel.study.choice import TAG, Choice
from pidpanel.study.mistakes import Keys, Mistake

MOST_SCENARIOS = 1000  # scenarios that a family may have
Varied = Literal["patch", "fill_fraction", "oaspl_db"]
T = TypeVar("T")


def items_of(key: str, value: T | tuple[T, ...]) -> Iterator[tuple[Keys, T]]:
    """Yield each item of a key that may be a list, with the way to it."""
    if isinstance(value, tuple):
        yield from (((key, index), item) for index, item in enumerate(value))
    else:
        yield (key,), value


class Family(SectionModel):
    """One comparison, with a list for patch, fill_fraction or oaspl_db; or a single scenario."""

    patch: Annotated[Text | tuple[Text, ...], Choice()]
    """Filled patch, by its name under ``panel.patches``; a list compares patches."""
    damper: Text | None = None
    """Name under ``dampers``; may be left out where there is only one."""
    fill_fraction: Annotated[Fill | tuple[Fill, ...], Choice()] | None = None
    """Required unless the damper needs none, such as constants."""
    oaspl_db: Annotated[Level | tuple[Level, ...], Choice()] | None = None
    """Overall sound pressure level [dB]; by default that of the section ``sound``."""
    title: Text = ""
    """Title of the comparison in the report."""

    @model_validator(mode="before")
    @classmethod
    def _compare_one(cls, values: Any) -> Any:
        if not isinstance(values, Mapping) or not isinstance(values.get("patch"), str):
            return values
        if any(isinstance(values.get(key), list | tuple) for key in ("fill_fraction", "oaspl_db")):
            return values
        return {**values, "patch": [values["patch"]]}

    def mistakes(self) -> Iterator[Mistake]:
        for key in self._lists():
            count = len(getattr(self, key))
            if not count:
                yield Mistake((key,), "must have at least 1 value, not 0")
            elif count > MOST_SCENARIOS:
                yield Mistake((key,), f"must have at most {MOST_SCENARIOS} values, not {count}")
        lists = len(self._lists())
        if lists > 1:
            message = f"only one of patch, fill_fraction and oaspl_db may be a list, not {lists}"
            yield Mistake((), message)

    def fillings(self) -> Iterator[FilledPatches]:
        """Yield the key path of each filling, the patches with their paths, and the filling."""
        yield (), list(items_of("patch", self.patch)), self

    @property
    def varied(self) -> Varied:
        """The key that is a list."""
        return self._lists()[0]

    def _lists(self) -> list[Varied]:
        keys: tuple[Varied, ...] = ("patch", "fill_fraction", "oaspl_db")
        return [key for key in keys if isinstance(getattr(self, key), tuple)]


class Filled(SectionModel):
    """Damper on a patch of a layout."""

    damper: Text | None = None
    """Name under ``dampers``; may be left out where there is only one."""
    fill_fraction: Fill | None = None
    """Required unless the damper needs none, such as constants."""


class Layout(SectionModel):
    """A single scenario with any number of patches, each with its damper and fill fraction."""

    layout: Annotated[Mapping[str, Filled], Field(min_length=1)]
    """Patches by their names under ``panel.patches``."""
    oaspl_db: Level | None = None
    """Overall sound pressure level [dB]; by default that of the section ``sound``."""
    title: Text = ""
    """Title of the layout in the report."""

    def fillings(self) -> Iterator[FilledPatches]:
        """Yield each patch like `Family.fillings`."""
        for patch, filled in self.layout.items():
            yield ("layout", patch), [((), patch)], filled


FilledPatches = tuple[Keys, list[tuple[Keys, str]], Family | Filled]
FAMILY, LAYOUT = f"{TAG}family", f"{TAG}layout"


def _kind(values: Any) -> str:
    """Return which of the two an entry of ``scenarios`` is: a layout has the key ``layout``."""
    if isinstance(values, Layout) or (isinstance(values, Mapping) and "layout" in values):
        return LAYOUT
    return FAMILY


# An entry of ``scenarios``.
Compared = Annotated[
    Annotated[Family, Tag(FAMILY)] | Annotated[Layout, Tag(LAYOUT)], Discriminator(_kind)
]


class Filling(SectionModel):
    """A patch and what it is filled with."""

    patch: str
    damper: str | None  # None where laws and tables for any patch are the only dampers
    fill_fraction: float | None  # None where the damper needs none

    @property
    def place(self) -> tuple[str, ...]:
        """The patch, and the damper where it has a name of its own."""
        return (self.patch,) if self.damper in (None, SECTION) else (self.patch, str(self.damper))


class Scenario(SectionModel):
    """One response: a layout of filled patches, or the bare panel, at one level.

    Its label names it in tables and files: the key of an explicit layout, or such as
    ``PID-1_steel_r0.5_162dB``, without the damper where the study has one.
    """

    label: str
    fillings: tuple[Filling, ...]  # empty for the bare panel
    oaspl_db: float | None  # overall level [dB]; None for that of the spectrum's table

    @staticmethod
    def bare_at(oaspl_db: float | None) -> Scenario:
        """Return the bare panel at a level.

        Examples
        --------
        >>> Scenario.bare_at(None).label, Scenario.bare_at(142.5).label
        ('bare', 'bare_142.5dB')
        """
        return Scenario(label=f"bare{level_suffix(oaspl_db)}", fillings=(), oaspl_db=oaspl_db)

    @staticmethod
    def of_patch(filling: Filling, oaspl_db: float | None, *, has_dampers: bool) -> Scenario:
        """Return the panel with one filled patch at a level; its damper is named among several."""
        parts = [filling.patch]
        if filling.damper is not None and has_dampers:
            parts.append(filling.damper)
        if filling.fill_fraction is not None:
            parts.append(f"r{filling.fill_fraction:g}")
        label = "_".join(parts) + level_suffix(oaspl_db)
        return Scenario(label=label, fillings=(filling,), oaspl_db=oaspl_db)

    @property
    def bare(self) -> Scenario:
        """The bare panel at the same level."""
        return Scenario.bare_at(self.oaspl_db)

    @property
    def is_bare(self) -> bool:
        """Whether no patch is filled."""
        return not self.fillings

    @property
    def patches(self) -> tuple[str, ...]:
        """Names of the filled patches."""
        return tuple(filling.patch for filling in self.fillings)

    @property
    def patch(self) -> str | None:
        """Names of the filled patches in one text; None for the bare panel.

        Examples
        --------
        >>> one, two = (Filling(patch=name, damper=None, fill_fraction=0.5) for name in "AB")
        >>> Scenario(label="both", fillings=(one, two), oaspl_db=None).patch
        'A+B'
        """
        return "+".join(self.patches) or None

    @property
    def fill_fraction(self) -> float:
        """The fill of the only patch; 0 for the bare panel, NaN for several or for no fill."""
        if self.is_bare:
            return 0.0
        fills = [filling.fill_fraction for filling in self.fillings]
        return fills[0] if len(fills) == 1 and fills[0] is not None else math.nan

    @property
    def layout_label(self) -> str:
        """Label without the sound level."""
        return self.label.removesuffix(level_suffix(self.oaspl_db))

    @property
    def name(self) -> str:
        """The scenario without its sound level as a reader knows it.

        Examples
        --------
        >>> half = Filling(patch="PID-1", damper=None, fill_fraction=0.5)
        >>> Scenario(label="PID-1_r0.5", fillings=(half,), oaspl_db=None).name
        'PID-1, r = 0.5'
        """
        if self.is_bare:
            return "bare panel"
        text = self.filling_text
        return text if len(self.fillings) == 1 else f"{self.label} ({text})"

    @property
    def filling_text(self) -> str:
        """The filled patches with dampers and fills."""
        parts = []
        for filling in self.fillings:
            fill = [] if filling.fill_fraction is None else [f"r = {filling.fill_fraction:g}"]
            parts.append(", ".join([*filling.place, *fill]))
        return "; ".join(parts)


def level_suffix(oaspl_db: float | None) -> str:
    """Return how a label ends for a level [dB]; nothing where none is stated."""
    return "" if oaspl_db is None else f"_{oaspl_db:g}dB"
