"""Surface elements and mode shapes as files state them, and how those files are read."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.text_files import TextFileError, read_bytes

LARGEST_RESULT = 4_000_000_000  # most bytes of a file of modes


class SurfaceElements(NamedTuple):
    """Nodes and surface elements of a file, in its units."""

    node: Index  # (n_nodes,) numbers
    position: Array  # (n_nodes, 3)
    element: Sequence[int]  # numbers
    corners: Sequence[Sequence[int]]  # numbers of the nodes: corners, then those between them
    groups: Mapping[str, Sequence[int]]  # places of elements
    frame: Array | None = None  # (n_nodes, 3, 3) axes of displacements, in columns
    remarks: tuple[str, ...] = ()  # what of the file is not read
    # (n_nodes, 2) nodes of the modes below and above each; None where they are its own
    sides: Index | None = None


class ModeShapes(NamedTuple):
    """Modes and static cases of a file, in its units."""

    node: Index  # (n_nodes,) numbers
    frequency: Array  # (n_modes,) [Hz]
    modal_mass: Array  # (n_modes,) 0 or not finite where the file has none
    displacement: Array  # (n_nodes, 3, n_modes)
    static: Array  # (n_nodes, 3, n_static)
    position: Array | None = None  # (n_nodes, 3) if the file has it
    largest: Array | None = None  # (n_modes,) largest components if there are rotations too
    participation: Array | None = None  # (n_modes, 3) Σ m φ along x, y, z; None if not known
    advice: str = ""  # where nodes of elements are missing

    def averaged(self, node: Index, sides: Index) -> "ModeShapes":
        """Return the mean motion of pairs of nodes (n, 2), as that of nodes (n,)."""
        if not (present := np.isin(sides, self.node)).all():
            raise ValueError(f"node {sides[~present][0]} has no displacement")
        order = np.argsort(self.node)
        rows = order[np.searchsorted(self.node, sides, sorter=order)]
        motion, static = self.displacement[rows].mean(axis=1), self.static[rows].mean(axis=1)
        return self._replace(node=node, displacement=motion, static=static, position=None)


def bytes_of(path: Path) -> bytes:
    """Return the content of a file of modes."""
    try:
        return read_bytes(path, LARGEST_RESULT)
    except TextFileError as error:
        raise ValueError(f"{path}: {error.message}") from None


def stacked(
    node: Index,
    modes: Sequence[tuple[float, float, Array]],
    static: Sequence[Array],
    points: tuple[Index, Array] | None = None,
) -> ModeShapes:
    """Return the shapes of modes: frequency, modal mass and vectors (n_nodes, 3) of each.

    ``points`` are numbers and positions of nodes of the same file, in any order.
    """
    frequency, mass = np.array([mode[:2] for mode in modes]).reshape(-1, 2).T
    motion, cases = (
        np.stack(vectors, axis=2) if vectors else np.empty((len(node), 3, 0))
        for vectors in ([mode[2] for mode in modes], static)
    )
    position = None
    if points is not None and np.isin(node, points[0]).all():
        order = np.argsort(points[0])
        position = points[1][order[np.searchsorted(points[0], node, sorter=order)]]
    return ModeShapes(node, frequency, mass, motion, cases, position)
