"""Panels that must be equal: turned and mirrored ones, and those of a mesh file."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Polygon, Position, Rectangle
from pidpanel.panel.basis import PanelBasis, panel_basis, patch_areas
from pidpanel.panel.flat_mesh import read_gmsh
from pidpanel.panel.layup import Core, Material, Ply, SandwichSection
from pidpanel.panel.mesh import PanelMesh, write_triangles
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.nastran import read_nastran
from pidpanel.panel.supports import EdgeSupport, Supports
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.verification.rows import Row

HIGHEST = 900.0
CORNERS = ((0.0, 0.0), (0.9, 0.1), (0.8, 0.7), (0.1, 0.6))
CLAMPED = (CORNERS[1], CORNERS[2])
POINTS = {"A": (0.45, 0.3), "B": (0.3, 0.5)}
PATCH = Rectangle((0.45, 0.35), (0.2, 0.2))
TAPE = Material(280e9, 6.5e9, 4.5e9, 0.3, 1600.0)
TURN = np.radians(37.0)


@dataclass(frozen=True)
class PanelPair:
    """Two panels that must be equal."""

    name: str
    panel: PanelBasis
    reference: PanelBasis
    tolerance: float
    reason: str


def orthotropic(turn: float = 0.0, mirror: bool = False) -> SandwichSection:
    """Return a layup without any symmetry in the plane, turned, or seen in a mirror x → −x."""
    sign = -1 if mirror else 1

    def face(*angles: float) -> tuple[Ply, ...]:
        return tuple(Ply(TAPE, 0.15e-3, sign * np.radians(a) + turn) for a in angles)

    core = Core(310e6, 138e6, 50.0, 20e-3, sign * np.radians(25.0) + turn)
    return SandwichSection(face(20.0, 75.0), face(20.0, 75.0), core)


def panel_of(
    mesh: PanelMesh,
    section: SandwichSection,
    moved: Callable[[Position], Position] = lambda position: position,
) -> PanelBasis:
    """Return the basis of a panel that is clamped on one edge and supported on the others."""
    clamped = EdgeSupport(moved(CLAMPED[0]), moved(CLAMPED[1]), "clamped")
    plate = assemble_shear_plate(mesh, section, Supports("simply_supported", edges=[clamped]))
    return panel_basis(mesh, plate, 2 * HIGHEST)


def drawn(folder: Path) -> PanelMesh:
    """Return the mesh of the outline."""
    return mesh_triangles(folder / "panel.msh", Polygon(CORNERS), 0.08, {"P": PATCH}, POINTS)


def turned_panels(folder: Path) -> list[PanelPair]:
    """Return the panel turned and mirrored, its mesh and its layup with it, beside itself."""
    mesh = drawn(folder)
    plain = panel_of(mesh, orthotropic())
    reason = "the same elements turned; tolerance: rounding"

    def moved_by(matrix: Array) -> Callable[[Position], Position]:
        def moved(position: Position) -> Position:
            x, y = matrix @ np.array(position)
            return float(x), float(y)

        return moved

    pairs = []
    for name, turn, mirror in (
        ("turned by 37°", TURN, False),
        ("turned by 90°", np.pi / 2, False),
        ("mirrored", 0.0, True),
    ):
        matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        matrix = matrix @ np.diag([-1.0 if mirror else 1.0, 1.0])
        cells = mesh.cells[:, ::-1] if mirror else mesh.cells
        changed = replace(mesh, vertices=mesh.vertices @ matrix.T, cells=cells)
        basis = panel_of(changed, orthotropic(turn, mirror), moved_by(matrix))
        pairs.append(PanelPair(name, basis, plain, 1e-8, reason))
    return pairs


def filed_panels(folder: Path) -> list[PanelPair]:
    """Return the panel from a Nastran deck and a gmsh file beside that of its outline."""
    mesh = drawn(folder)
    plain = panel_of(mesh, orthotropic())
    deck, msh = folder / "panel.bdf", folder / "given.msh"
    write_bulk_data(deck, mesh)
    write_triangles(msh, mesh)
    pairs = []
    for name, flat, patch in (
        (".bdf, patch by its property number", read_nastran(deck), "2"),
        (".bdf, patch by its shape", read_nastran(deck), PATCH),
        (".bdf in millimetres", read_nastran(deck.with_suffix(".dat")).scaled(1e-3), PATCH),
        (".msh, patch by its shape", read_gmsh(msh), PATCH),
    ):
        meshed = flat.panel_mesh({"P": patch}, POINTS)
        basis = panel_of(meshed, orthotropic())
        reason = "the panel of the outline; tolerance: positions to nine figures"
        pairs.append(PanelPair(name, basis, plain, 1e-6, reason))
    return pairs


def write_bulk_data(path: Path, mesh: PanelMesh) -> None:
    """Write a mesh with its patch as property 2, and the same in mm as a ``.dat`` beside it."""
    in_patch = np.isin(np.arange(len(mesh.cells)), mesh.patch_cells["P"])
    elements = [
        f"CTRIA3,{k},{2 if is_patch else 1},{a},{b},{c}"
        for k, (is_patch, (a, b, c)) in enumerate(
            zip(in_patch, (mesh.cells + 1).tolist(), strict=True), 1
        )
    ]
    for file, unit in ((path, 1.0), (path.with_suffix(".dat"), 1e-3)):
        nodes = [
            f"GRID,{k},,{x:.9g},{y:.9g},0." for k, (x, y) in enumerate(mesh.vertices / unit, 1)
        ]
        file.write_text("\n".join(["BEGIN BULK", *nodes, *elements, "ENDDATA"]) + "\n")


def _rows(case: str, equals: list[PanelPair]) -> list[Row]:
    rows = []
    for pair in equals:
        method = f"{len(pair.panel.cells)} triangles, {pair.panel.natural_frequency.size} shapes"
        values = [
            (f"frequency {k + 1}", basis.natural_frequency[k], reference, "Hz")
            for basis in (pair.panel,)
            for k, reference in enumerate(pair.reference.natural_frequency[:8])
        ]
        values.append(
            ("area of the patch", patch_areas(pair.panel)[0], patch_areas(pair.reference)[0], "m2")
        )
        values.append(
            (
                "overlap of mode 1 on the patch",
                pair.panel.patch_overlap[0, 0, 0], pair.reference.patch_overlap[0, 0, 0], "m2",
            )
        )  # fmt: skip
        rows += [
            Row(
                case, f"{pair.name}: {quantity}", float(computed), float(reference), unit,
                pair.tolerance, method, pair.reason,
            )
            for quantity, computed, reference, unit in values
        ]  # fmt: skip
    return rows


def turned_rows(folder: Path) -> list[Row]:
    """Return a turned orthotropic panel beside the unturned one."""
    case = "Orthotropic sandwich, layup and ribbon turned with the panel"
    return _rows(case, turned_panels(folder))


def file_rows(folder: Path) -> list[Row]:
    """Return a panel from a mesh file beside that of its outline."""
    return _rows("Mesh from a file: the panel of the outline", filed_panels(folder))


CASES = {"turned": turned_rows, "mesh_file": file_rows}
"""Each computes in a folder and returns its rows."""
