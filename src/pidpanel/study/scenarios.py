"""The section ``scenarios`` of a study: families of one patch each, and explicit layouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

from pydantic import Discriminator, Field, Tag

from pidpanel.study.base import Acceleration, Fill, Level, SectionModel, Text, Vector, as_tuple
from pidpanel.study.choice import TAG, Choice
from pidpanel.study.mistakes import Keys, Mistake
from pidpanel.study.stated_number import FillFraction, OrStated

MOST_SCENARIOS = 1000  # scenarios that a family may have
Varied = Literal["patch", "damper", "fill_fraction", "oaspl_db"]
T = TypeVar("T")
Fills = Annotated[float | tuple[float, ...], OrStated(Fill | tuple[FillFraction, ...])]


def items_of(key: str, value: T | tuple[T, ...]) -> Iterator[tuple[Keys, T]]:
    """Yield each item of a key that may be a list, with the way to it."""
    if isinstance(value, tuple):
        yield from (((key, index), item) for index, item in enumerate(value))
    else:
        yield (key,), value


class Filling(SectionModel):
    """What fills a patch."""

    damper: Text | None = None
    """Name under ``dampers``; may be left out where there is only one."""
    fill_fraction: FillFraction | None = None
    """Required unless the damper needs none, such as constants. A mapping states its error too."""


class Part(NamedTuple):
    """Patches of an entry of ``scenarios`` and what may fill them, each with the way to it."""

    way: Keys  # from the entry
    patches: list[tuple[Keys, str]]
    dampers: list[tuple[Keys, str | None]]
    fills: list[tuple[Keys, float | None]]


class Family(SectionModel):
    """One comparison, with a list for patch, fill_fraction or oaspl_db; or a single scenario.

    ``damper`` may be a list as well: every scenario is then computed with each of them.
    """

    patch: Annotated[Text | tuple[Text, ...], Choice()]
    """Filled patch, by its name under ``panel.patches``; a list compares patches."""
    damper: Annotated[Text | tuple[Text, ...], Choice()] | None = None
    """Name under ``dampers``; may be left out where there is only one. A list compares dampers, or
    damping models of one."""
    fill_fraction: Fills | None = None
    """Required unless the damper needs none, such as constants. A mapping states its error too."""
    oaspl_db: Annotated[Level | tuple[Level, ...], Choice()] | None = None
    """Overall sound pressure level [dB]; by default that of the section ``sound``."""
    steady_acceleration_g: Acceleration | None = None
    """Steady acceleration of the particles in place of that of the section ``sound`` [g], such as
    at lift-off."""
    title: Text = ""
    """Title of the comparison in the report."""

    def mistakes(self) -> Iterator[Mistake]:
        keys = ("patch", "damper", "fill_fraction", "oaspl_db")
        lists = [key for key in keys if isinstance(getattr(self, key), tuple)]
        for key in lists:
            if not getattr(self, key):
                yield Mistake((key,), "must have at least 1 value, not 0")
        count = math.prod(len(getattr(self, key)) for key in lists)
        if count > MOST_SCENARIOS:
            yield Mistake(
                tuple(lists[:1]), f"must have at most {MOST_SCENARIOS} values, not {count}"
            )
        if len(set(lists) - {"damper"}) > 1:
            message = "only one of patch, fill_fraction and oaspl_db may be a list, not "
            yield Mistake((), f"{message}{len(set(lists) - {'damper'})}")
        dampers = as_tuple(self.damper)
        if len(set(dampers)) < len(dampers):
            yield Mistake(("damper",), "must not contain a damper twice")

    @property
    def is_single(self) -> bool:
        """Whether it has one patch and one fill."""
        return not isinstance(self.patch, tuple) and not isinstance(self.fill_fraction, tuple)

    @property
    def varied(self) -> Varied:
        """The key whose values are compared."""
        keys: tuple[Varied, ...] = ("fill_fraction", "oaspl_db", "patch", "damper")
        return next((key for key in keys if isinstance(getattr(self, key), tuple)), "patch")

    def parts(self) -> Iterator[Part]:
        """Yield the patches, dampers and fill fractions, of which every combination is meant."""
        keys = ("patch", "damper", "fill_fraction")
        yield Part((), *(list(items_of(key, getattr(self, key))) for key in keys))


class Layout(SectionModel):
    """A single scenario with any number of patches, each with its damper and fill fraction."""

    layout: Annotated[Mapping[str, Filling], Field(min_length=1)]
    """Patches by their names under ``panel.patches``."""
    oaspl_db: Level | None = None
    """Overall sound pressure level [dB]; by default that of the section ``sound``."""
    steady_acceleration_g: Acceleration | None = None
    """Steady acceleration of the particles in place of that of the section ``sound`` [g], such as
    at lift-off."""
    title: Text = ""
    """Title of the layout in the report."""

    def parts(self) -> Iterator[Part]:
        """Yield each patch like `Family.parts`."""
        for patch, filling in self.layout.items():
            damper, fill = (
                (("damper",), filling.damper),
                (("fill_fraction",), filling.fill_fraction),
            )
            yield Part(("layout", patch), [((), patch)], [damper], [fill])


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


class Scenario(SectionModel):
    """One response: a layout of filled patches, or the bare panel, at one level.

    Its label names it in tables and files: the key of an explicit layout, or such as
    ``PID-1_steel_r0.5_162dB``, without the damper where the study has one.
    """

    label: str
    fillings: Mapping[str, Filling] = {}  # by patch; none for the bare panel
    oaspl_db: float | None = None  # overall level [dB]; None for that of the spectrum's table
    steady_acceleration_g: Vector | None = None  # None for that of the dampers
    has_dampers: bool = False  # whether its study has several, so that names contain them

    @staticmethod
    def bare_at(oaspl_db: float | None) -> Scenario:
        """Return the bare panel at a level.

        Examples
        --------
        >>> Scenario.bare_at(None).label, Scenario.bare_at(142.5).label
        ('bare', 'bare_142.5dB')
        """
        return Scenario(label=f"bare{level_suffix(oaspl_db)}", oaspl_db=oaspl_db)

    @staticmethod
    def of_patch(
        patch: str,
        filling: Filling,
        oaspl_db: float | None,
        steady_acceleration_g: Vector | None = None,
        *,
        has_dampers: bool,
    ) -> Scenario:
        """Return the panel with one filled patch at a level; its damper is named among several."""
        parts = [patch]
        if filling.damper is not None and has_dampers:
            parts.append(filling.damper)
        if filling.fill_fraction is not None:
            parts.append(f"r{filling.fill_fraction:g}")
        label = "_".join(parts) + steady_suffix(steady_acceleration_g) + level_suffix(oaspl_db)
        return Scenario(
            label=label,
            fillings={patch: filling},
            oaspl_db=oaspl_db,
            steady_acceleration_g=steady_acceleration_g,
            has_dampers=has_dampers,
        )

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
        return tuple(self.fillings)

    @property
    def patch(self) -> str | None:
        """Names of the filled patches in one text; None for the bare panel.

        Examples
        --------
        >>> half = Filling(fill_fraction=0.5)
        >>> Scenario(label="both", fillings={"A": half, "B": half}).patch
        'A+B'
        """
        return "+".join(self.patches) or None

    @property
    def fill_fraction(self) -> float:
        """The fill of the only patch; 0 for the bare panel, NaN for several or for no fill."""
        if self.is_bare:
            return 0.0
        fills = [filling.fill_fraction for filling in self.fillings.values()]
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
        >>> half = {"PID-1": Filling(fill_fraction=0.5)}
        >>> Scenario(label="PID-1_r0.5", fillings=half).name
        'PID-1, r = 0.5'
        """
        if self.is_bare:
            return "bare panel"
        text = self.filling_text
        return text if len(self.fillings) == 1 else f"{self.layout_label} ({text})"

    def place(self, patch: str) -> tuple[str, ...]:
        """Return a patch, and its damper where the study has several."""
        return (patch, str(self.fillings[patch].damper)) if self.has_dampers else (patch,)

    @property
    def dampers(self) -> str:
        """Names of its dampers in one text."""
        return " and ".join(dict.fromkeys(str(f.damper) for f in self.fillings.values()))

    @property
    def filling_text(self) -> str:
        """The filled patches with dampers and fills."""
        parts = []
        for patch, filling in self.fillings.items():
            fill = [] if filling.fill_fraction is None else [f"r = {filling.fill_fraction:g}"]
            parts.append(", ".join([*self.place(patch), *fill]))
        if self.steady_acceleration_g is not None:
            parts.append(f"steady {vector_text(self.steady_acceleration_g)} g")
        return "; ".join(parts)

    def damper_name(self, patch: str) -> str:
        """Return the damper of a patch, with the steady acceleration of the scenario."""
        return f"{self.fillings[patch].damper}{steady_suffix(self.steady_acceleration_g)}"


def vector_text(vector: Vector) -> str:
    """Return a vector in words.

    Examples
    --------
    >>> vector_text((0.0, 0.0, -3.0))
    '(0, 0, -3)'
    """
    return f"({', '.join(f'{part:g}' for part in vector)})"


def steady_suffix(vector: Vector | None) -> str:
    """Return how a label ends for a steady acceleration [g]; nothing where none is stated.

    Examples
    --------
    >>> steady_suffix((3.0, 0.0, -1.0)), steady_suffix((0.0, 0.0, 0.0))
    ('_x3z-1g', '_0g')
    """
    if vector is None:
        return ""
    parts = zip("xyz", vector, strict=True)
    return f"_{''.join(f'{axis}{part:g}' for axis, part in parts if part) or '0'}g"


def level_suffix(oaspl_db: float | None) -> str:
    """Return how a label ends for a level [dB]; nothing where none is stated."""
    return "" if oaspl_db is None else f"_{oaspl_db:g}dB"
