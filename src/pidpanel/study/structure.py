"""The section ``structure`` of a study: a shell or the modes of another solver."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import AfterValidator, Discriminator, Field, Tag

from pidpanel.damping_ratio import DampingRatio
from pidpanel.study.base import SectionModel, Text, file_in
from pidpanel.study.choice import TAG
from pidpanel.study.damping_ratio import DampingRatios, damping_ratio_of, mistakes_of_damping_ratio
from pidpanel.study.mistakes import Mistake, mistakes_of_names
from pidpanel.study.panel import Panel
from pidpanel.study.places import Along, SurfaceArea, SurfacePoint
from pidpanel.study.quantity import Quantity
from pidpanel.study.section import SandwichSectionInput, SolidSectionInput, ThinSectionInput
from pidpanel.study.shell import Shell
from pidpanel.study.supports import Mass, SupportsInput

MODE_SUFFIXES = (".vtu", ".unv", ".uff", ".op2", ".frd")  # in any case
KEY = "structure"  # of a study, in place of its panel


def _check_suffix(file: Path) -> Path:
    if file.suffix.lower() not in MODE_SUFFIXES:
        raise ValueError(f"must end in one of {', '.join(MODE_SUFFIXES)}")
    return file


class ModesFile(SectionModel):
    """Modes from a file of another solver."""

    file: Annotated[Path, AfterValidator(_check_suffix), file_in()]
    """File with the modes: .vtu (neutral form), .unv or .uff (data set 55), .op2 (Nastran), .frd
    (CalculiX)."""
    mesh: Annotated[Path, file_in()] | None = None
    """File with nodes and elements where that of the modes has none: a Nastran deck, an input of
    CalculiX."""
    unit_m: Annotated[float, Quantity(1e-6, 1)] | None = None
    """Length unit of the files [m]: 0.001 for millimetres; not needed where a file states it."""
    unit_kg: Annotated[float, Quantity(1e-6, 1e4)] | None = None
    """Mass unit of the files [kg]. By default metres imply kg, and millimetres t."""
    static: Annotated[Path, AfterValidator(_check_suffix), file_in()] | None = None
    """File with static cases, if they are not with the modes."""
    pressures: tuple[Text, ...] = ()
    """Groups of elements under a pressure of 1 in the static cases, in their order: such as the
    quarters of each patch. They give what the modes leave out under dampers."""
    normalised: Literal["mass"] | None = None
    """``mass`` where a file without modal masses has shapes of 1 kg modal mass in SI units."""
    uniform_mass: bool = False
    """Whether ``mass_kg`` is spread evenly over the surface: it gives the modal masses and the
    inertia of a file without modal masses."""


class UnknownSection(NamedTuple):
    """The section of a structure whose modes come from a file."""

    stated_mm: float | None  # thickness [mm]
    kind: str = "unknown"

    @property
    def thickness_mm(self) -> float:
        """Thickness [mm]; infinite where it is not stated."""
        return self.stated_mm or math.inf

    @property
    def thickness(self) -> float:
        """Thickness [m]."""
        return self.thickness_mm / 1000


AnySection = ThinSectionInput | SolidSectionInput | SandwichSectionInput | UnknownSection


class Structure(SectionModel):
    """A structure of any shape: its modes, its surface, its patches and points."""

    kind: Literal["structure"] = "structure"
    """Tells a structure from a panel."""
    modes: ModesFile | None = None
    """Modes of another solver."""
    shell: Shell | None = None
    """A shell that is meshed here."""
    mass_kg: Annotated[float, Quantity(1e-3, 5000, unit="mass")] | None = None
    """Mass of the structure [kg], with ``modes``; the modal masses are compared with it."""
    surface: tuple[Text, ...] = ()
    """Groups of elements that the sound loads, with ``modes``; all by default."""
    outward: Along | None = None
    """Direction of the normals (x, y, z); by default away from the middle of the surface."""
    thickness_mm: Annotated[float, Quantity(0.05, 1000)] | None = None
    """Thickness of the structure [mm], with ``modes``, where a wall needs it."""
    damping_ratio: DampingRatios = 0.01
    """Damping ratio ζ of the modes, as of a panel."""
    patches: Mapping[str, SurfaceArea] = {}
    """Areas whose cells may be filled, by name."""
    points: Annotated[Mapping[str, SurfacePoint], Field(min_length=1)]
    """Points at which the response is computed, by name."""

    forms: ClassVar = (("modes", "mass_kg"), ("shell",))
    # what a panel has, and a structure has not, or elsewhere
    masses: ClassVar[Mapping[str, Mass]] = {}
    size: ClassVar[None] = None
    single_points: ClassVar[tuple[str, ...]] = ()
    in_plane_edges: ClassVar[str] = "free"
    corner_size: ClassVar[None] = None
    support_input: ClassVar = SupportsInput(outline="clamped")

    def mistakes(self) -> Iterator[Mistake]:
        for key in ("patches", "points"):
            yield from mistakes_of_names(key, getattr(self, key))
        yield from mistakes_of_damping_ratio(self.damping_ratio)
        if self.shell is not None:
            for key in ("surface", "thickness_mm"):
                if getattr(self, key):
                    yield Mistake((key,), "only allowed with modes")

    @property
    def has_parts(self) -> bool:
        """Whether it has several sections."""
        return self.shell is not None and bool(self.shell.parts)

    @property
    def modal_damping(self) -> DampingRatio:
        """ζ of the modes; `ColumnsError` if its file has faults."""
        return damping_ratio_of(self.damping_ratio)

    @property
    def section(self) -> AnySection:
        """The section of a shell; what is known of it otherwise, of several the least thickness."""
        if self.shell is None:
            return UnknownSection(self.thickness_mm)
        sections = [self.shell.section, *(part.section for part in self.shell.parts.values())]
        thinnest = min(section.thickness_mm for section in sections)
        return UnknownSection(thinnest) if self.has_parts else self.shell.section


def with_structure(values: Any) -> Any:
    """Return the values of a study with its structure in place of the panel."""
    if not isinstance(values, Mapping) or not isinstance(values.get(KEY), Mapping):
        return values
    if "panel" in values:  # refused as an unknown key
        return values
    others = {key: value for key, value in values.items() if key != KEY}
    return {**others, "panel": {"kind": KEY, **values[KEY]}}


def _tag_of(values: Any) -> str:
    kind = values.get("kind") if isinstance(values, Mapping) else getattr(values, "kind", None)
    return TAG + (KEY if kind == KEY else "panel")


PanelOrStructure = Annotated[
    Annotated[Panel, Tag(f"{TAG}panel")] | Annotated[Structure, Tag(TAG + KEY)],
    Discriminator(_tag_of),
]
