"""The section of a panel: a thin or a thick plate, or a sandwich of plies and a core."""

import difflib
import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from pidpanel.columns import read_rows
from pidpanel.paths import DATA
from pidpanel.study.base import Density, PoissonsRatio, SectionModel, Text, by_kind
from pidpanel.study.mistakes import Mistake, not_among
from pidpanel.study.quantity import Quantity, inside
from pidpanel.study.units import InSI

FACES_FILE = DATA / "materials" / "faces.csv"  # materials of faces by name
CORE_GRADES_FILE = DATA / "materials" / "honeycomb_5056.csv"  # honeycomb cores by their grade

Modulus = Annotated[float, Quantity(1e-3, 1500, unit="gigapascal")]  # of a solid [GPa]
ShearModulus = Annotated[float, Quantity(1, 20000, unit="megapascal")]  # of a core [MPa]
Thickness = Annotated[float, Quantity(0.05, 1000, unit="millimetres")]  # of a panel [mm]
Angle = Annotated[float, Quantity(-360, 360)]  # [°]
StiffnessFactor = Annotated[float, Quantity(0.1, 10)]
STIFFEST = 1.1e12  # Young's modulus of diamond [Pa]
HEAVIEST = 22600.0  # density of osmium [kg/m³]
ROUNDED = 0.01  # relative error of values that are stated with few digits


class ThinSectionInput(SectionModel):
    """A thin (Kirchhoff) plate, by its mass per area and its bending stiffness."""

    kind: Literal["thin"] = "thin"
    """A thin plate; the default."""
    mass_per_area_kg_m2: Annotated[float, Quantity(0.01, 1000, unit="mass_per_area")]
    """Mass per area [kg/m²]."""
    bending_stiffness_n_m: Annotated[float, Quantity(1e-3, 1e8, unit="bending_stiffness")]
    """Bending stiffness D [N m]."""
    thickness_mm: Thickness = 25.0
    """Thickness for strains at the surfaces, and for stresses of an equivalent homogeneous plate
    [mm]."""
    poissons_ratio: PoissonsRatio = 0.3
    """Poisson's ratio of the bending stiffness."""
    extensional_stiffness_n_m: Annotated[float, Quantity(1, 1e12)] | None = None
    """Extensional stiffness E t/(1 − ν²) of the faces together, for stretching at large deflections
    [N/m]. By default that of a homogeneous plate, 12 D/t²; two thin faces have 4 D/t²."""

    thickness: ClassVar = InSI("thickness_mm")

    @property
    def properties(self) -> tuple[float, float, float, float, float | None]:
        """D [N m], mass per area [kg/m²], ν, thickness [m], extensional stiffness [N/m]."""
        D, mass = self.bending_stiffness_n_m, self.mass_per_area_kg_m2
        return D, mass, self.poissons_ratio, self.thickness, self.extensional_stiffness_n_m

    def mistakes(self) -> Iterator[Mistake]:
        D, thickness = self.bending_stiffness_n_m, self.thickness
        if (density := self.mass_per_area_kg_m2 / thickness) > HEAVIEST:
            message = f"{density:.3g} kg/m³ with thickness_mm = {self.thickness_mm:g}; at most "
            yield Mistake(("mass_per_area_kg_m2",), f"{message}{HEAVIEST:g}, of osmium")
        if (modulus := 12 * (1 - self.poissons_ratio**2) * D / thickness**3) > STIFFEST:
            hint = f"; {D:.7g} N mm would be {D * 1e-3:g}" if modulus * 1e-3 <= STIFFEST else ""
            message = f"{modulus:.3g} Pa with thickness_mm = {self.thickness_mm:g}; at most "
            yield Mistake(("bending_stiffness_n_m",), f"{message}{STIFFEST:g}, of diamond{hint}")
        least, extensional = 4 * D / self.thickness**2, self.extensional_stiffness_n_m
        if extensional is not None and extensional < least * (1 - ROUNDED):
            message = f"must be at least {least:.4g}, 4 D/t² of two faces as far apart as the panel"
            yield Mistake(("extensional_stiffness_n_m",), f"{message} is thick")


