"""The key ``shell`` of a structure: its shape, its elements, what holds it and what it carries."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field

from pidpanel.study.base import SectionModel, Size, Text, by_kind, file_in
from pidpanel.study.mistakes import Mistake
from pidpanel.study.panel import Length
from pidpanel.study.places import Along, Place, SurfaceArea
from pidpanel.study.quantity import Quantity
from pidpanel.study.section import Section
from pidpanel.study.units import InSI

Offset = Annotated[float, Quantity(-0.5, 0.5, unit="metres")]
DECKS = (".bdf", ".dat", ".nas", ".fem", ".blk")  # in any case
SURFACE_SUFFIXES = (".msh", ".step", ".stp")  # in any case


def _check_deck(file: Path) -> Path:
    if file.suffix.lower() not in DECKS:
        raise ValueError(f"must end in one of {', '.join(DECKS)}")
    return file


def _check_suffix(file: Path) -> Path:
    if file.suffix.lower() not in SURFACE_SUFFIXES:
        raise ValueError(f"must end in one of {', '.join(SURFACE_SUFFIXES)}")
    return file


class Paraboloid(SectionModel):
    """A reflector z = r²/4F about z, from its hub to its rim."""

    kind: Literal["paraboloid"]
    """A reflector."""
    diameter_m: Length
    """Diameter of the rim [m]."""
    focal_length_m: Annotated[float, Quantity(0.01, 100, unit="metres")]
    """Focal length F [m]."""
    hub_diameter_m: Annotated[float, Quantity(0, 30, unit="metres")] = 0.0
    """Diameter of the hole in the middle [m]."""

    def mistakes(self) -> Iterator[Mistake]:
        if self.hub_diameter_m >= self.diameter_m:
            yield Mistake(("hub_diameter_m",), f"must be below diameter_m = {self.diameter_m:g}")


class CylinderPanel(SectionModel):
    """A panel curved about x, symmetric to y = 0, its crown at z = radius_m."""

    kind: Literal["cylinder_panel"]
    """A panel curved in one direction."""
    radius_m: Annotated[float, Quantity(0.01, 100, unit="metres")]
    """Radius [m]."""
    length_m: Length
    """Length along x [m]."""
    arc_m: Length
    """Length along the arc [m]."""


class FlatPanels(SectionModel):
    """Flat panels in space, joined where they touch."""

    kind: Literal["panels"]
    """One flat panel, or several that meet at kinks, T-joints and hinges."""
    corners_m: Annotated[
        Mapping[Text, Annotated[tuple[Place, ...], Field(min_length=3)]], Field(min_length=1)
    ]
    """Corners (x, y, z) in order [m], by the name of the panel."""


class SurfaceFile(SectionModel):
    """A surface from a file of gmsh, or a STEP file."""

    kind: Literal["file"]
    """A surface from a file."""
    file: Annotated[Path, AfterValidator(_check_suffix), file_in()]
    """Triangles in .msh (gmsh, order 1 to 4), or faces in .step."""
    unit_m: Annotated[float, Quantity(1e-6, 1)] = 1.0
    """Length unit of a .msh file [m]; a STEP file states its own."""


class DeckSurface(SectionModel):
    """The shells of a Nastran deck, as they are meshed there."""

    kind: Literal["deck"]
    """The shells of a deck."""
    file: Annotated[Path, AfterValidator(_check_deck), file_in()]
    """Nastran bulk data: .bdf, .dat, .nas, .fem or .blk. Its facets are flat."""
    unit_m: Annotated[float, Quantity(1e-6, 1)] = 1.0
    """Length unit of the file [m]."""
    groups: tuple[Text, ...] = ()
    """Properties (``"12"``) and sets (``SET 7``) that count; all shells by default."""


Form = Annotated[Paraboloid | CylinderPanel | FlatPanels | SurfaceFile | DeckSurface, *by_kind()]


class ShellSupportInput(SectionModel):
    """A support of what lies within an area: an edge, the rim of a hub."""

    where: SurfaceArea
    """Part of space whose nodes are held."""
    kind: Literal["clamped", "pinned"] = "clamped"
    """``clamped``: no motion and no rotation; ``pinned``: no motion."""


class Foot(SectionModel):
    """A rigid foot, such as a hold-down, a hub or one side of a hinge."""

    where: SurfaceArea
    """Part of space whose nodes move as one body."""
    centre_m: Place
    """Place of its mass and its support (x, y, z) [m]."""
    kind: Literal["clamped", "pinned", "free"] = "clamped"
    """``clamped``: it does not move; ``pinned``: it turns about its centre; ``free``: it moves."""
    mass_kg: Annotated[float, Quantity(0, 2000, unit="mass")] = 0.0
    """Mass [kg]."""


class HingeInput(SectionModel):
    """A hinge between two feet, which turn against each other about its axis alone."""

    feet: tuple[Text, Text]
    """Names of both feet."""
    at_m: Place
    """Place on the axis (x, y, z) [m]."""
    axis: Along
    """Direction of the axis."""
    stiffness_n_m_rad: Annotated[float, Quantity(0, 1e9)] = 0.0
    """Stiffness against turning [N m/rad]."""


class ShellMass(SectionModel):
    """A mass at a point of the surface."""

    mass_kg: Annotated[float, Quantity(1e-6, 2000, unit="mass")]
    """Mass [kg]."""
    at_m: Place
    """Position (x, y, z) [m]."""


class StiffenerInput(SectionModel):
    """A straight beam of rectangular section on the surface."""

    from_m: Place
    """Start (x, y, z) [m]."""
    to_m: Place
    """End (x, y, z) [m]."""
    width_mm: Annotated[float, Quantity(0.1, 1000)]
    """Width along the surface [mm]."""
    height_mm: Annotated[float, Quantity(0.1, 1000)]
    """Height along the normal [mm]."""
    offset_mm: Annotated[float, Quantity(-1000, 1000)] = 0.0
    """Distance of its middle from the surface, along the normal [mm]."""
    youngs_modulus_gpa: Annotated[float, Quantity(1e-3, 1500, unit="gigapascal")]
    """Young's modulus [GPa]."""
    poissons_ratio: Annotated[float, Quantity(0, 0.5)] = 0.3
    """Poisson's ratio."""
    density_kg_m3: Annotated[float, Quantity(5, 25000, unit="density")]
    """Density [kg/m³]."""

    width: ClassVar = InSI("width_mm")
    height: ClassVar = InSI("height_mm")
    offset: ClassVar = InSI("offset_mm")
    youngs_modulus: ClassVar = InSI("youngs_modulus_gpa")


