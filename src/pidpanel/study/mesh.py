"""The key ``mesh`` of a panel: quadrilaterals, triangles, or a file."""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator

from pidpanel.constants import PLACING_CARDS
from pidpanel.study.base import SectionModel, Text, by_kind, file_in
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity, whole

MESH_SUFFIXES = (".bdf", ".dat", ".nas", ".fem", ".inp", ".blk", ".msh")  # in any case
Count = Annotated[int, whole(2, 5000)]  # of elements along an edge
# Elements that a mesh may have: its modes take more memory than a machine has.
MOST_ELEMENTS = 400_000


def _check_suffix(file: Path) -> Path:
    if file.suffix.lower() not in MESH_SUFFIXES:
        raise ValueError(f"must end in one of {', '.join(MESH_SUFFIXES)}")
    return file


def _check_ignored_card(card: str) -> str:
    if not re.fullmatch("[A-Z][A-Z0-9]{1,7}", card) or PLACING_CARDS.match(card):
        raise ValueError("must be the name of a card that has no nodes or elements of the panel")
    return card


class Quadrilaterals(SectionModel):
    """Structured quadrilaterals of a rectangle with a thin section."""

    kind: Literal["quadrilaterals"] = "quadrilaterals"
    """A rectangle with a thin section; the default."""
    elements: tuple[Count, Count] = (30, 20)
    """Number of quadrilaterals along x and y."""

    def mistakes(self) -> Iterator[Mistake]:
        if (count := math.prod(self.elements)) > MOST_ELEMENTS:
            yield Mistake(("elements",), f"{count:.3g} elements; allowed are {MOST_ELEMENTS}")


class Triangles(SectionModel):
    """Triangles, for any panel."""

    kind: Literal["triangles"]
    """Any panel."""
    size_m: Annotated[float, Quantity(1e-5, 10, unit="metres")]
    """Edge length of triangles [m]."""
    corner_size_m: Annotated[float, Quantity(1e-6, 10, unit="metres")] | None = None
    """Edge length at re-entrant corners and rims of feet [m]; by default 0.002 of size_m, and a
    tenth of the radius of a foot on thin plates."""


class MeshFile(SectionModel):
    """A mesh from a file of gmsh or Nastran."""

    kind: Literal["file"]
    """A mesh from a file."""
    file: Annotated[Path, AfterValidator(_check_suffix), file_in()]
    """Mesh file: .msh (gmsh), or .bdf, .dat, .nas, .fem, .inp or .blk (Nastran bulk
    data)."""
    unit_m: Annotated[float, Quantity(1e-6, 1)] = 1.0
    """Length unit of the file [m]: 0.001 for millimetres."""
    ignore: tuple[Annotated[str, AfterValidator(_check_ignored_card)], ...] = ()
    """Cards of a Nastran file to ignore, such as SPC1, CONM2 and RBE2, because the study states
    supports and masses. They are counted. Cards that place nodes or elements are not allowed."""
    refine: Annotated[int, whole(0, 4)] = 0
    """How often the elements of a file are divided in four, where they are too coarse."""
    groups: tuple[Text, ...] = ()
    """Groups of a Nastran file that the panel consists of: properties (``"12"``) and sets
    (``SET 7``); all shells by default. Other cards are counted then, and need no ``ignore``."""

    def mistakes(self) -> Iterator[Mistake]:
        for key in ("ignore", "groups"):
            if getattr(self, key) and self.file.suffix.lower() == ".msh":
                yield Mistake((key,), "only allowed with a Nastran file")
        if self.ignore and self.groups:
            yield Mistake(("ignore",), "not needed with groups")


Mesh = Annotated[Quadrilaterals | Triangles | MeshFile, *by_kind("quadrilaterals")]
