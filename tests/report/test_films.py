"""The film of a coupon: spheres in their cells, seen from the side, coloured by their speed."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.coupon import geometry
from pidpanel.coupon.from_study import cases_of
from pidpanel.paths import STUDIES
from pidpanel.report import films
from pidpanel.study import load_any_study

PACKING = cases_of(load_any_study(STUDIES / "smoke.yaml").coupon)[0].point.packing
WIDTH, DEPTH = PACKING.across_flats, PACKING.depth


def frames(positions, values, lift=(0.0,), count=1):
    places = np.array([positions] * len(lift), dtype=float)
    colours = np.array([values] * len(lift), dtype=float)
    diameters = np.full(len(positions), WIDTH / 2)
    packing = replace(PACKING, count=count)
    return [
        np.asarray(image).astype(int)
        for image in films.drawn_frames(places, diameters, colours, packing, np.array(lift))
    ]


def coloured(image):
    return np.ptp(image, axis=-1) > 60


def test_spheres_have_the_colour_of_their_value():
    # red: a fixed colour
    place = [[0.0, 0.0, DEPTH / 2]]
    (slow,), (fast,) = frames(place, [0.1]), frames(place, [0.9])
    both = coloured(slow) & coloured(fast)
    assert both.mean() > 0.05
    change = (fast - slow)[both].mean(axis=0)
    assert change[0] > 30  # plasma runs from blue to yellow
    assert change[2] < -30


def test_the_nearest_sphere_is_over_the_others():
    # red: `-` left out of the order
    behind, before = [0.0, WIDTH / 4, DEPTH / 2], [0.0, -WIDTH / 4, DEPTH / 2]
    (alone,), (both,) = frames([before], [0.9]), frames([behind, before], [0.1, 0.9])
    middle = tuple(size // 2 for size in alone.shape[:2])
    assert (alone[middle] == both[middle]).all()
    assert coloured(both)[middle]


def test_a_cell_that_moves_up_is_higher_with_its_spheres():
    # red: the height of the first frame for all
    lift = (0.0, DEPTH / 6, DEPTH / 6, -DEPTH / 6)
    images = frames([[0.0, 0.0, DEPTH / 2]], [0.5], lift)
    heights = [-np.flatnonzero(coloured(image).any(axis=1)).mean() for image in images]
    assert heights[1] == heights[2] > heights[0] + 5
    assert heights[0] - heights[3] == pytest.approx(heights[1] - heights[0], abs=1)


def test_cells_are_in_a_row_with_their_own_spheres():
    # red: every sphere moved like the first cell
    packing = replace(PACKING, count=5)
    centres = np.pad(geometry.cell_centres(WIDTH, 5), ((0, 0), (0, 1)))
    offset = np.array([1e-4, -2e-4, 4e-4])
    inside, shift = films.in_a_row(centres + offset, packing)
    assert inside.tolist() == [True, True, False, False, False]
    moved = (centres + offset)[inside] + shift
    middles = np.outer([0, films.ROW_PITCH * WIDTH], [1, 0, 0])
    assert moved == pytest.approx(middles + offset)


def test_the_case_of_the_film_succeeded_and_is_nearest_to_half_fill(cases):
    # red: the status not looked at
    cases["fill_fraction"] += 0.1
    nearest = films.nearest_case(cases)
    assert nearest == "r0.3_f100Hz_a12g"  # now of r = 0.4
    cases.loc[cases["case"] == nearest, "status"] = "NotSteady"
    assert films.nearest_case(cases) != nearest
