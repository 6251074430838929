"""The section ``panel`` of a study: outline, section, supports, masses, mesh, patches, points."""

from __future__ import annotations

import csv
import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from pidpanel.paths import DATA
from pidpanel.polygon import Circle, Polygon, Rectangle, Shape, check_panel
from pidpanel.study.base import Model, Positive

Position = tuple[float, float]
EdgeKind = Literal["simply_supported", "simply_supported_soft", "clamped", "free"]
MESH_SUFFIXES = (".bdf", ".dat", ".nas", ".msh")
CORE_GRADES_FILE = DATA / "materials" / "honeycomb_5056.csv"
"""Honeycomb cores by their grade."""

Number = Annotated[int, Field(ge=1)]


class ThinSection(Model):
    """A thin (Kirchhoff) plate by its areal mass and bending stiffness."""

    kind: Literal["thin"] = "thin"
    mass_per_area_kg_m2: Positive
    bending_stiffness_n_m: Positive
    thickness_mm: Positive = 25.0
    """Strains are read at its surfaces, stresses as if it were of one material."""
    poissons_ratio: Annotated[float, Field(gt=-1, lt=0.5)] = 0.3

    @property
    def thickness(self) -> float:
        return self.thickness_mm * 1e-3


class SolidSection(Model):
    """A thick plate of one isotropic material, with transverse shear and rotary inertia."""

    kind: Literal["solid"]
    youngs_modulus_gpa: Positive
    poissons_ratio: Annotated[float, Field(gt=-1, lt=0.5)] = 0.3
    density_kg_m3: Positive
    thickness_mm: Positive

    @property
    def thickness(self) -> float:
        return self.thickness_mm * 1e-3


class Material(Model):
    """A ply's material: isotropic (E, ν), or orthotropic (E1, E2, G12, ν12)."""

    density_kg_m3: Positive
    youngs_modulus_gpa: Positive | None = None
    poissons_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None
    e1_gpa: Positive | None = None
    e2_gpa: Positive | None = None
    g12_gpa: Positive | None = None
    nu12: float | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Material:
        given = self.model_fields_set - {"density_kg_m3"}
        if given == {"e1_gpa", "e2_gpa", "g12_gpa", "nu12"}:
            if self.nu12**2 >= self.e1_gpa / self.e2_gpa:  # type: ignore[operator]
                raise ValueError(f"nu12 = {self.nu12:g}: below sqrt(e1_gpa/e2_gpa)")
        elif given != {"youngs_modulus_gpa", "poissons_ratio"}:
            raise ValueError(
                "either youngs_modulus_gpa and poissons_ratio, or e1_gpa, e2_gpa, g12_gpa and nu12"
            )
        return self


class Ply(Model):
    """A layer of a face; the angle is from the panel's x to the fibre."""

    material: str
    thickness_mm: Positive
    angle_deg: float = 0.0


class Core(Model):
    """A honeycomb core by its grade (``workflow/data/materials``) or by its moduli."""

    thickness_mm: Positive
    grade: str | None = None
    shear_modulus_l_mpa: Positive | None = None
    shear_modulus_w_mpa: Positive | None = None
    density_kg_m3: Positive | None = None
    ribbon_deg: float = 0.0
    """From the panel's x to the ribbon (L) direction."""

    @model_validator(mode="after")
    def _grade_or_moduli(self) -> Core:
        given = self.model_fields_set - {"thickness_mm", "ribbon_deg"}
        moduli = {"shear_modulus_l_mpa", "shear_modulus_w_mpa", "density_kg_m3"}
        if given not in ({"grade"}, moduli):
            raise ValueError(f"either grade, or {', '.join(sorted(moduli))}")
        if self.grade is not None:
            grades = core_grades()
            if self.grade not in grades:
                near = difflib.get_close_matches(self.grade, grades, n=3, cutoff=0.0)
                raise ValueError(f"grade = {self.grade}: unknown; nearest are {', '.join(near)}")
        return self

    @property
    def properties(self) -> tuple[float, float, float]:
        """G_L, G_W in Pa and the density in kg/m³."""
        if self.grade is not None:
            G_L, G_W, density = core_grades()[self.grade]
        else:
            G_L, G_W = self.shear_modulus_l_mpa or 0.0, self.shear_modulus_w_mpa or 0.0
            density = self.density_kg_m3 or 0.0
        return G_L * 1e6, G_W * 1e6, density


