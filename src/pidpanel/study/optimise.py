"""The section ``optimise`` of a study: dampers placed within a mass budget."""

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pidpanel.study.base import Fill, SectionModel, Size, Text
from pidpanel.study.mistakes import Mistake, mistakes_of_names
from pidpanel.study.panel import Area
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.response import Frequency

LEAST_BAND = 1.1  # ratio of the ends of a band: 40 natural frequencies are in a decade
MOST_FILLS = 50  # fill fractions on each place; every one is searched
MOST_PATCHES = 6  # patches of a layout; the search grows steeply with them


class DampingLayer(SectionModel):
    """A damping layer over the whole panel, to which layouts of the same mass are compared."""

    mass_per_area_kg_m2: Annotated[float, Quantity(1e-3, 100, unit="mass_per_area")]
    """Mass per area of the layer [kg/m²]."""
    loss_factor: Annotated[float, Quantity(1e-5, 1, unit="percent")]
    """Loss factor that it adds to all modes of the panel; a lighter layer adds less in
    proportion."""


class Optimise(SectionModel):
    """Search for the places, fill fractions and dampers that reduce the response most."""

    mass_kg: Annotated[float, Quantity(0, 1000, low_itself=False, unit="mass")]
    """Mass budget of all dampers together [kg]."""
    patch_size_m: tuple[Size, Size] | None = None
    """Lengths of a patch along x and y [m]; on a structure in the axes of its drawing."""
    patches: tuple[Text, ...] = ()
    """Patches of the panel or structure to choose from, by name, in place of a grid of places of
    one size. Two with elements in common are not filled together."""
    patches_at_most: Annotated[int, whole(1, MOST_PATCHES)] = 3
    """Largest number of patches in a layout."""
    spacing_m: tuple[Size, Size] | None = None
    """Distance between the places of a patch along x and y [m]; by default half of the patch."""
    dampers: tuple[Text, ...] = ()
    """Dampers to choose from, by name; by default all of the study."""
    fill_fraction: tuple[Fill, ...] = ()
    """Fill fractions to choose from, for dampers that have one."""
    points: tuple[Text, ...] = ()
    """Response points of the objective; by default all."""
    objective: Literal["largest", "mean_square", "panel", "stress", "oscillators"] = "largest"
    """Quantity to minimise: the ``largest`` rms acceleration of the points, or their mean square;
    that over the ``panel``, at 24 further vertices; the largest von Mises ``stress`` of 3σ at the
    points; the largest rms acceleration of ``oscillators`` on the points, in ``band_hz``."""
    excitation: Literal["sound", "base", "both"] | None = None
    """Excitation of the search: ``sound``, the random motion of ``base``, or ``both``, with the
    smaller reduction; by default all that the study has."""
    band_hz: tuple[Frequency, Frequency] | None = None
    """Natural frequencies of the oscillators [Hz]."""
    quality: Annotated[float, Quantity(1, 50)] = 10.0
    """Q of the oscillators."""
    damping_layer: DampingLayer | None = None
    """Damping layer to compare with; by default none."""
    forbidden: Mapping[str, Area] = {}
    """Areas without dampers, by name. Holes, supports and masses need no mention."""

    forms: ClassVar = (("mass_kg", "patch_size_m"), ("mass_kg", "patches"))

    def mistakes(self) -> Iterator[Mistake]:
        yield from mistakes_of_names("forbidden", self.forbidden)
        for key in {"spacing_m", "forbidden"} & self.model_fields_set if self.patches else ():
            yield Mistake((key,), "only allowed with patch_size_m")
        if self.objective == "oscillators" and self.band_hz is None:
            yield Mistake(("band_hz",), "missing; required for the objective oscillators")
        if self.objective != "oscillators":
            for key in {"band_hz", "quality"} & self.model_fields_set:
                yield Mistake((key,), "only allowed with objective: oscillators")
        if self.objective == "panel" and self.points:
            yield Mistake(("points",), "not allowed together with objective: panel")
        for key in ("dampers", "fill_fraction", "points", "patches"):
            values = getattr(self, key)
            if len(set(values)) < len(values):
                yield Mistake((key,), "has a value twice")
        if len(self.fill_fraction) > MOST_FILLS:
            message = f"must have at most {MOST_FILLS} values, not {len(self.fill_fraction)}"
            yield Mistake(("fill_fraction",), message)

    @property
    def spacing(self) -> tuple[float, float] | None:
        """Distance between places along x and y [m]; None among patches."""
        if self.patch_size_m is None:
            return None
        x, y = self.patch_size_m
        return self.spacing_m or (x / 2, y / 2)