class PartInput(SectionModel):
    """The section of a part of a shell."""

    section: Section
    """Mass and stiffness through the thickness."""
    axis: Along | None = None
    """Direction (x, y, z) of the x axis of the section; by default that of the shell."""
    offset_m: Offset = 0.0
    """Distance of the middle of the section from the surface along its normal [m]."""


class Shell(SectionModel):
    """A shell that is meshed here."""

    form: Form
    """Its shape."""
    section: Section
    """Mass and stiffness through the thickness."""
    axis: Along = (1.0, 0.0, 0.0)
    """Direction (x, y, z) whose projection on the surface is the x axis of the section."""
    offset_m: Offset = 0.0
    """Distance of the middle of the section from the surface along its normal [m]."""
    size_m: Size
    """Length of the edges of elements [m], of order 4: a third of the shortest wave, which
    ``pidpanel check`` states where it is longer."""
    parts: Mapping[str, PartInput] = {}
    """Sections of parts, by the name of the panel, physical surface, face or property; others have
    ``section``. Stresses are not computed with them."""
    supports: Mapping[str, ShellSupportInput] = {}
    """Supports, by name."""
    feet: Mapping[str, Foot] = {}
    """Rigid feet, by name."""
    hinges: Mapping[str, HingeInput] = {}
    """Hinges between feet, by name."""
    masses: Mapping[str, ShellMass] = {}
    """Masses, by name."""
    stiffeners: Mapping[str, StiffenerInput] = {}
    """Stiffeners along straight lines, by name."""

    def mistakes(self) -> Iterator[Mistake]:
        names = [*self.supports, *self.feet, *self.hinges, *self.masses, *self.stiffeners]
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield Mistake((), f"{name} names two of supports, feet, hinges, masses and stiffeners")
        for name, hinge in self.hinges.items():
            for index, foot in enumerate(hinge.feet):
                if foot not in self.feet:
                    message = f"must be one of structure.shell.feet: {', '.join(self.feet)}"
                    yield Mistake(("hinges", name, "feet", index), message)
