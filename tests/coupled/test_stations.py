"""Stations share a patch out evenly, whatever its outline."""

import numpy as np
import pytest

from pidpanel.coupled.excited_panel import stations_of


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
    position, weight = grid(OUTLINES[outline])
    found = stations_of(position, weight, count)
    assert found.area.sum() == pytest.approx(weight.sum(), rel=1e-12)
    # a column of the grid is the least that can be cut: two cuts of 40 points of 1/1600
    assert np.ptp(found.area) <= 0.12 * found.area.mean() + 4 / 1600
    assert len(set(found.point.tolist())) == count


@pytest.mark.parametrize("outline", OUTLINES)
def test_a_sum_over_stations_is_the_integral_over_the_patch(outline):
    # the midpoint rule errs by (2κh)²/24 of what oscillates, 5 % for half a wave in four parts
    position, weight = grid(OUTLINES[outline])
    found = stations_of(position, weight, 16)
    wave = np.sin(np.pi * position[:, 0]) * np.cos(2 * position[:, 1])
    exact = weight @ wave**2
    assert found.area @ wave[found.point] ** 2 == pytest.approx(exact, rel=0.06)


def test_more_stations_than_points_are_refused():
    with pytest.raises(ValueError, match="5 stations of a patch with 4 points"):
        stations_of(np.zeros((4, 2)), np.ones(4), 5)


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("shape", [(1.0, 1.0 + 2e-7), (1.0, 0.05), (0.05, 1.0)])
def test_stations_do_not_depend_on_the_size_of_a_patch_or_on_its_last_digits(size, shape):
    # columns that differ by 2e-10, of which some are cut; a square that is longer in y by 2e-7 is
    # cut across x as others are; weights tell which points a part has
    rng = np.random.default_rng(1)
    place = np.array([(a, b) for a in np.arange(5) / 4 for b in np.arange(5) / 4])
    weight = 1 + 0.1 * rng.random(25)
    wanted = stations_of(place * np.round(shape, 3), weight, 2)
    rough = place * shape + 2e-10 * rng.choice([-1, 1], (25, 2))
    rough[0], rough[-1] = (0.0, 0.0), shape
    found = stations_of(size * rough, weight, 2)
    assert found.area.tolist() == pytest.approx(wanted.area.tolist(), rel=1e-12)


def test_a_heavy_point_leaves_points_for_all_stations():
    place = np.stack([np.arange(5.0), np.zeros(5)], axis=1)
    found = stations_of(place, np.array([1.0, 1.0, 1.0, 1.0, 100.0]), 4)
    assert len(set(found.point.tolist())) == 4
    assert found.area.sum() == pytest.approx(104.0)
