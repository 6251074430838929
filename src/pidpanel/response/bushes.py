"""Dampers of a layout for Nastran's frequency response: CBUSH, PBUSHT and TABLED1.

Each vertex of a filled patch has a grounded CBUSH along the normal (component 3, basic system).
With its share A of the area of the patch,

    B(f) = C_e A [N s/m],      K(f) = −(2πf)² m_a A [N/m],

so that damping and apparent mass both follow frequency, in SOL 108 and SOL 111 alike. The stiffness
without frequency is 0: modes are those of the panel without particles. Units are N, m, s.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Flags, Index
from pidpanel.response.nastran import large_field_table
from pidpanel.sound.field import lumped_area

FIRST = 9_000_001  # first number of elements, properties and tables: most decks have lower ones

PER_OCTAVE = 24  # nodes of the tables: between them ω² m_a is straight within 2e-4

LINEAR = ("LINEAR", "LINEAR")


def write_bushes(
    path: Path,
    title: str,
    frequency: Array,
    dampers: Mapping[str, tuple[Array, Array]],
    vertices: Array,
    cells: Index,
    cell_in_patch: Mapping[str, Flags],
) -> None:
    """Write the bulk data of the dampers of a layout.

    Parameters
    ----------
    frequency
        (nf,) lines [Hz].
    dampers
        C_e [N s/m³] and m_a [kg/m²], each (nf,), by patch.
    vertices, cells
        The mesh of the panel: (n_vertices, 2) [m] and vertex numbers. GRID n is vertex n − 1.
    cell_in_patch
        (n_cells,) the cells of each patch.
    """
    count = int(np.ceil(PER_OCTAVE * np.log2(frequency[-1] / frequency[0]))) + 1
    nodes = np.geomspace(frequency[0], frequency[-1], max(count, 2))
    number = FIRST
    with path.open("w", encoding="ascii", errors="replace") as file:
        file.write(
            f"$ {title}\n$ dampers as grounded CBUSH along z: B = C_e A in N s/m, K = -w**2 m_a A"
            "\n$ in N/m; A is the area of a grid. Units N, m, s. SOL 108, or SOL 111 with"
            "\n$ residual vectors. Give the properties to the grids of your own panel.\n"
        )
        shares = {
            name: lumped_area(vertices, cells[cell_in_patch[name]]).round(12) for name in dampers
        }
        for grid in np.flatnonzero(sum(shares.values())).tolist():
            x, y = vertices[grid].tolist()
            file.write(f"GRID*   {grid + 1:16d}{'':16}{x:16.9E}{y:16.9E}\n*       {0.0:16.9E}\n")
        for name, damping in dampers.items():
            rows = [np.interp(nodes, frequency, values) for values in damping]
            values = -((2 * np.pi * nodes) ** 2) * rows[1], rows[0]
            for area in np.unique(shares[name][shares[name] > 0]).tolist():
                file.write(f"$ patch {name}, {area:.6g} m**2 of each grid\n")
                file.writelines(_property(number, nodes, *(area * value for value in values)))
                pid, grids = number, np.flatnonzero(shares[name] == area)
                number += max(2, grids.size)
                for place, grid in enumerate(grids.tolist()):
                    file.write(f"CBUSH   {pid + place:8d}{pid:8d}{grid + 1:8d}{'':32}{0:8d}\n")


def _property(number: int, frequency: Array, stiffness: Array, damping: Array) -> Iterator[str]:
    """Yield a property along z, with tables of its number and the next."""
    yield f"PBUSH   {number:8d}       K{'':16}{0.0:8.1f}\n"
    yield f"PBUSHT  {number:8d}       K{'':16}{number:8d}\n"
    yield f"{'':16}       B{'':16}{number + 1:8d}\n"
    for table, values in enumerate((stiffness, damping), start=number):
        yield from large_field_table("TABLED1", table, LINEAR, frequency, values)
