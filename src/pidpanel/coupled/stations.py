"""Stations of a patch: points where cells are simulated, each representing a part of its area."""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index


@dataclass(frozen=True)
class Stations:
    """Points that represent the parts of a patch."""

    point: Index  # (k,) index of each among the points of the patch
    area: Array  # (k,) area of its part [m²]; they add up to that of the patch


def stations_of(position: Array, weight: Array, count: int) -> Stations:
    """Return stations of a patch of any outline.

    The points of a quadrature are halved along the longer side of their extent, in proportion to
    the number of stations in each half, until each part has one: the point nearest its middle.
    The force of its cells acts on the modes as ∫ φ p dA ≈ Σ φ(x_k) a_k p_k, the midpoint rule.

    Examples
    --------
    >>> x = np.array([[0.1, 0.0], [0.2, 0.0], [0.3, 0.0], [0.7, 0.0], [0.8, 0.0], [0.9, 0.0]])
    >>> found = stations_of(x, np.full(6, 0.5), 2)
    >>> found.point.tolist(), found.area.tolist()
    ([1, 4], [1.5, 1.5])
    """
    if not 1 <= count <= len(weight):
        raise ValueError(f"{count} stations of a patch with {len(weight)} points")
    point, area = [], []
    for part in _parts(position, weight, np.arange(len(weight)), count):
        middle = weight[part] @ position[part] / weight[part].sum()
        nearest = np.argmin(((position[part] - middle) ** 2).sum(axis=1))
        point.append(part[nearest])
        area.append(weight[part].sum())
    return Stations(np.array(point), np.array(area))


def _parts(position: Array, weight: Array, part: Index, count: int) -> list[Index]:
    if count == 1:
        return [part]
    first = (count + 1) // 2
    extent = np.ptp(position[part], axis=0)
    # rounded, so that points of one column do not differ in their last digits
    size = max(float(extent.max()), 1e-300)
    along = np.round(position[part] / size, 9)
    axis = int(np.argmax(np.round(extent / size, 6)))
    order = np.lexsort((along[:, 1 - axis], along[:, axis]))
    share = np.cumsum(weight[part][order]) / weight[part].sum()
    cut = int(np.searchsorted(share, first / count - 1e-9)) + 1
    cut = min(max(cut, first), len(part) - (count - first))
    halves = (part[order[:cut]], first), (part[order[cut:]], count - first)
    return [piece for half, number in halves for piece in _parts(position, weight, half, number)]