class SolidSectionInput(SectionModel):
    """A thick plate of one isotropic material, with transverse shear and rotary inertia."""

    kind: Literal["solid"]
    """A thick plate of one material."""
    youngs_modulus_gpa: Modulus
    """Young's modulus [GPa]."""
    poissons_ratio: PoissonsRatio = 0.3
    """Poisson's ratio."""
    density_kg_m3: Density
    """Density [kg/m³]."""
    thickness_mm: Thickness
    """Thickness [mm]."""

    youngs_modulus: ClassVar = InSI("youngs_modulus_gpa")
    thickness: ClassVar = InSI("thickness_mm")

    @property
    def properties(self) -> tuple[float, float, float, float]:
        """E [Pa], ν, density [kg/m³], thickness [m]."""
        return self.youngs_modulus, self.poissons_ratio, self.density_kg_m3, self.thickness


class MaterialInput(SectionModel):
    """A ply's material: isotropic (E, ν), or orthotropic (E1, E2, G12, ν12)."""

    density_kg_m3: Density
    """Density [kg/m³]."""
    youngs_modulus_gpa: Modulus | None = None
    """Young's modulus of an isotropic material [GPa]."""
    poissons_ratio: PoissonsRatio | None = None
    """Poisson's ratio of an isotropic material."""
    e1_gpa: Modulus | None = None
    """Young's modulus along the fibre [GPa]."""
    e2_gpa: Modulus | None = None
    """Young's modulus across the fibre [GPa]."""
    g12_gpa: Modulus | None = None
    """In-plane shear modulus [GPa]."""
    nu12: Annotated[float, inside(-2, 2)] | None = None
    """Major Poisson's ratio: transverse over longitudinal strain under tension along the fibre."""

    youngs_modulus: ClassVar = InSI("youngs_modulus_gpa")
    e1: ClassVar = InSI("e1_gpa")
    e2: ClassVar = InSI("e2_gpa")
    g12: ClassVar = InSI("g12_gpa")

    forms: ClassVar = (
        ("youngs_modulus_gpa", "poissons_ratio"),
        ("e1_gpa", "e2_gpa", "g12_gpa", "nu12"),
    )

    def mistakes(self) -> Iterator[Mistake]:
        if self.nu12 is not None and self.nu12**2 * (self.e2_gpa or 0.0) >= (self.e1_gpa or 0.0):
            yield Mistake(("nu12",), "must be below sqrt(e1_gpa/e2_gpa)")


class PlyInput(SectionModel):
    """A layer of a face."""

    material: Text
    """Name under ``materials``, or of a material in ``workflow/data/materials/faces.csv``."""
    thickness_mm: Annotated[float, Quantity(0.005, 100, unit="millimetres")]
    """Thickness [mm]."""
    angle_deg: Angle = 0.0
    """Angle from the panel's x to the fibre [°]."""

    thickness: ClassVar = InSI("thickness_mm")
    angle: ClassVar = InSI("angle_deg")


class CoreInput(SectionModel):
    """A honeycomb core by its grade (``workflow/data/materials``) or by its moduli."""

    thickness_mm: Annotated[float, Quantity(0.5, 1000, unit="small_millimetres")]
    """Thickness [mm]."""
    grade: Text | None = None
    """Grade in ``workflow/data/materials/honeycomb_5056.csv``, instead of moduli and density."""
    shear_modulus_l_mpa: ShearModulus | None = None
    """Transverse shear modulus along the ribbon, G_L [MPa]."""
    shear_modulus_w_mpa: ShearModulus | None = None
    """Transverse shear modulus across the ribbon, G_W [MPa]."""
    density_kg_m3: Annotated[float, Quantity(5, 3000, unit="core_density")] | None = None
    """Density [kg/m³]."""
    ribbon_deg: Angle = 0.0
    """Angle from the panel's x to the ribbon (L) direction [°]."""

    forms: ClassVar = (("grade",), ("density_kg_m3", "shear_modulus_l_mpa", "shear_modulus_w_mpa"))

    def mistakes(self) -> Iterator[Mistake]:
        if self.grade is not None and self.grade not in (grades := core_grades()):
            near = difflib.get_close_matches(self.grade, grades, n=3, cutoff=0.0)
            yield Mistake(("grade",), f"unknown grade; the nearest are {', '.join(near)}")

    thickness: ClassVar = InSI("thickness_mm")
    ribbon: ClassVar = InSI("ribbon_deg")

    @property
    def properties(self) -> tuple[float, float, float]:
        """G_L and G_W [Pa], and the density [kg/m³]."""
        stated = (self.shear_modulus_l_mpa, self.shear_modulus_w_mpa, self.density_kg_m3)
        G_L, G_W, density = stated if self.grade is None else core_grades()[self.grade]
        return (G_L or 0.0) * 1e6, (G_W or 0.0) * 1e6, density or 0.0

    @property
    def cell_width_mm(self) -> float | None:
        """Width of its cells across flats [mm], by the grade; None without one."""
        return None if self.grade is None else core_cell_width_mm(self.grade)


