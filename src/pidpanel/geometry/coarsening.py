"""Triangles of a wanted size on the mesh of a surface."""

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import edge_lengths

# Longest edge of the fine mesh over the wanted one, and least distance of vertices over the latter.
FINENESS, SPACING = 0.3, 0.87

# Size at a rim over that far from it, and its growth over the distance.
RIM_SIZE, GROWTH = 0.5, 0.4

JITTER, ATTEMPTS = 0.05, 9  # share of lengths that is drawn, and draws

# Vertices stay where unit vectors along a line add up to more than this, a turn by 40°; edges where
# the cosine between normals is less, a fold by 30°.
TURN, FOLD = 0.7, 0.87


def rims(triangles: Index, count: int) -> tuple[Index, Index]:
    """Return the edges (k, 2) that have one triangle, and that triangle (k,).

    Raises
    ------
    ValueError
        If an edge has more than two triangles, or two of opposite sense.
    """
    edges = np.concatenate([triangles, np.roll(triangles, -1, axis=1)]).reshape(2, -1).T
    key, reverse = edges @ [count, 1], edges @ [1, count]
    ordered = np.sort(key)
    if (np.diff(ordered) == 0).any():
        raise ValueError(
            "free edges of a surface: an edge has triangles of opposite sense or more than two; "
            "allowed is a surface of one sheet whose triangles turn alike"
        )
    place = np.minimum(np.searchsorted(ordered, reverse), key.size - 1)
    rim = np.flatnonzero(ordered[place] != reverse)
    return edges[rim], rim // 3


def remeshed(vertices: Array, triangles: Index, edge: float) -> tuple[Array, Index]:
    """Return vertices (nv, 3) [m] and triangles (nt, 3) on a surface, of about this edge [m].

    Vertices are some of a mesh that is divided until it is fine: rims and folds first, then by rows
    inwards, where triangles grow. Each has the region that is nearest to it along the surface;
    where three regions meet is a triangle. Lengths are drawn again where the mesh has other holes
    than the surface.
    """
    holes = _euler(vertices, triangles)
    while edge_lengths(vertices, triangles).max() > FINENESS * RIM_SIZE * edge:
        vertices, triangles = _divided(vertices, triangles)
    for attempt in range(ATTEMPTS):
        points, cells = _dual(vertices, triangles, edge, np.random.default_rng(attempt))
        try:
            if _euler(points, cells) == holes:
                break
        except ValueError:
            pass
    else:
        raise ValueError(f"free edges of a surface: no mesh of {edge:g} m was found on it")
    return points, cells


def _euler(vertices: Array, triangles: Index) -> int:
    """Return the vertices less the edges plus the triangles."""
    rim, _ = rims(triangles, len(vertices))
    return np.unique(triangles).size - (3 * len(triangles) + len(rim)) // 2 + len(triangles)


def _dual(
    vertices: Array, triangles: Index, edge: float, rng: np.random.Generator
) -> tuple[Array, Index]:
    rim, _ = rims(triangles, len(vertices))
    lines = np.concatenate([rim, _kinks(vertices, triangles)])
    border, graph = _symmetric(vertices, lines), _graph(vertices, triangles)
    graph.data *= rng.uniform(1, 1 + JITTER, graph.nnz)
    ends, start = np.unique(lines), np.union1d(_corners(vertices, lines), _first(border))
    order = [start, _order(border, start), _order(graph, ends), _order(graph, _first(graph))]
    limit = np.full(len(vertices), SPACING * edge)
    if len(rim):
        distance = csgraph.dijkstra(graph, indices=np.unique(rim), min_only=True)
        limit *= np.minimum(RIM_SIZE + GROWTH * distance / edge, 1)
    free, seeds = np.ones(len(vertices), bool), np.zeros(0, np.int64)
    for vertex in np.concatenate(order):
        if free[vertex]:
            seeds = np.append(seeds, vertex)
            distance = csgraph.dijkstra(graph, indices=vertex, limit=limit[vertex])
            free[np.isfinite(distance)] = False
    seeds = np.sort(seeds)
    nearest = _nearest(graph, seeds)
    if ends.size:  # no region beside a line reaches it
        nearest[ends] = _nearest(border, np.intersect1d(seeds, ends))[ends]
    cells = np.searchsorted(seeds, nearest[triangles])
    cells = cells[np.all(cells != np.roll(cells, 1, axis=1), axis=1)]
    # parts of a region that are cut off add a triangle and its reverse
    sense = np.prod(np.sign(np.roll(cells, -1, axis=1) - cells), axis=1)
    cells, number = np.unique(np.sort(cells, axis=1), axis=0, return_inverse=True)
    net = np.bincount(number.ravel(), weights=-sense)
    cells[net < 0] = cells[net < 0][:, ::-1]
    return vertices[seeds], cells[net != 0]


