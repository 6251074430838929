"""Places of a grid on a panel."""

import numpy as np
import pytest
import scipy.sparse as sp
import shapely

from pidpanel.optimise.places import NoPlace, Places, overlaps_of, places_on

PANEL = shapely.box(0, 0, 1.5, 1.0)


def test_a_grid_covers_the_panel_to_its_edges():
    places = places_on(PANEL, (0.2, 0.2), (0.1, 0.1), [])
    assert len(places.lower) == 14 * 9
    assert places.centre.min(axis=0) == pytest.approx([0.1, 0.1])
    assert places.centre.max(axis=0) == pytest.approx([1.4, 0.9])


def test_a_grid_begins_at_the_corner_of_the_panel_wherever_that_is():
    places = places_on(shapely.box(1.0, 2.0, 2.5, 3.0), (0.2, 0.2), (0.1, 0.1), [])
    from_corner = places_on(PANEL, (0.2, 0.2), (0.1, 0.1), []).lower
    np.testing.assert_allclose(places.lower, np.add(from_corner, [1.0, 2.0]))
    for size in ((1.6, 0.2), (0.2, 1.1)):
        with pytest.raises(NoPlace, match="larger than the panel"):
            places_on(shapely.box(1.0, 2.0, 2.5, 3.0), size, (0.1, 0.1), [])


@pytest.mark.parametrize("spacing", [(0.1, 0.1), (0.07, 0.15)])
def test_places_overlap_where_their_areas_do(spacing):
    places = places_on(PANEL, (0.2, 0.3), spacing, [])
    boxes = shapely.box(*places.lower.T, *np.add(places.lower, [0.2, 0.3]).T)
    common = shapely.area(shapely.intersection(boxes[:, None], boxes))
    np.testing.assert_array_equal(places.overlap, common > 1e-6)
    assert places.area == pytest.approx(0.06)


def test_no_place_meets_a_hole_a_support_or_leaves_the_outline():
    hole = shapely.box(0.6, 0.4, 0.8, 0.6)
    support = shapely.Point(0.3, 0.3)
    panel = shapely.Polygon([(0, 0), (1.5, 0), (1.5, 1), (0.75, 1)]).difference(hole)
    places = places_on(panel, (0.2, 0.2), (0.1, 0.1), [support])
    boxes = shapely.box(*places.lower.T, *(places.lower + 0.2).T)
    assert len(boxes) > 10
    assert shapely.area(shapely.intersection(boxes, panel)) == pytest.approx(0.04)
    assert not shapely.contains_properly(boxes, support).any()
    # touching the hole along its edge is allowed
    assert (shapely.distance(boxes, hole) < 1e-9).any()


def test_a_group_has_places_that_all_overlap():
    for spacing in ((0.1, 0.1), (0.07, 0.2), (0.2, 0.05)):
        places = places_on(PANEL, (0.2, 0.2), spacing, [])
        same = places.group[:, None] == places.group
        assert np.all(places.overlap[same])
        assert not places.overlap.all()
        assert len(np.unique(places.group)) == 35  # 7 × 5 places fit side by side


@pytest.mark.parametrize(
    ("size", "obstacles", "message"),
    [((1.6, 0.2), [], "larger than the panel, 1.5 m × 1 m"), ((0.2, 0.2), [PANEL], "no place")],
)
def test_a_panel_without_room_is_refused(size, obstacles, message):
    with pytest.raises(NoPlace, match=message):
        places_on(PANEL, size, size, obstacles)


def test_a_place_between_elements_keeps_its_area():
    x = np.linspace(0.005, 1.495, 150)
    position = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    places = places_on(PANEL, (0.205, 0.205), (0.5, 0.5), [])
    ones = sp.csr_array(np.ones((len(position), 1)))
    weight, overlap, error = overlaps_of(places, position, np.full(len(position), 1e-4), ones)
    assert [matrix.sum() for matrix in overlap] == pytest.approx(places.area)
    assert weight.sum(axis=1) == pytest.approx(places.area)
    assert 0 < error.max() < 0.06


def test_patches_overlap_where_they_have_cells_in_common():
    cells = np.array([[1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 0, 1]], dtype=bool)
    places = Places(
        np.zeros((3, 2)), np.ones((3, 2)), np.arange(3), names=("a", "b", "c"), cells=cells
    )
    np.testing.assert_array_equal(places.overlap, [[1, 1, 0], [1, 1, 0], [0, 0, 1]])
    assert places.subset(np.array([1, 2])).names == ("b", "c")
    x = np.arange(8.0)
    weight, _, error = overlaps_of(
        places, np.stack([x, x], axis=1), np.full(8, 0.1), sp.csr_array(np.ones((8, 1)))
    )
    np.testing.assert_allclose(weight.sum(axis=1), [0.4, 0.4, 0.2])  # two points in each cell
    assert error.max() == 0
