"""What a new study takes from the modes of another solver: a structure with places on it."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.cli.mesh_draft import rounded, unit_of_materials
from pidpanel.geometry.orientation import oriented
from pidpanel.modal_files import ModalModel, read_modes
from pidpanel.modal_files.model import MASS_UNITS
from pidpanel.nastran import Deck, read_deck
from pidpanel.nastran.cards import BLANKS
from pidpanel.shell.selections import Place
from pidpanel.structure.foreign import ForeignStructure
from pidpanel.structure.surface import Surface

LIKELY_MASSES = 0.3, 100.0  # of a surface [kg/m²], where a unit of length is guessed
LIKELY_SIZES = 0.1, 30.0  # of a structure [m], likewise
BEYOND = 2.0  # last natural frequency over the highest of a response
RIGID_ERROR = 1e-3  # of a translation that rigid modes make up
ONE_SIDED = 0.5  # least share of a surface that faces a direction which is its outward one
TILTS = (0, 0, 1), (0, 0.3, 1), (0.1, 0.3, 1)  # of an outward direction
PATCH = 0.1  # radius of a patch over the size of a structure
DECKS = (".bdf", ".dat", ".nas", ".fem", ".blk")


class StructureDraft(NamedTuple):
    """The structure of a study, and what is printed of it."""

    structure: Mapping[str, Any]  # section ``structure``
    highest: float  # of a response [Hz]
    has_free_edges: bool  # whether the sound may go around its surface
    text: str
    remarks: Sequence[str]
    second: str = "antinode"  # name of the second patch


def modes_draft(
    file: Path,
    mesh: Path | None,
    unit: float | None,
    groups: Sequence[str],
    written: Callable[[Path], str],
    *,
    is_normalised: bool,
    uniform_kg: float | None,
) -> StructureDraft:
    """Return the draft of modes from a file; `ValueError` in one line.

    Parameters
    ----------
    groups
        Those that the sound meets; all without any.
    written
        Returns the path of a file as the study states it.
    """
    is_stated = is_normalised
    model, unit, is_normalised = _model(
        file, mesh, unit, is_normalised=is_normalised, uniform_kg=uniform_kg
    )
    structure = ForeignStructure({}, {}, model, 1.0, tuple(groups))
    outward = _outward(model.position, structure.loaded_cells)
    structure = ForeignStructure({}, {}, model, 1.0, tuple(groups), outward)
    surface = structure.surface
    mass, source = (uniform_kg, " spread evenly") if uniform_kg else _mass(model)
    stated = {"file": written(file), "mesh": mesh and written(mesh), "unit_m": unit,
              "normalised": "mass" if is_normalised else None,
              "uniform_mass": uniform_kg and True}  # fmt: skip
    motion = np.einsum("vdn,vd->vn", model.displacement[structure.nodes], surface.vertex_normal)
    lively = int((motion**2 * _weights(model)).sum(axis=1).argmax())
    middle, _ = surface.nearest(np.average(surface.middle, axis=0, weights=surface.area))
    numbers = model.node_number[structure.nodes]
    values = {
        "modes": {key: value for key, value in stated.items() if value is not None},
        "mass_kg": rounded(mass),
        **({"surface": list(groups)} if groups else {}),
        **({"outward": list(outward)} if outward else {}),
        "damping_ratio": 0.01,
        "patches": {
            name: patch_near(surface, vertex)
            for name, vertex in (("centre", middle), ("antinode", lively))
        },
        "points": {
            name: {"node": int(numbers[vertex])}
            for name, vertex in (("P1", middle), ("P2", lively))
        },
    }
    elastic = model.frequency[model.frequency > 0]
    ends = f"{elastic[0]:.4g} to {elastic[-1]:.4g} Hz" if elastic.size else "0 Hz"
    return StructureDraft(
        values,
        float(model.frequency[-1] / BEYOND),
        surface.has_free_edges,
        f"{len(elastic)} modes of {ends}, {surface.size:.4g} m large, {surface.area.sum():.4g} m²,"
        f" {mass:.3g} kg{source}" + (f", unit of {unit:g} m" if unit else ""),
        [
            *([] if uniform_kg else [f"mass of {mass:.3g} kg{source}: state the real one"]),
            *["modes are scaled to 1, as the deck asks for"] * (is_normalised and not is_stated),
            *model.remarks,
        ],
    )


def _model(
    file: Path,
    mesh: Path | None,
    unit: float | None,
    *,
    is_normalised: bool,
    uniform_kg: float | None,
) -> tuple[ModalModel, float | None, bool]:
    """Return modes, their unit of length [m], None where the files state it, and their scale."""
    deck = read_deck(mesh) if mesh is not None and mesh.suffix.lower() in DECKS else None
    if unit is None and deck is not None:
        unit = unit_of_materials(deck)
    models, refused = {}, [""]
    asks = deck is not None and uniform_kg is None and is_mass_normalised(deck)
    scales = {is_normalised, is_normalised or asks}
    for scaled in sorted(scales):
        for length in [unit] if unit else [None, *MASS_UNITS]:
            try:
                norm = "mass" if scaled else ""
                model = read_modes(file, mesh, length, normalised=norm, uniform_kg=uniform_kg)
            except ValueError as error:  # those that no unit mends come first
                refused.insert(0 if "unit_" not in str(error) else len(refused), str(error))
                continue
            values = np.median(model.areal_mass), np.ptp(model.position, axis=0).max()
            ranges = LIKELY_MASSES, LIKELY_SIZES
            is_likely = [a <= v <= b for v, (a, b) in zip(values, ranges, strict=True)]
            if length is None or unit is not None or all(is_likely):
                models[length, scaled] = model
            if length is None:
                break
        if models:
            break
    if len(models) == 1:
        (((length, scaled), model),) = models.items()
        return model, length, scaled
    if not models and (refused[0] or unit):
        hint = " (--mass-normalised, or --uniform-kg)" * ("no modal mass" in refused[0])
        raise ValueError((refused[0] or refused[-1]) + hint)
    if not models:
        raise ValueError(f"{file}: no usual unit gives a likely size and mass; --unit-m states it")
    names = ", ".join(f"{length:g}" for length, _ in models if length)
    raise ValueError(f"{file}: its unit of length is not clear, possible are {names}: --unit-m")


def is_mass_normalised(deck: Deck) -> bool:
    """Return whether the eigenvalue cards of a deck ask for modal masses of 1."""
    norms = [
        (([*card.fields, *BLANKS][place]).upper() or "MASS") == "MASS"
        for name, place in (("EIGRL", 6), ("EIGR", 8))
        for card in deck.cards.get(name, ())
    ]
    return bool(norms) and all(norms)


def _outward(position: Array, cells: Index) -> Place | None:
    """Return the direction that most of a surface faces, on either side; None of a round one.

    It is tilted where parts, such as webs, are across it, also of a round one with flat parts.
    """
    surface = Surface(position, cells)
    vectors = surface.cell_normal * np.sqrt(surface.area)[:, None]
    values, axes = np.linalg.eigh(vectors.T @ vectors)
    axes = axes * np.sign(axes[np.abs(axes).argmax(axis=0), range(3)])
    tilted = [(np.round(axes @ tilt, 3) + 0.0).tolist() for tilt in TILTS]
    is_round = values[2] < ONE_SIDED * values.sum()
    for direction in [None, *tilted] if is_round else tilted:
        try:
            oriented(position, cells, direction and np.array(direction))
        except ValueError:
            continue
        return direction and tuple(direction)
    return None if is_round else tuple(tilted[0])


def _weights(model: ModalModel) -> Array:
    """Return the weight of each mode by its response to white noise; 0 of rigid motions."""
    frequency = model.frequency
    return np.where(frequency > 0, 1 / (model.modal_mass * np.maximum(frequency, 1.0)), 0.0)


def _mass(model: ModalModel) -> tuple[float, str]:
    """Return the mass [kg]: that of the rigid modes, or the mean that modes move; and which."""
    rigid = np.flatnonzero(model.frequency == 0)
    shapes = model.displacement[:, :, rigid].reshape(3 * len(model.position), len(rigid))
    for axis in range(3 if rigid.size else 0):
        unit = np.broadcast_to(np.eye(3)[axis], model.position.shape).ravel()
        share = np.linalg.lstsq(shapes, unit, rcond=None)[0]
        if np.linalg.norm(shapes @ share - unit) < RIGID_ERROR * len(model.position) ** 0.5:
            return float(share**2 @ model.modal_mass[rigid]), " by the rigid modes"
    area = float(np.sum(Surface(model.position, model.cells).area))
    return float(np.median(model.areal_mass)) * area, " by the modal masses"


def patch_near(surface: Surface, vertex: int) -> dict[str, Any]:
    """Return a patch about a vertex, in a sphere with at least one element."""
    centre = surface.vertices[vertex]
    nearest = np.linalg.norm(surface.middle - centre, axis=1).min()
    radius = max(PATCH * surface.size, 1.1 * float(nearest))
    place = [float(f"{x:.4g}") for x in (centre + 0.0).tolist()]
    return {"centre_m": place, "radius_m": float(f"{radius:.2g}")}
