"""Modes in a VTU, the neutral form: ``mode_1 …`` at points, ``frequencies``, ``modal_masses``.

``participation_x``, ``participation_y``, ``participation_z`` are optional.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.modal_files.shapes import ModeShapes, SurfaceElements

KINDS = {"triangle": 3, "quad": 4, "triangle6": 6, "quad8": 8, "quad9": 8}  # nodes used
GROUP = "group"  # array of numbers of groups


def read_vtu(path: Path) -> tuple[SurfaceElements, ModeShapes]:
    """Read surface cells, modes and static cases of a VTU; nodes are counted from 1."""
    import meshio  # slow to import, for files alone

    try:
        grid = meshio.vtu.read(path)
    except Exception as error:  # whatever the library meets in a broken file
        message = f"{error}".rstrip(".") or "compressed otherwise than by zlib or lzma"
        raise ValueError(f"{path}: is no VTU that can be read ({message})") from None
    position = np.asarray(grid.points, dtype=float)
    node = np.arange(1, len(position) + 1)
    corners: list[list[int]] = []
    groups: dict[str, list[int]] = {}
    for block, cells in enumerate(grid.cells):
        if cells.type not in KINDS:
            continue
        for name, arrays in grid.cell_data.items():
            values = np.asarray(arrays[block])
            if values.ndim > 1 or not (values == np.rint(values)).all():
                continue
            for value in np.unique(values[values != 0]).astype(int).tolist():
                members = groups.setdefault(f"{value}" if name == GROUP else name, [])
                members += (len(corners) + np.flatnonzero(values == value)).tolist()
        corners += (1 + cells.data[:, : KINDS[cells.type]]).tolist()
    mesh = SurfaceElements(node, position, range(1, len(corners) + 1), corners, groups)
    modes, static = (_vectors(path, grid, name) for name in ("mode", "static"))
    frequency, mass = (np.ravel(grid.field_data.get(name, [])).astype(float)
                       for name in ("frequencies", "modal_masses"))  # fmt: skip
    if len(frequency) != modes.shape[2]:
        message = f"{modes.shape[2]} arrays mode_1 … of points and {len(frequency)} frequencies"
        raise ValueError(f"{path}: {message} in the field data; each mode needs both")
    if mass.size not in (0, len(frequency)):
        message = f"{mass.size} modal_masses in the field data of {len(frequency)} modes"
        raise ValueError(f"{path}: {message}; all or none are allowed")
    mass = mass if mass.size else np.zeros(len(frequency))
    shapes = ModeShapes(node, frequency, mass, modes, static)
    return mesh, shapes._replace(participation=_participation(path, grid, len(frequency)))


def _participation(path: Path, grid: Any, count: int) -> Array | None:
    """Return Σ m φ (n_modes, 3) of the field data; None without any."""
    names = [f"participation_{axis}" for axis in "xyz"]
    if not set(names) & grid.field_data.keys():
        return None
    values = [np.ravel(grid.field_data.get(name, [])).astype(float) for name in names]
    for name, value in zip(names, values, strict=True):
        if value.shape != (count,) or not np.isfinite(value).all():
            message = f"{name} in the field data must have {count} numbers, one for each mode"
            raise ValueError(f"{path}: {message}")
    return np.transpose(values)


def _vectors(path: Path, grid: Any, kind: str) -> Array:
    """Return the arrays of a kind in the order of their numbers, (n_points, 3, n)."""
    numbered = re.compile(rf"{kind}_(\d+)")
    names = {int(match[1]): match[0] for match in map(numbered.fullmatch, grid.point_data) if match}
    if absent := set(range(1, len(names) + 1)) - names.keys():
        raise ValueError(f"{path}: array {kind}_{min(absent)} is missing; it has {max(names)}")
    vectors = np.empty((len(grid.points), 3, len(names)))
    for k, name in names.items():
        value = np.asarray(grid.point_data[name])
        if np.iscomplexobj(value) or value.shape != vectors.shape[:2]:
            raise ValueError(f"{path}: array {name} must have three real components")
        vectors[:, :, k - 1] = value
    return vectors
