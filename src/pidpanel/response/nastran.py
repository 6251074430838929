"""Nastran bulk data: tables in large fields (16 characters), modal damping, dampers.

A damper on a patch adds to mode i, with the overlap D_ii = ∫_patch φ_i² dA,

    ζ_i = ζ + Σ_patches C_e(ω_i) D_ii/(2 m_i ω_i),

the diagonal of the modal damping matrix (paper, Eq. 12): tables TABDMP1, one a scenario. What
couples the modes is left out, as modal damping does: 4 to 5 dB off the patch at high frequency in
the paper's panel.

For the frequency response each vertex of a filled patch has a grounded CBUSH along the normal
(component 3, basic system), with PBUSHT and TABLED1. With its share A of the area of the
patch (`grid_areas`),

    B(f) = C_e A [N s/m],      K(f) = −(2πf)² m_a A [N/m],

so that damping and apparent mass both follow frequency, in SOL 108 and SOL 111 alike. The stiffness
without frequency is 0: modes are those of the panel without particles. Units are N, m, s.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Flags, Index
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.sound.field import lumped_area

FIELDS_PER_LINE = 4


def large_field_table(
    card: str, number: int, options: Sequence[str], x: Array, y: Array
) -> Iterator[str]:
    """Yield the lines of a table card such as TABRND1 or TABDMP1, each with its line end.

    Examples
    --------
    >>> print("".join(large_field_table("TABDMP1", 1, ["CRIT"], np.array([64.9]),
    ...                                 np.array([0.01]))).replace(" ", "."))
    TABDMP1*...............1............CRIT................................
    *
    *........6.490000000E+01.1.000000000E-02............ENDT
    <BLANKLINE>
    """
    fields = "".join(f"{option:>16}" for option in options)
    yield f"{card}*{number:16d}{fields:48}\n"
    yield "*\n"
    cells = [f"{value:16.9E}" for value in np.stack([x, y], axis=1).ravel()]
    cells.append(f"{'ENDT':>16}")
    for start in range(0, len(cells), FIELDS_PER_LINE):
        yield "*       " + "".join(cells[start : start + FIELDS_PER_LINE]) + "\n"


def modal_damping_ratio(
    damping_ratio: float | Array,
    natural_frequency: Array,
    modal_mass: Array,
    overlap: Array,
    equivalent_damping: Array,
) -> Array:
    """Return ζ_i (n,) of the modes with one damper more.

    Examples
    --------
    >>> modal_damping_ratio(0.01, np.array([100.0]), np.array([1.5]), np.array([0.04]),
    ...                     np.array([300 * np.pi]))
    array([0.03])
    """
    omega = 2 * np.pi * natural_frequency
    return damping_ratio + equivalent_damping * overlap / (2 * modal_mass * omega)


def write_tabdmp1(path: Path, frequency: Array, ratios: Mapping[str, Array], title: str) -> None:
    """Write bulk data cards TABDMP1, large field, shares of critical damping over Hz.

    Tables are numbered from 1 in the order given. Modes of the same frequency, which a table cannot
    distinguish, have the mean of their values.
    """
    distinct, index = np.unique(np.round(frequency, 6), return_inverse=True)
    with path.open("w", encoding="ascii", errors="replace") as file:
        file.write(f"$ {title}\n$ modal damping, share of critical, over natural frequency, Hz\n")
        for number, (name, ratio) in enumerate(ratios.items(), start=1):
            mean = np.bincount(index, ratio) / np.bincount(index)
            file.write(f"$ {name}\n")
            file.writelines(large_field_table("TABDMP1", number, ["CRIT"], distinct, mean))


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
            name: grid_areas(vertices, cells[cell_in_patch[name]]).round(12) for name in dampers
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


def grid_areas(vertices: Array, cells: Index) -> Array:
    """Return areas of the vertices (n_vertices,) that integrate quadratics exactly over cells [m²].

    The least changes, relative to the equal shares of each cell, that do so; where there are too
    few vertices for positive ones, these shares.
    """
    share = lumped_area(vertices, cells)
    on = np.flatnonzero(share)
    centre, extent = vertices[on].mean(axis=0), np.ptp(vertices[on], axis=0).max()

    def monomials(position: Array) -> Array:
        x, y = ((position - centre) / extent).T
        return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])

    # exact for quadratics on triangles (midpoints) and rectangles (and a third at the centre)
    corners = vertices[cells]
    midpoints = (corners + np.roll(corners, 1, axis=1)) / 2
    area, at_centre = np.abs(cell_areas(vertices, cells)), 0.0 if cells.shape[1] == 3 else 1 / 3
    weight = np.repeat((1 - at_centre) / cells.shape[1] * area, cells.shape[1])
    exact = monomials(midpoints.reshape(-1, 2)) @ weight
    exact += monomials(corners.mean(axis=1)) @ (at_centre * area)
    rows = monomials(vertices[on])
    missing = exact - rows @ share[on]
    change = 1 + rows.T @ np.linalg.lstsq((rows * share[on]) @ rows.T, missing)[0]
    if on.size > len(rows) and change.min() > 0:
        share[on] *= change
    return share


def _property(number: int, frequency: Array, stiffness: Array, damping: Array) -> Iterator[str]:
    """Yield a property along z, with tables of its number and the next."""
    yield f"PBUSH   {number:8d}       K{'':16}{0.0:8.1f}\n"
    yield f"PBUSHT  {number:8d}       K{'':16}{number:8d}\n"
    yield f"{'':16}       B{'':16}{number + 1:8d}\n"
    for table, values in enumerate((stiffness, damping), start=number):
        yield from large_field_table("TABLED1", table, LINEAR, frequency, values)