def core_grades() -> dict[str, tuple[float, float, float]]:
    """Known cores: G_L and G_W in MPa and density in kg/m³ by grade."""
    with CORE_GRADES_FILE.open(encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {
            row["grade"]: (
                float(row["shear_modulus_l_mpa"]),
                float(row["shear_modulus_w_mpa"]),
                float(row["density_kg_m3"]),
            )
            for row in rows
        }


class SandwichSection(Model):
    """Two laminated faces on a honeycomb core, with its shear."""

    kind: Literal["sandwich"]
    materials: Annotated[Mapping[str, Material], Field(min_length=1)]
    faces: Annotated[tuple[Ply, ...], Field(min_length=1)] | None = None
    """Plies of both faces, the outermost first."""
    top: Annotated[tuple[Ply, ...], Field(min_length=1)] | None = None
    bottom: Annotated[tuple[Ply, ...], Field(min_length=1)] | None = None
    core: Core
    extra_mass_per_area_kg_m2: Annotated[float, Field(ge=0)] = 0.0
    """Adhesive, solar cells: mass without stiffness."""

    @model_validator(mode="after")
    def _faces(self) -> SandwichSection:
        given = [face is not None for face in (self.faces, self.top, self.bottom)]
        if given not in ([True, False, False], [False, True, True]):
            raise ValueError("either faces, or top and bottom")
        for ply in (*self.plies("top"), *self.plies("bottom")):
            if ply.material not in self.materials:
                raise ValueError(
                    f"material = {ply.material}: one of materials, {', '.join(self.materials)}"
                )
        return self

    def plies(self, side: Literal["top", "bottom"]) -> tuple[Ply, ...]:
        """Plies of a face, the outermost first."""
        return self.faces or getattr(self, side)

    @property
    def thickness_mm(self) -> float:
        faces = sum(p.thickness_mm for p in (*self.plies("top"), *self.plies("bottom")))
        return self.core.thickness_mm + faces

    @property
    def thickness(self) -> float:
        return self.thickness_mm * 1e-3


def _section_kind(data: Any) -> str | None:
    kind = data.get("kind", "thin") if isinstance(data, dict) else getattr(data, "kind", None)
    return str(kind).capitalize() if kind in ("thin", "solid", "sandwich") else None


Section = Annotated[
    Annotated[ThinSection, Tag("Thin")]
    | Annotated[SolidSection, Tag("Solid")]
    | Annotated[SandwichSection, Tag("Sandwich")],
    Discriminator(
        _section_kind,
        custom_error_type="section_kind",
        custom_error_message="kind: 'thin', 'solid' or 'sandwich'",
    ),
]


class Mesh(Model):
    """Structured quadrilaterals (rectangle, thin plate), triangles, or a file."""

    kind: Literal["quadrilaterals", "triangles", "file"] = "quadrilaterals"
    elements: tuple[Annotated[int, Field(ge=2)], Annotated[int, Field(ge=2)]] = (30, 20)
    size_m: Positive | None = None
    corner_size_m: Positive | None = None
    """Element size at re-entrant corners; 0.002 of size_m if left out."""
    file: Path | None = None
    unit_m: Positive = 1.0
    """The unit of length of the file, in m: 0.001 if it counts in mm."""

    @model_validator(mode="after")
    def _keys_of_kind(self) -> Mesh:
        if (self.kind == "triangles") != (self.size_m is not None):
            raise ValueError("size_m goes with kind: triangles, and only with it")
        if self.corner_size_m is not None and self.kind != "triangles":
            raise ValueError("corner_size_m goes only with kind: triangles")
        if (self.kind == "file") != (self.file is not None):
            raise ValueError(
                "file (.bdf, .dat, .nas or .msh) goes with kind: file, and only with it"
            )
        if self.file is not None and self.file.suffix not in MESH_SUFFIXES:
            raise ValueError(f"file = {self.file}: one of {', '.join(MESH_SUFFIXES)}")
        return self


class Area(Model):
    """A rectangle (centre_m, size_m), a circle (centre_m, diameter_m) or a polygon (corners_m)."""

    centre_m: Position | None = None
    size_m: tuple[Positive, Positive] | None = None
    diameter_m: Positive | None = None
    corners_m: Annotated[tuple[Position, ...], Field(min_length=3)] | None = None
    corner_radius_m: Annotated[float, Field(ge=0)] = 0.0
    _kinds: ClassVar[str] = "centre_m with size_m or diameter_m, or corners_m"

    @model_validator(mode="after")
    def _one_shape(self) -> Area:
        given = {key for key in self.model_fields_set if getattr(self, key) is not None}
        if given - {"corner_radius_m"} not in (
            {"centre_m", "size_m"}, {"centre_m", "diameter_m"}, {"corners_m"}, *self._more()
        ):  # fmt: skip
            raise ValueError(f"{', '.join(sorted(given)) or 'nothing'} given: {self._kinds}")
        if self.corner_radius_m and self.corners_m is None:
            raise ValueError("corner_radius_m goes with corners_m, and only with it")
        return self

    def _more(self) -> tuple[set[str], ...]:
        return ()

    def _disc(self, centre: Position, radius: float) -> Circle:
        return Circle(centre, radius)

    @property
    def shape(self) -> Shape | None:
        """The area in m, None where a mesh file has it."""
        if self.corners_m is not None:
            return Polygon(self.corners_m, self.corner_radius_m)
        if self.centre_m is None:
            return None
        if self.size_m is not None:
            return Rectangle(self.centre_m, self.size_m)
        return self._disc(self.centre_m, (self.diameter_m or 0.0) / 2)


class Patch(Area):
    """Cells that may be filled with particles; or a group (property number) of a mesh file."""

    group: str | None = None
    _kinds: ClassVar[str] = f"{Area._kinds}, or group"

    @model_validator(mode="before")
    @classmethod
    def _group_is_text(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("group"), int):
            data = {**data, "group": str(data["group"])}
        return data

    def _more(self) -> tuple[set[str], ...]:
        return ({"group"},)

    def _disc(self, centre: Position, radius: float) -> Circle:
        return Circle.of_equal_area(centre, radius)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, x_max, y_min, y_max) in m."""
        corners = self.shape.corners  # type: ignore[union-attr]
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return tuple(round(float(v), 12) for v in (x0, x1, y0, y1))  # type: ignore[return-value]


class Node(Model):
    """A node of a mesh file, by its number there."""

    grid: Number


class PointSupport(Model):
    """Support at a point: hinge (w = 0), hold_down (w = 0, no slope), or a spring to ground."""

    kind: Literal["hinge", "hold_down", "spring"]
    at_m: Position | None = None
    grid: Number | None = None
    radius_m: Annotated[float, Field(ge=0)] = 0.0
    """Of the stiff foot of a hinge or a hold-down; 0 for a mere point."""
    stiffness_n_m: Positive | None = None

    @model_validator(mode="after")
    def _keys_of_kind(self) -> PointSupport:
        _one_place(self.at_m, self.grid)
        if (self.kind == "spring") != (self.stiffness_n_m is not None):
            raise ValueError("stiffness_n_m goes with kind: spring, and only with it")
        if self.kind == "spring" and self.radius_m:
            raise ValueError("radius_m goes with kind: hinge or hold_down")
        return self


def _one_place(at_m: Position | None, grid: int | None) -> None:
    if (at_m is None) == (grid is None):
        raise ValueError("either at_m, or grid (a node of a mesh file)")


class EdgeSupport(Model):
    """Support of a straight part of the boundary, which differs from the rest."""

    from_m: Position
    to_m: Position
    kind: EdgeKind


class Supports(Model):
    """What holds the panel: its outline, rims of holes, parts of edges, points."""

    outline: EdgeKind
    holes: EdgeKind = "free"
    edges: tuple[EdgeSupport, ...] = ()
    points: Mapping[str, PointSupport] = {}


class Mass(Model):
    """A mass at a point (at_m or grid) or spread along a line (from_m, to_m)."""

    mass_kg: Positive
    at_m: Position | None = None
    grid: Number | None = None
    from_m: Position | None = None
    to_m: Position | None = None

    @model_validator(mode="after")
    def _one_place(self) -> Mass:
        if self.model_fields_set - {"mass_kg"} not in ({"at_m"}, {"grid"}, {"from_m", "to_m"}):
            raise ValueError("either at_m, or grid (a node of a mesh file), or from_m and to_m")
        return self


class Panel(Model):
    """The panel, its patches and the points at which it is listened to."""

    outline_m: (
        tuple[Positive, Positive] | Annotated[tuple[Position, ...], Field(min_length=3)] | None
    ) = None
    """Lengths along x and y of a rectangle, or the corners of a polygon."""
    corner_radius_m: Annotated[float, Field(ge=0)] = 0.0
    holes: Mapping[str, Area] = {}
    section: Section
    supports: EdgeKind | Supports = "simply_supported"
    masses: Mapping[str, Mass] = {}
    damping_ratio: Annotated[float, Field(gt=0, lt=0.5)] = 0.01
    mesh: Mesh = Mesh()
    patches: Mapping[str, Patch]
    points: Annotated[Mapping[str, Position | Node], Field(min_length=1)]

    @model_validator(mode="before")
    @classmethod
    def _names_are_text(cls, data: Any) -> Any:
        if isinstance(data, dict):
            data = dict(data)
            for key in ("patches", "points", "holes", "masses"):
                if isinstance(data.get(key), dict):
                    data[key] = {str(name): value for name, value in data[key].items()}
        return data

    @property
    def files(self) -> tuple[str, ...]:
        """Files on which the panel rests: its mesh, the table that its core is taken from."""
        core = getattr(self.section, "core", None)
        of_ours = CORE_GRADES_FILE if core is not None and core.grade is not None else None
        return tuple(str(path) for path in (self.mesh.file, of_ours) if path is not None)

    @property
    def size(self) -> tuple[float, float] | None:
        """Lengths along x and y in m of a rectangle without holes and rounded corners."""
        match self.outline_m:
            case (float(a), float(b)) if not self.holes and not self.corner_radius_m:
                return a, b
        return None

    @property
    def outline(self) -> Polygon | None:
        """The outer edge in m, None where a mesh file has it."""
        match self.outline_m:
            case None:
                return None
            case (float(a), float(b)):
                return Polygon(((0.0, 0.0), (a, 0.0), (a, b), (0.0, b)), self.corner_radius_m)
            case corners:
                return Polygon(tuple((x, y) for x, y in corners), self.corner_radius_m)

    @property
    def held(self) -> Supports:
        """The supports, written out."""
        if isinstance(self.supports, str):
            return Supports(outline=self.supports)
        return self.supports

    @model_validator(mode="after")
    def _fits_together(self) -> Panel:
        from_file = self.mesh.kind == "file"
        if from_file == (self.outline_m is not None):
            raise ValueError("either outline_m, or mesh: {kind: file}, which brings its outline")
        if from_file and (self.holes or self.corner_radius_m):
            raise ValueError("holes and corner_radius_m go with outline_m; a mesh file has its own")
        if self.mesh.kind == "quadrilaterals":
            if self.size is None or any(
                not isinstance(patch.shape, Rectangle) for patch in self.patches.values()
            ):
                raise ValueError(
                    "mesh.kind = quadrilaterals: only a rectangle with rectangular patches; "
                    "mesh: {kind: triangles, size_m: ...} takes any"
                )
            if self.section.kind != "thin" or any(p.radius_m for p in self.held.points.values()):
                raise ValueError(
                    "mesh.kind = quadrilaterals: only a thin section, supports without radius_m; "
                    "mesh: {kind: triangles, size_m: ...} takes any"
                )
        if not from_file:
            for key, named in (
                ("points", self.points),
                ("supports.points", self.held.points),
                ("masses", self.masses),
            ):
                for name, place in named.items():
                    if getattr(place, "grid", None) is not None:
                        raise ValueError(f"{key}.{name}.grid: goes with mesh: {{kind: file}}")
            for name, patch in self.patches.items():
                if patch.group is not None:
                    raise ValueError(f"patches.{name}.group: goes with mesh: {{kind: file}}")
        return self

    @model_validator(mode="after")
    def _on_the_panel(self) -> Panel:
        at = {name: point for name, point in self.points.items() if isinstance(point, tuple)}
        if self.size is not None:
            length, width = self.size
            for name, patch in self.patches.items():
                x0, x1, y0, y1 = patch.bounds
                if x0 < 0 or y0 < 0 or x1 > length or y1 > width:
                    raise ValueError(
                        f"patches.{name} covers x {x0:g}…{x1:g} m, y {y0:g}…{y1:g} m: "
                        f"it must lie on the panel, x 0…{length:g} m, y 0…{width:g} m"
                    )
            for name, (x, y) in at.items():
                if not (0 <= x <= length and 0 <= y <= width):
                    raise ValueError(
                        f"points.{name} = ({x:g}, {y:g}) m: it must lie on the panel, "
                        f"x 0…{length:g} m, y 0…{width:g} m"
                    )
        elif self.outline is not None:
            check_panel(
                self.outline,
                {name: hole.shape for name, hole in self.holes.items() if hole.shape},
                {name: patch.shape for name, patch in self.patches.items() if patch.shape},
                at,
            )
        return self