def _divided(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Divide each triangle into four."""
    pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    edges, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    a, b, c = triangles.T
    ab, bc, ca = len(vertices) + number.reshape(-1, 3).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    fine = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.concatenate([vertices, vertices[edges].mean(axis=1)]), fine


def _symmetric(vertices: Array, edges: Index) -> sparse.csr_array:
    length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    ends = tuple(edges.T.astype(np.int32))  # as dijkstra takes them, again and again
    matrix = sparse.csr_array((length, ends), (len(vertices),) * 2)
    return matrix.maximum(matrix.T).tocsr()


def _neighbours(values: Index, triangles: Index) -> tuple[Index, Index, Index]:
    """Return inner edges (k, 2), and what a number (nt, 3) of edges is on both sides (k,)."""
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    table = sparse.csr_array((values.ravel() + 1, tuple(edges.T)), (triangles.max() + 1,) * 2)
    inner = (table * (table.T > 0)).tocoo()
    right = np.asarray(table.T.tocsr()[inner.row, inner.col]).ravel()
    once = inner.row < inner.col
    edges = np.stack([inner.row, inner.col], axis=1)[once].astype(np.int64)
    return edges, inner.data[once] - 1, right[once] - 1


def _graph(vertices: Array, triangles: Index) -> sparse.csr_array:
    """Return distances along edges and from vertices to those behind the opposite edge."""
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    _, *behind = _neighbours(np.roll(triangles, 1, axis=1), triangles)
    return _symmetric(vertices, np.concatenate([edges, np.stack(behind, axis=1)]))


def _kinks(vertices: Array, triangles: Index) -> Index:
    """Return the edges (k, 2) at which the surface folds."""
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    number = np.repeat(np.arange(len(triangles))[:, None], 3, axis=1)
    edges, left, right = _neighbours(number, triangles)
    return edges[np.sum(normal[left] * normal[right], axis=1) < FOLD]


def _corners(vertices: Array, lines: Index) -> Index:
    """Return the vertices at which lines end, meet or turn sharply."""
    step = vertices[lines[:, 1]] - vertices[lines[:, 0]]
    step = np.pad(step / np.linalg.norm(step, axis=1, keepdims=True), ((0, 0), (0, 1)))
    total = np.zeros((len(vertices), 4))
    for end, sense in zip(lines.T, (1, -1), strict=True):
        step[:, 3] = sense
        np.add.at(total, end, sense * step)
    bent = np.linalg.norm(total[:, :3], axis=1) > TURN
    return np.flatnonzero((total[:, 3] > 0) & (bent | (total[:, 3] != 2)))


def _first(graph: sparse.csr_array) -> Index:
    """Return a vertex of each connected part that has edges."""
    _, label = csgraph.connected_components(graph)
    used = np.flatnonzero(np.diff(graph.indptr))
    return used[np.unique(label[used], return_index=True)[1]]


def _nearest(graph: sparse.csr_array, seeds: Index) -> Index:
    sources: Index = csgraph.dijkstra(
        graph, indices=seeds, min_only=True, return_predecessors=True
    )[2]
    return sources


def _order(graph: sparse.csr_array, start: Index) -> Index:
    """Return the vertices that can be reached, by their distance."""
    if not start.size:
        return start
    distance = csgraph.dijkstra(graph, indices=start, min_only=True)
    order = np.argsort(distance, kind="stable")
    return order[np.isfinite(distance[order])]
