"""The structure of a study, or its panel: the one place in `structure` that reads the study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.modal_files import ModalModel, read_modes
from pidpanel.panel.basis import PanelBasis, basis_of, face_wavenumber, with_condensed_face
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.panel.from_study import StudiedPanel, section_of
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import MODES_BEYOND, panel_shapes
from pidpanel.panel.stretching import panel_stretching
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.shell.attachments import (
    Attached,
    Hinge,
    PointMass,
    RigidFoot,
    ShellSupport,
    Stiffener,
)
from pidpanel.shell.drawing import (
    cylinder_panel,
    edge_strips,
    flat_panels,
    mesh_surface,
    paraboloid,
)
from pidpanel.shell.mesh import UPWARD, ShellMesh
from pidpanel.shell.resolution import layer_depth
from pidpanel.shell.selections import Box, Line, Prism, Ring, Selection, Sphere
from pidpanel.shell.strains import Layup
from pidpanel.shell.surface_files import read_deck_surface, read_surface_file
from pidpanel.solve.base_motion import UNIT, Translation
from pidpanel.structure.any_structure import (
    AnyStructure,
    Observation,
    SolvedStructure,
    StructureRefused,
)
from pidpanel.structure.foreign import ForeignStructure
from pidpanel.structure.shelled import ShellStructure, imprints
from pidpanel.study import Study
from pidpanel.study.mistakes import Mistake
from pidpanel.study.panel import Panel
from pidpanel.study.places import SurfaceArea
from pidpanel.study.shell import Foot, Shell, ShellSupportInput, StiffenerInput
from pidpanel.study.structure import ModesFile, Structure

AnyPanel = StudiedPanel | AnyStructure
LEAST_COSINE = 0.5  # of a stated normal of a patch with the mean one
# Width of elements along edges and stiffeners over the depth of the layer there, and over that of
# other elements above which these resolve it.
STRIP, NARROW = 4.0, 0.5


def studied(section: Panel | Structure) -> AnyPanel:
    """Return the panel or the structure of a study.

    Raises
    ------
    StructureRefused
        If the files of a structure cannot be read.
    """
    return structure_of(section) if isinstance(section, Structure) else StudiedPanel(section)


def structure_of(section: Structure) -> AnyStructure:
    """Return the structure of a section; see `studied`."""
    areas = {
        name: selection_of(area) if area.group is None else area.group
        for name, area in section.patches.items()
    }
    points = {
        name: Observation(point.node, point.at_m, point.direction)
        for name, point in section.points.items()
    }
    if section.modes is not None and section.mass_kg is not None:
        return _foreign(section, section.modes, section.mass_kg, areas, points)
    if section.shell is None:
        raise ValueError("a structure without modes and without a shell")
    shell, attached = section.shell, _attached(section.shell)
    size, outward = shell.size_m, section.outward or UPWARD
    layup = Layup(section_of(shell.section), shell.axis, shell.offset_m)
    parts = {
        name: Layup(section_of(part.section), part.axis or shell.axis, part.offset_m)
        for name, part in shell.parts.items()
    }
    places = imprints(areas, attached)
    width = STRIP * max(map(layer_depth, [layup, *parts.values()]))
    if shell.form.kind == "panels" and width < NARROW * size:
        lines = [part.where for part in attached.values() if isinstance(part, Stiffener)]
        places += edge_strips(shell.form.corners_m, lines, width)
    drawn = partial(_drawn, shell, size, places, outward)
    return ShellStructure(areas, points, drawn, layup, attached, size, parts)


def _foreign(
    section: Structure,
    modes: ModesFile,
    mass: float,
    areas: dict[str, Selection | str],
    points: dict[str, Observation],
) -> ForeignStructure:
    files = modes.file, modes.mesh, modes.static
    stamps = tuple(path.stat().st_mtime_ns for path in files if path and path.exists())
    try:
        model = _model(
            stamps, modes.file, modes.mesh, modes.unit_m, unit_kg=modes.unit_kg,
            normalised=modes.normalised or "", static=modes.static,
            uniform_kg=mass if modes.uniform_mass else None,
        )  # fmt: skip
    except ValueError as error:
        raise StructureRefused(("modes", "file"), str(error)) from error
    further = section.surface, section.outward, modes.pressures
    return ForeignStructure(areas, points, model, mass, *further)


@lru_cache(maxsize=1)
def _model(stamps: tuple[int, ...], *files: Any, **options: Any) -> ModalModel:
    """Read modes once for all that a check or a stage asks of their structure."""
    return read_modes(*files, **options)


def _drawn(
    shell: Shell, size: float, places: list[Selection], outward: tuple[float, float, float]
) -> ShellMesh:
    form = shell.form
    if form.kind == "deck":
        return read_deck_surface(form.file, form.unit_m, form.groups, outward)
    if form.kind == "file":
        return read_surface_file(form.file, size, places, unit=form.unit_m, outward=outward)
    if form.kind == "paraboloid":
        drawing = paraboloid(form.diameter_m, form.focal_length_m, form.hub_diameter_m)
    elif form.kind == "cylinder_panel":
        drawing = cylinder_panel(form.radius_m, form.length_m, form.arc_m)
    else:
        drawing = flat_panels(form.corners_m)
    return mesh_surface(drawing, size, places, outward=outward)


def _attached(shell: Shell) -> dict[str, Attached]:
    """Return what holds a shell and what it carries, by name."""
    attached: dict[str, Attached] = {
        name: _support(support) for name, support in shell.supports.items()
    }
    attached |= {name: _foot(foot) for name, foot in shell.feet.items()}
    for name, hinge in shell.hinges.items():
        attached[name] = Hinge(hinge.feet, hinge.at_m, hinge.axis, hinge.stiffness_n_m_rad)
    for name, mass in shell.masses.items():
        attached[name] = PointMass(mass.at_m, mass.mass_kg)
    return attached | {name: _beam(beam) for name, beam in shell.stiffeners.items()}


def _support(support: ShellSupportInput) -> ShellSupport:
    where = selection_of(support.where)
    return ShellSupport(where) if support.kind == "clamped" else ShellSupport(where, rotation=())


def _foot(foot: Foot) -> RigidFoot:
    where = selection_of(foot.where)
    support = {
        "clamped": ShellSupport(where), "pinned": ShellSupport(where, rotation=()), "free": None,
    }[foot.kind]  # fmt: skip
    return RigidFoot(where, foot.centre_m, support, foot.mass_kg)


def _beam(beam: StiffenerInput) -> Stiffener:
    """Return a beam of rectangular section; torsion by Roark's formula within 4 %."""
    width, height = beam.width, beam.height
    long, short = max(width, height), min(width, height)
    torsion = long * short**3 * (1 / 3 - 0.21 * short / long * (1 - (short / long) ** 4 / 12))
    E = beam.youngs_modulus
    return Stiffener(
        Line(beam.from_m, beam.to_m), E, E / (2 * (1 + beam.poissons_ratio)), beam.density_kg_m3,
        width * height, width * height**3 / 12, torsion, beam.offset,
    )  # fmt: skip