def core_cell_width_mm(grade: str) -> float | None:
    """Return the width of the cells of a core [mm]; None if the grade does not begin with it.

    Examples
    --------
    >>> round(core_cell_width_mm("3/16-5056-0.0007"), 4)
    4.7625
    """
    inches = re.match(r"([1-9])/([1-9][0-9]?)-", grade)
    return None if inches is None else 25.4 * int(inches[1]) / int(inches[2])


def core_grades() -> dict[str, tuple[float, float, float]]:
    """Return G_L and G_W [MPa] and the density [kg/m³] of the known cores, by grade."""
    rows = (cells for _, cells in read_rows(CORE_GRADES_FILE).rows)
    return {grade: (float(G_L), float(G_W), float(density)) for grade, density, G_L, G_W in rows}


@cache
def face_materials() -> dict[str, MaterialInput]:
    """Return the materials of faces that come with pidpanel, by name."""
    table = read_rows(FACES_FILE)
    rows = (dict(zip(table.header, cells, strict=True)) for _, cells in table.rows)
    return {
        row.pop("material"): MaterialInput.model_validate(
            {key: cell for key, cell in row.items() if cell and key != "source"}
        )
        for row in rows
    }


class SandwichSectionInput(SectionModel):
    """Two laminated faces on a honeycomb core, with its shear."""

    kind: Literal["sandwich"]
    """Two faces on a core."""
    materials: Mapping[str, MaterialInput] = {}
    """Materials of the plies, by name, besides those of ``workflow/data/materials/faces.csv``."""
    faces: Annotated[tuple[PlyInput, ...], Field(min_length=1)] | None = None
    """Plies of both faces, the outermost first."""
    top: Annotated[tuple[PlyInput, ...], Field(min_length=1)] | None = None
    """Plies of the upper face (+z), outermost first; with ``bottom``, instead of ``faces``."""
    bottom: Annotated[tuple[PlyInput, ...], Field(min_length=1)] | None = None
    """Plies of the lower face (−z), the outermost first."""
    core: CoreInput
    """The honeycomb core."""
    extra_mass_per_area_kg_m2: Annotated[float, Quantity(0, 500, unit="mass_per_area")] = 0.0
    """Adhesive, solar cells: mass without stiffness."""
    bending_factor: StiffnessFactor = 1.0
    """Bending stiffness over that of the plies, such as from a test."""
    shear_factor: StiffnessFactor = 1.0
    """Shear stiffness over that of the core."""

    forms: ClassVar = (("faces",), ("top", "bottom"))

    def mistakes(self) -> Iterator[Mistake]:
        for key in ("faces", "top", "bottom"):
            for index, ply in enumerate(getattr(self, key) or ()):
                if ply.material not in self.all_materials:
                    message = not_among("materials", ply.material, list(self.all_materials))
                    yield Mistake((key, index, "material"), message)
            thickness = sum(ply.thickness_mm for ply in getattr(self, key) or ())
            if thickness > self.core.thickness_mm:
                message = (
                    f"{thickness:g} mm thick, more than the core of {self.core.thickness_mm:g} "
                )
                yield Mistake((key,), f"{message}mm: faces must be thinner than the core")

    @property
    def all_materials(self) -> dict[str, MaterialInput]:
        """Materials that a ply may have, by name; one of the study before one of the table."""
        return {**self.materials, **face_materials(), **self.materials}

    def plies(self, side: Literal["top", "bottom"]) -> tuple[PlyInput, ...]:
        """Return the plies of a face, the outermost first."""
        return self.faces or getattr(self, side)

    @property
    def thickness_mm(self) -> float:
        """Thickness of the core and both faces [mm]."""
        faces = sum(p.thickness_mm for p in (*self.plies("top"), *self.plies("bottom")))
        return self.core.thickness_mm + faces

    thickness: ClassVar = InSI("thickness_mm")


Section = Annotated[ThinSectionInput | SolidSectionInput | SandwichSectionInput, *by_kind("thin")]
