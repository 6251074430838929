"""Stations share a patch out evenly, whatever its outline."""

import numpy as np
import pytest

from pidpanel.coupled.stations import stations_of


def grid(inside, n=40):
    x = (np.arange(n) + 0.5) / n
    points = np.array([[a, b] for a in x for b in x])
    points = points[inside(*points.T)]
    return points, np.full(len(points), 1 / n**2)


OUTLINES = {
    "square": lambda x, y: x > -1,
    "L": lambda x, y: (x < 0.5) | (y < 0.5),
    "strip": lambda x, y: y < 0.1,
    "disc": lambda x, y: (x - 0.5) ** 2 + (y - 0.5) ** 2 < 0.25,
}


@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize("count", [1, 5, 16])
def test_every_station_stands_for_the_same_area_and_all_for_the_patch(outline, count):
    # red: `first = 1` in `_parts`, with which areas come out as halves, quarters, eighths
    position, weight = grid(OUTLINES[outline])
    found = stations_of(position, weight, count)
    assert found.area.sum() == pytest.approx(weight.sum(), rel=1e-12)
    # a column of the grid is the least that can be cut: two cuts of 40 points of 1/1600
    assert np.ptp(found.area) <= 0.12 * found.area.mean() + 4 / 1600
    assert len(set(found.point.tolist())) == count


@pytest.mark.parametrize("outline", OUTLINES)
def test_a_sum_over_stations_is_the_integral_over_the_patch(outline):
    # the midpoint rule errs by (2κh)²/24 of what oscillates, 5 % for half a wave in four parts
    # red: the first point of a part in place of the nearest to its middle (19 % for the square)
    position, weight = grid(OUTLINES[outline])
    found = stations_of(position, weight, 16)
    wave = np.sin(np.pi * position[:, 0]) * np.cos(2 * position[:, 1])
    exact = weight @ wave**2
    assert found.area @ wave[found.point] ** 2 == pytest.approx(exact, rel=0.06)


def test_more_stations_than_points_are_refused():
    # red: the check left out, after which the error is that of an empty slice
    with pytest.raises(ValueError, match="5 stations of a patch with 4 points"):
        stations_of(np.zeros((4, 2)), np.ones(4), 5)
