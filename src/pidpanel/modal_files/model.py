"""Modes of a structure from another solver, in SI and in the basic frame, on linear cells."""

from dataclasses import dataclass, field, replace

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.modal_files.shapes import ModeShapes, SurfaceElements
from pidpanel.tabular.units import POUND

# Cells of an element with 3 to 8 nodes: corners, then the nodes between them
PARTS = {
    3: [[0, 1, 2, 2]],
    4: [[0, 1, 2, 3]],
    6: [[0, 3, 5, 5], [3, 1, 4, 4], [5, 4, 2, 2], [3, 4, 5, 5]],
    8: [[0, 4, 7, 7], [4, 1, 5, 5], [5, 2, 6, 6], [6, 3, 7, 7], [4, 5, 6, 7]],
}
# Mass units of systems that are consistent with a length unit [m]: kg, t, lbf s²/in, slug
MASS_UNITS = {1.0: 1.0, 1e-3: 1e3}
MASS_UNITS |= {unit: POUND * STANDARD_GRAVITY / unit for unit in (0.0254, 0.3048)}
EXTENTS = 0.01, 200.0  # least and greatest size of a structure [m]
AREAL_MASSES = 0.02, 2000.0  # least and greatest mean of a mode [kg/m²]
RIGID = 0.05  # greatest frequency [Hz] that is rounding of a rigid motion's
LARGEST_SPREAD = 50.0  # of the mass per area of modes that are declared as mass-normalised
NORMALISED = 1e-3  # deviation of a modal mass of 1, or of a largest component of 1
HIGHEST = 1e6  # greatest frequency [Hz]
SAME_SHAPE = 1e-8  # difference of the shapes of two modes that are one, by its square
COINCIDENT = 1e-4  # share of the extent by which nodes of two files may differ


@dataclass(frozen=True)
class ModalModel:
    """Modes of a structure and the surface that moves."""

    position: Array  # (n_nodes, 3) [m]
    node_number: Index  # (n_nodes,) in the file
    frequency: Array  # (n_modes,) [Hz]
    modal_mass: Array  # (n_modes,) [kg]
    displacement: Array  # (n_nodes, 3, n_modes) in the basic frame
    cells: Index  # (n_cells, 4) corners of linear cells; triangles repeat the third
    groups: dict[str, Index]  # cells of each set, property or group
    source: str  # names of the files
    # (n_nodes, 3, n_static) of static cases with a pressure of 1 in the file [m/Pa]
    static_displacement: Array = field(default_factory=lambda: np.empty((0, 3, 0)))
    remarks: tuple[str, ...] = ()  # what of the mesh is not read
    participation: Array | None = None  # (n_modes, 3) Σ m φ along x, y, z [kg]; None if not known
    # (n_cells, 8) nodes of the elements of second order whose parts the cells are; −1 without
    parents: Index | None = None

    @property
    def areal_mass(self) -> Array:
        """Modal mass over ∫|φ|² dA of each mode, (n_modes,) [kg/m²]; the mean where it moves."""
        square = (self.displacement**2).sum(axis=1)[self.cells].mean(axis=1)
        return self.modal_mass / (cell_areas(self.position, self.cells) @ square)


def modal_model(
    place: str,
    mesh: SurfaceElements,
    shapes: ModeShapes,
    unit_m: float,
    unit_kg: float | None = None,
    normalised: str = "",
    uniform_kg: float | None = None,
) -> ModalModel:
    """Join mesh and modes in SI; see `read_modes`. `ValueError` in one line with the place."""
    try:
        if unit_kg is None and unit_m not in MASS_UNITS:
            allowed = ", ".join(f"{unit:g}" for unit in MASS_UNITS)
            raise ValueError(f"unit_m = {unit_m:g} needs unit_kg; only {allowed} imply it")
        mass_unit = MASS_UNITS[unit_m] if unit_kg is None else unit_kg
        if not shapes.frequency.size and len(mesh.element):
            raise ValueError("no real normal modes of displacements")
        shapes = shapes if mesh.sides is None else shapes.averaged(mesh.node, mesh.sides)
        for name, numbers in (("mesh", mesh.node), ("modes", shapes.node)):
            values, count = np.unique(numbers, return_counts=True)
            if count.max(initial=0) > 1:
                raise ValueError(f"{name}: node {values[np.argmax(count)]} appears twice")
        rows, cells, parents, groups = _surface(mesh, shapes)
        order = np.argsort(shapes.node)
        columns = order[np.searchsorted(shapes.node, mesh.node[rows], sorter=order)]
        position = _position(mesh, shapes, rows, columns, unit_m)
        motion, static = shapes.displacement[columns], shapes.static[columns]
        if mesh.frame is not None:
            frame = mesh.frame[rows]
            motion, static = frame @ motion, frame @ static
        mass = mass_unit * _modal_masses(shapes, normalised, is_uniform=uniform_kg is not None)
        static = static * unit_m**2 / mass_unit  # a pressure of 1 is unit_kg/(unit_m s²)
        frequency = np.where(np.abs(shapes.frequency) <= RIGID, 0.0, shapes.frequency)
        model = ModalModel(
            position,
            mesh.node[rows],
            frequency,
            mass,
            motion,
            cells,
            groups,
            place,
            static,
            mesh.remarks,
            None if shapes.participation is None else mass_unit * shapes.participation,
            parents,
        )
        if uniform_kg is not None:
            model = _with_uniform_mass(model, uniform_kg)
        _check(model, unit_kg is None)
        areal = model.areal_mass
        if normalised and areal.max() > LARGEST_SPREAD * areal.min():
            message = f"modes move {areal.min():.3g} to {areal.max():.3g} kg/m² of the surface"
            raise ValueError(f"{message}, which modes that are scaled to a mass of 1 do not")
    except ValueError as error:
        raise ValueError(f"{place}: {error}") from None
    return model