def selection_of(area: SurfaceArea) -> Selection:
    """Return the part of space that an area without a group is."""
    if area.radius_m is not None and area.centre_m is not None:
        return Sphere(area.centre_m, area.radius_m)
    if area.radii_m is not None and area.centre_m is not None and area.along is not None:
        return Ring(*area.radii_m, area.centre_m, area.along)
    if area.corners_m is not None and area.along is not None:
        return Prism(area.corners_m, area.along)
    if area.from_m is not None and area.to_m is not None:
        return Box(area.from_m, area.to_m)
    raise ValueError("an area with a group is no part of space")


def with_normals(section: Structure) -> Structure:
    """Return the structure with the normals of its patches."""
    if not section.patches:
        return section
    structure = structure_of(section)
    patches = {}
    for name, area in section.patches.items():
        normal = area.normal or tuple((structure.mean_normal(name).round(3) + 0.0).tolist())
        patches[name] = area.model_copy(update={"normal": normal})
    return section.model_copy(update={"patches": patches})


def mistakes_of_normals(section: Structure) -> Iterator[Mistake]:
    """Yield stated normals of patches that are none."""
    structure = structure_of(section)
    for name, area in section.patches.items():
        if area.normal is None:
            continue
        mean = structure.mean_normal(name)
        if mean @ area.normal < LEAST_COSINE * np.linalg.norm(area.normal):
            text = ", ".join(f"{x:.3g}" for x in mean.tolist())
            message = f"must be within 60° of the mean normal of its elements, ({text})"
            yield Mistake(("patches", name, "normal"), message)


