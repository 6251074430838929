"""Whether the elements of a mesh file cover the panel once and join along whole edges.

Whatever else stands in a file falsifies the modes without a trace: a second layer of elements
doubles stiffness and mass, nodes that were not merged leave a slit. Where no edge has more than two
elements, one on each side, and the boundary does not cross itself, no two elements overlap.
"""

import numpy as np
import scipy.sparse as sp
import shapely
from scipy.sparse.csgraph import connected_components

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.geometry.polygon import show, signed_area
from pidpanel.panel.supports import boundary_loops

# Distance of a node from an edge of other elements over its length: nearer, the gap is a slit
# of nodes that were not merged. A slit 1e-3 wide is as wrong as one of 1e-8.
SLIT = 2e-3
OVERLAP = 1e-6  # likewise, on the other side of the edge
AT_ONCE = 64  # edges


def check_connectivity(node: Index, element: Index, position: Array, triangles: Index) -> None:
    """Refuse elements that overlap or do not join along whole edges.

    Parameters
    ----------
    node, position
        Numbers (n,) in the file and positions (n, 2).
    element, triangles
        Numbers (m,) in the file and corners (m, 3), counter-clockwise.

    Raises
    ------
    ValueError
        With the elements or nodes and their place.
    """
    _check_layers(element, position, triangles)
    _check_slits(node, position, triangles)
    _check_one_piece(element, triangles)
    _check_boundary(position, triangles)


def _edges(triangles: Index) -> Index:
    """Return the edges (3 m, 2) of all triangles, in their direction; those of one side by side."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)


def _check_layers(element: Index, position: Array, triangles: Index) -> None:
    """Refuse two triangles on the same side of an edge."""
    _, first, count = np.unique(_edges(triangles), axis=0, return_index=True, return_counts=True)
    if count.max() == 1:
        return
    edges = _edges(triangles)
    edge = edges[first[np.argmax(count > 1)]]
    pair = element[np.flatnonzero((edges == edge).all(axis=1)) // 3]
    raise ValueError(
        f"elements {pair[0]} and {pair[1]} overlap at {show(position[edge].mean(axis=0))}: the"
        " panel would count twice there; a place has one element"
    )


def _check_slits(node: Index, position: Array, triangles: Index) -> None:
    """Refuse nodes of the boundary at an edge of it that is not theirs."""
    edges = boundary_edges(triangles)
    vertices = np.unique(edges)
    start, end = position[edges].transpose(1, 0, 2)
    length = np.linalg.norm(end - start, axis=1)
    along = (end - start) / length[:, None]
    tree = shapely.STRtree(shapely.points(position[vertices]))
    lines = shapely.linestrings(position[edges])
    joined = None
    for begin in range(0, len(edges), AT_ONCE):  # nodes at one place make many pairs
        part = slice(begin, begin + AT_ONCE)
        row, near = tree.query(lines[part], predicate="dwithin", distance=SLIT * length[part])
        row, vertex = row + begin, vertices[near]
        across = position[vertex] - start[row]
        # the element of an edge is to its left
        left = (along[row, 0] * across[:, 1] - along[row, 1] * across[:, 0]) / length[row]
        is_slit = (left <= OVERLAP) & (vertex[:, None] != edges[row]).all(axis=1)
        for k, number in sorted(zip(row[is_slit].tolist(), vertex[is_slit].tolist(), strict=True)):
            gap = np.linalg.norm(position[edges[k]] - position[number], axis=1)
            closest = int(edges[k, np.argmin(gap)])
            place = show(position[number])
            if gap.min() > SLIT * length[k]:
                a, b = sorted(node[edges[k]].tolist())
                raise ValueError(
                    f"node {node[number]} at {place} is on the edge between nodes {a} and {b}, but"
                    " its element is not joined there: the panel is cracked; elements must share"
                    " whole edges"
                )
            if joined is None:
                joined = set(map(tuple, np.sort(_edges(triangles)).tolist()))
            if (min(closest, number), max(closest, number)) not in joined:
                a, b = sorted((int(node[closest]), int(node[number])))
                apart = f"{gap.min():.2g} m apart at" if gap.min() > 0 else "at one place"
                raise ValueError(
                    f"nodes {a} and {b} are {apart} {place}: the panel is cracked there; merge them"
                )


def _check_one_piece(element: Index, triangles: Index) -> None:
    """Refuse a mesh whose elements are not all joined by edges."""
    _, edge = np.unique(np.sort(_edges(triangles)), axis=0, return_inverse=True)
    owner = np.repeat(np.arange(len(triangles)), 3)
    owned = sp.csr_array((np.ones(len(owner)), (owner, edge.ravel())))
    count, piece = connected_components(owned @ owned.T, directed=False)
    if count > 1:
        separate = element[np.argmax(piece != piece[0])]
        raise ValueError(
            f"the mesh has {count} pieces: no edges join element {separate} to element"
            f" {element[0]}; a panel is one piece"
        )


def _check_boundary(position: Array, triangles: Index) -> None:
    """Refuse a boundary that crosses itself."""
    loops = [position[loop] for loop in boundary_loops(position, triangles)]
    outer = [loop for loop in loops if signed_area(loop) > 0]
    holes = [loop for loop in loops if signed_area(loop) <= 0]
    outline = shapely.Polygon(outer[0], holes) if len(outer) == 1 else shapely.MultiPolygon()
    if not outline.is_valid or len(outer) != 1:
        # GEOS states the place in square brackets
        place = shapely.is_valid_reason(outline).partition("[")[2].rstrip("]").split()
        where = f" at {show([float(value) for value in place])}" if len(place) == 2 else ""
        raise ValueError(f"the edge of the panel crosses itself{where}: elements overlap there")