def _position(
    mesh: SurfaceElements, shapes: ModeShapes, rows: Index, columns: Index, unit_m: float
) -> Array:
    """Return the places [m] of the nodes in rows of the mesh and columns of the modes."""
    position = unit_m * mesh.position[rows]
    if not (finite := np.isfinite(position).all(axis=1)).all():
        raise ValueError(f"node {mesh.node[rows[finite.argmin()]]}: its position is not finite")
    extent = float(np.ptp(position, axis=0).max())
    if not EXTENTS[0] <= extent <= EXTENTS[1]:
        message = f"the structure is {extent:g} m large with unit_m = {unit_m:g}"
        raise ValueError(f"{message}; allowed are {EXTENTS[0]:g} to {EXTENTS[1]:g} m")
    if shapes.position is not None:
        distance = np.linalg.norm(position - unit_m * shapes.position[columns], axis=1)
        if not distance.max() <= COINCIDENT * extent:
            worst = mesh.node[rows[np.argmax(distance)]]
            message = f"node {worst}: mesh and modes differ by {distance.max():g} m"
            raise ValueError(f"{message} in its position; both must be of one model")
    return position


def _with_uniform_mass(model: ModalModel, mass: float) -> ModalModel:
    """Return a model whose mass [kg] is spread evenly: m_k = m″ ∫|φ_k|² dA."""
    areas = cell_areas(model.position, model.cells)
    areal = mass / areas.sum()
    mean = np.tensordot(areas, model.displacement[model.cells].mean(axis=1), 1)
    masses = areal * model.modal_mass / model.areal_mass
    return replace(model, modal_mass=masses, participation=areal * mean.T)


def _surface(
    mesh: SurfaceElements, shapes: ModeShapes
) -> tuple[Index, Index, Index, dict[str, Index]]:
    """Return the rows of nodes that have a displacement, cells in these, parents, and groups."""
    if not len(mesh.element):
        raise ValueError("no surface elements; triangles or quadrilaterals are needed")
    for number, members in zip(mesh.element, mesh.corners, strict=True):
        if len(members) not in PARTS:
            raise ValueError(f"element {number} has {len(members)} nodes, not 3, 4, 6 or 8")
    rows = np.flatnonzero(np.isin(mesh.node, shapes.node))
    order = np.argsort(mesh.node[rows])
    numbers = mesh.node[rows][order]
    parts, origins, parents = [], [], []
    for count, table in PARTS.items():
        places = [k for k, nodes in enumerate(mesh.corners) if len(nodes) == count]
        nodes = np.array([mesh.corners[k] for k in places], dtype=np.int64).reshape(-1, count)
        index = np.searchsorted(numbers, nodes)
        absent = ~np.isin(nodes, numbers)
        if absent.any():
            k, corner = np.argwhere(absent)[0]
            where = "the modes" if np.isin(nodes[k, corner], mesh.node) else "the mesh"
            message = f"element {mesh.element[places[k]]}: its node {nodes[k, corner]} is not in"
            lacking = f"{absent.any(axis=1).sum()} elements lack nodes{shapes.advice}"
            raise ValueError(f"{message} {where}; {lacking}")
        parts.append(order[index[:, table]].reshape(-1, 4))
        origins.append(np.repeat(np.array(places, dtype=np.int64), len(table)))
        elements = np.full((len(origins[-1]), 8), -1)
        if count > 4:
            elements[:, :count] = np.repeat(order[index], len(table), axis=0)
        parents.append(elements)
    origin = np.concatenate(origins)
    by_element = np.argsort(origin, kind="stable")
    origin, cells = origin[by_element], np.concatenate(parts)[by_element]
    groups = {name: np.flatnonzero(np.isin(origin, rows)) for name, rows in mesh.groups.items()}
    named = {name: group for name, group in groups.items() if group.size}
    return rows, cells, np.concatenate(parents)[by_element], named