def write_panel(study: Study, output: Files) -> None:
    """Mesh the panel or the structure of a study, find its modes, and write the files of the stage.

    Parameters
    ----------
    output
        modes, table, shapes, mesh, section and plate.

    Raises
    ------
    ValueError
        If it is refused.
    """
    # a check needs neither pandas nor xarray
    from pidpanel.panel import tables
    from pidpanel.panel.files import write_basis, write_plate, write_shapes

    highest, size = study.response.frequency_hz[1], None
    if isinstance(study.panel, Structure):
        structure = structure_of(study.panel)
        solution = structure.solve(structure.mesh(output.mesh), highest, study.damper_masses())
        stored, mass = solution.plate.with_shapes(solution.vectors), solution.mass
        basis = with_tangential_share(structure, solution, highest)
        # none of modes from a file, and of several parts
        section = (
            getattr(solution.plate, "section", None)
            if not (study.panel.shell and study.panel.shell.parts)
            else None
        )
    else:
        panel = StudiedPanel(study.panel)
        basis, stored = _solved_panel(study, panel, output.mesh)
        section, size = panel.section, panel.navier_size
        mass = section.mass_per_area * float(basis.quadrature_weight.sum())
    write_plate(output.plate, stored, stamp(study))
    wavenumber = face_wavenumber(basis, 2 * np.pi * highest / study.wave_speed)
    write_basis(output.modes, with_condensed_face(basis, wavenumber), stamp(study))
    write_shapes(output.shapes, basis)
    modes = tables.mode_table(basis, size, section)
    modes.to_csv(output.table, index=False, float_format="%.8g")
    masses = tables.section_table(section, float(basis.quadrature_weight.sum()), mass)
    masses.to_csv(output.section, index=False, float_format="%.8g")


def with_tangential_share(
    structure: AnyStructure, solution: SolvedStructure, highest: float
) -> PanelBasis:
    """Return the basis with the share of the motion along the surface, by patch.

    Of the elastic modes to a frequency [Hz], or of all where there are none.
    """
    basis = solution.basis
    elastic = ~basis.is_residual & (basis.natural_frequency > 0)
    below = elastic & (basis.natural_frequency <= highest)
    modes = below if below.any() else elastic
    motion = solution.plate.motions(solution.vectors[:, modes])
    shares = structure.tangential_shares(motion, basis.modal_mass[modes])
    return replace(basis, tangential_share=np.array([shares[n] for n in basis.patch_names]))


def _solved_panel(study: Study, panel: StudiedPanel, path: Path) -> tuple[PanelBasis, StoredPlate]:
    lowest, highest = study.response.frequency_hz
    mesh = panel.mesh(path, panel.patch_sizes(highest, study.damper_masses(with_rows=True)))
    plate = panel.plate(mesh)
    shapes = panel_shapes(plate, MODES_BEYOND * highest, damper_mass=study.damper_masses())
    held_edges = panel.supports if panel.panel.in_plane_edges == "held" else None
    stretching = panel_stretching(mesh, plate, shapes, lowest, held_edges)
    return basis_of(mesh, plate, shapes), plate.with_shapes(shapes.vectors, stretching)


def read_moved_panel(study: Study, files: Files) -> tuple[PanelBasis, StoredPlate, Translation]:
    """Read basis and plate, and what the translation of the supports moves.

    Raises
    ------
    ValueError
        If nothing is known of the inertia of a structure.
    """
    basis, plate = read_basis(files.modes), read_plate(files.plate)
    if plate.point_direction is None:
        return basis, plate, UNIT
    if (
        plate.participation is None
        or plate.quadrature_normal is None
        or plate.vertex_normal is None
    ):
        raise ValueError("base: the inertia of modes from a file is not known")
    direction = np.array((study.base and study.base.direction) or (0.0, 0.0, 1.0))
    direction = direction / np.linalg.norm(direction)
    at_points, normals = plate.point_direction @ direction, plate.quadrature_normal @ direction
    if basis.quadrature_normal is None:  # a flat structure
        translation = Translation(at_points, float(normals[0]), float(normals[0]), direction)
    else:
        translation = Translation(at_points, plate.vertex_normal @ direction, normals, direction)
    return basis, replace(plate, inertia=plate.participation @ direction), translation
