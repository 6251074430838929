"""The shapes of cells that there are."""

from typing import get_args

import numpy as np
import pytest

from pidpanel.geometry.cells import SHAPES, ShapeName
from pidpanel.study.coupon import Cell


def test_every_name_a_study_may_say_has_a_shape():
    assert set(get_args(ShapeName)) == set(SHAPES)
    for name in SHAPES:
        assert Cell(shape=name).shape == name


@pytest.mark.parametrize("name", SHAPES)
def test_an_outline_is_convex_and_goes_round_the_origin_anticlockwise(name):
    outline = SHAPES[name].outline(6e-3)
    following = np.roll(outline, -1, axis=0)
    assert len(outline) == SHAPES[name].corners
    assert (outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0] > 0).all()
    np.testing.assert_allclose(np.linalg.norm(outline, axis=1), np.linalg.norm(outline[0]))


@pytest.mark.parametrize(
    ("name", "area"), [("hexagon", np.sqrt(3) / 2), ("square", 1.0), ("circle", np.pi / 4)]
)
def test_an_outline_has_the_area_and_the_width_of_its_cell(name, area):
    # the polygon with the area of a circle is 0.3 % narrower across its flats
    outline = SHAPES[name].outline(6e-3)
    x, y = outline.T
    found = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    assert found == pytest.approx(area * 6e-3**2, rel=1e-12)
    assert np.ptp(x) == pytest.approx(6e-3, rel=4e-3 if name == "circle" else 1e-12)