def _modal_masses(shapes: ModeShapes, normalised: str, *, is_uniform: bool) -> Array:
    """Return the modal masses in the unit of the file; refuse those that are missing or wrong."""
    if normalised not in ("", "mass"):
        raise ValueError(f"normalised: {normalised}; allowed is mass")
    mass = shapes.modal_mass
    missing = ~(np.isfinite(mass) & (mass != 0))
    if is_uniform:
        if normalised or not missing.all():
            raise ValueError("uniform_mass: only allowed for modes without masses or scale")
        return np.ones(len(mass))
    if not normalised and missing.any():
        message = f"mode {1 + np.argmax(missing)} has no modal mass; state normalised: mass"
        message += " if modes are scaled to a mass of 1, or uniform_mass: true"
        raise ValueError(message)
    if normalised and (wrong := ~missing & ~(np.abs(mass - 1) <= NORMALISED)).any():
        k = int(np.argmax(wrong))
        raise ValueError(f"mode {1 + k} has a modal mass of {mass[k]:g}; normalised: mass needs 1")
    mass = np.where(missing, 1.0, mass)
    if (mass < 0).any():
        k = int(np.argmin(mass))
        raise ValueError(f"mode {1 + k} has a modal mass of {mass[k]:g}; it must be positive")
    length = np.linalg.norm(shapes.displacement, axis=1)
    peaks = [np.abs(shapes.displacement).max(axis=(0, 1), initial=0.0), length.max(axis=0)]
    peaks += [] if shapes.largest is None else [shapes.largest]
    is_one = (np.abs([mass, *peaks] - np.ones(len(mass))) < NORMALISED).all(axis=1)
    if len(mass) > 1 and is_one[0] and is_one[1:].any():
        message = "modal masses and largest components of all modes are 1"
        raise ValueError(f"{message}; modes must be scaled to one of them, with its masses")
    return mass


def _check(model: ModalModel, is_implied: bool) -> None:
    """Refuse what no structure has: frequencies, values, and a mass from wrong units."""
    frequency = model.frequency
    if (wrong := ~((frequency >= 0) & (frequency <= HIGHEST))).any():
        k = int(np.argmax(wrong))
        raise ValueError(f"mode {1 + k} has {frequency[k]:g} Hz; 0 to {HIGHEST:g} is allowed")
    if not frequency.any():
        raise ValueError("modes are rigid motions alone")
    if (falling := np.diff(frequency) < 0).any():
        k = int(np.argmax(falling))
        message = f"mode {2 + k} has {frequency[k + 1]:g} Hz after {frequency[k]:g} Hz"
        raise ValueError(f"{message}; frequencies must rise")
    for name, values in (("displacement", model.displacement),
                         ("static case", model.static_displacement)):  # fmt: skip
        if not np.isfinite(values).all():
            node = model.node_number[np.argwhere(~np.isfinite(values))[0][0]]
            raise ValueError(f"node {node}: its {name} is not finite")
    if (still := ~model.displacement.any(axis=(0, 1))).any():
        raise ValueError(f"mode {1 + np.argmax(still)} has no displacement on the surface")
    shapes = model.displacement.reshape(-1, len(frequency))
    shapes = shapes / np.linalg.norm(shapes, axis=0)
    pairs = np.argwhere(np.triu(1 - (shapes.T @ shapes) ** 2 < SAME_SHAPE, 1))
    if len(pairs):
        raise ValueError(f"modes {1 + pairs[0, 0]} and {1 + pairs[0, 1]} have the same shape")
    area = cell_areas(model.position, model.cells)
    if not area.min() > 0:
        node = model.node_number[model.cells[area.argmin(), 0]]
        raise ValueError(f"an element at node {node} has no area")
    areal = float(np.median(model.areal_mass))
    if not AREAL_MASSES[0] <= areal <= AREAL_MASSES[1]:
        message = f"modes move {areal:g} kg/m² of the surface"
        advice = "; unit_kg states the unit of masses" * is_implied
        raise ValueError(
            f"{message}; allowed are {AREAL_MASSES[0]:g} to {AREAL_MASSES[1]:g}{advice}"
        )
